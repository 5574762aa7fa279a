"""Properties of the meters."""

from __future__ import annotations

from bpy.props import BoolProperty, EnumProperty
from bpy.types import PropertyGroup

from .callbacks import view_changed


class HapticMetersProperties(PropertyGroup):
    """The meters of a scene."""

    show: BoolProperty(
        name="Meters", description="Draw meters over the 3D viewport: how much each listener feels", default=True, update=view_changed
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
    show_lane: BoolProperty(
        name="Timeline of Touch",
        description="Draw over Timeline and Dope Sheet what each listener feels: waves and impacts of the frames baked or played, and in "
        "orange the threshold of feeling",
        default=True,
        update=view_changed,
    )
    corner: EnumProperty(
        name="Corner",
        description="Corner of the viewport in which the meters are drawn; the legend stands on the other side",
        items=(
            ("BOTTOM_LEFT", "Bottom Left", ""),
            ("BOTTOM_RIGHT", "Bottom Right", ""),
            ("TOP_LEFT", "Top Left", ""),
            ("TOP_RIGHT", "Top Right", ""),
        ),
        default="BOTTOM_LEFT",
        update=view_changed,
    )
    sort_path: BoolProperty(
        name="Sort by Loss", description="List the objects of a path by what they lose, the most first; else in their order", default=False
    )
