"""Settings of haptics in glTF files."""

from __future__ import annotations

from bpy.types import PropertyGroup

from .kinds import switch, text


class HapticGltfProperties(PropertyGroup):
    """The data that is written when the scene is exported as glTF."""

    use_extras: switch("Haptics", "Roles, haptic properties, functions and contacts, in the extras of nodes", True)
    use_material: switch("MPEG Haptic Material", "Haptic materials of meshes as an extension of ISO/IEC 23090-14")
    material_name: text("Name", "Name of that extension, because drafts of the standard differ", "MPEG_haptic_material", maxlen=60)
