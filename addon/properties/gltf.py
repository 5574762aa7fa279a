"""How haptics go into glTF files."""

from __future__ import annotations

from bpy.props import BoolProperty, StringProperty
from bpy.types import PropertyGroup


class HapticGltfProperties(PropertyGroup):
    """What is written when the scene is exported as glTF."""

    use_extras: BoolProperty(
        name="Haptics", description="Roles, haptic properties, functions and contacts, in the extras of nodes", default=True
    )
    use_material: BoolProperty(
        name="MPEG Haptic Material", description="Haptic materials of meshes as an extension of ISO/IEC 23090-14", default=False
    )
    material_name: StringProperty(
        name="Name", description="Of that extension: drafts of the standard differ", default="MPEG_haptic_material", maxlen=60
    )
