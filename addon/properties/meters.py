"""Properties of the meters."""

from __future__ import annotations

from bpy.types import PropertyGroup

from .callbacks import updating, view_changed
from .kinds import choice, switch


@updating(view_changed)
class HapticMetersProperties(PropertyGroup):
    """The meters of a scene."""

    show: switch("Meters", "Draw meters over the 3D viewport: how much each listener feels", True)
    show_scope: switch("Scope", "Draw the last second of the selected listener, or of the one that feels the most", True)
    show_body: switch("Body", "Draw a body whose parts light up where they feel something", True)
    show_lane: switch(
        "Timeline of Touch",
        "Draw over Timeline and Dope Sheet what each listener feels: waves and impacts of the frames baked or played, and in "
        "orange the threshold of feeling",
        True,
    )
    corner: choice(
        "Corner",
        "Corner of the viewport in which the meters are drawn; the legend stands on the other side",
        (
            ("BOTTOM_LEFT", "Bottom Left", ""),
            ("BOTTOM_RIGHT", "Bottom Right", ""),
            ("TOP_LEFT", "Top Left", ""),
            ("TOP_RIGHT", "Top Right", ""),
        ),
        default="BOTTOM_LEFT",
    )
    sort_path: switch("Sort by Loss", "Sort the objects of a path by loss, largest first, instead of in path order", update=None)
