"""Properties of a scene's bake."""

from __future__ import annotations

from bpy.props import CollectionProperty, PointerProperty
from bpy.types import PropertyGroup, Sound, Text

from .callbacks import view_changed
from .kinds import FRAMES, reference, switch, text, whole


def _track() -> PointerProperty[Text]:
    words = "Where the haptic track is kept: a text with the track as its property"
    return reference(Text, "Track", words)


class HapticTake(PropertyGroup):
    """A bake that is stored under a name."""

    name: text("Name", "Name of the take")
    track: _track()


class HapticBakeProperties(PropertyGroup):
    """The bake of a scene."""

    takes: CollectionProperty(
        type=HapticTake, name="Takes", description="Bakes that are kept under a name"
    )
    compared: reference(Text, "Compared", "The take that was played before")

    track: _track()
    sound: reference(Sound, "Sound", "The track as sound, packed into the file")
    use_track: switch(
        "Play Baked Track",
        "While the timeline plays, read what is felt from the baked track instead of tracing; "
        "while it stands, the scene is traced",
        True,
        update=view_changed,
    )
    use_range: switch("Custom Range", "Bake these frames instead of the scene's frame range")
    frame_start: whole("Start", "First frame to bake", 1, FRAMES)
    frame_end: whole("End", "Last frame to bake", 250, FRAMES)
    write_sound: switch(
        "Add Sound Strip",
        "Add what is felt as a sound strip to the sequencer: left side of the body left, right "
        "side right",
    )
