"""What meters show."""

from __future__ import annotations

from bpy.props import BoolProperty
from bpy.types import PropertyGroup

from .callbacks import view_changed


class HapticMetersProperties(PropertyGroup):
    """The meters of a scene."""

    show: BoolProperty(
        name="Meters",
        description="Draw meters over the 3D viewport: how much each listener feels",
        default=True,
        update=view_changed,
    )
    show_scope: BoolProperty(
        name="Scope",
        description="Draw the last second of the selected listener, or of the one that feels the most",
        default=True,
        update=view_changed,
    )
    show_body: BoolProperty(
        name="Body", description="Draw a body whose parts light up where they feel something", default=True, update=view_changed
    )


CLASSES = (HapticMetersProperties,)
