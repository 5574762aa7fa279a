"""Properties of a scene's bake."""

from __future__ import annotations

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import PropertyGroup, Text

from .callbacks import view_changed
from .kinds import reference, switch, text


def _track() -> PointerProperty[Text]:
    words = "Where the haptic track is kept: a text with the track as its property"
    return reference(Text, "Track", words, options={"HIDDEN"})


class HapticTake(PropertyGroup):
    """A bake that is stored under a name."""

    name: text("Name", "Name of the take")
    track: _track()


class HapticBakeProperties(PropertyGroup):
    """The bake of a scene."""

    reasons = {
        "use_track": "view",
    }

    takes: CollectionProperty(
        type=HapticTake, name="Takes", description="Bakes that are kept under a name"
    )
    compared: reference(Text, "Compared", "The take that was played before", options={"HIDDEN"})

    track: _track()
    use_track: switch(
        "Play Baked Track",
        "While the timeline plays, read what is felt from the baked track instead of tracing; "
        "while it stands, the scene is traced",
        True,
        update=view_changed,
    )
