"""Properties of a scene's bake, and those that a bake animates on listeners."""

from __future__ import annotations

from bpy.props import CollectionProperty, IntProperty, PointerProperty
from bpy.types import PropertyGroup, Sound, Text

from .callbacks import view_changed
from .kinds import number, switch, text


class HapticTake(PropertyGroup):
    """A bake that is stored under a name."""

    name: text("Name", "Name of the take")
    track: PointerProperty(
        type=Text,
        name="Track",
        description="Where the haptic track is kept: a text with the track as its property",
    )


class HapticBakeProperties(PropertyGroup):
    """The bake of a scene."""

    takes: CollectionProperty(
        type=HapticTake, name="Takes", description="Bakes that are kept under a name"
    )
    compared: PointerProperty(
        type=Text, name="Compared", description="The take that was played before"
    )

    track: PointerProperty(
        type=Text,
        name="Track",
        description="Where the haptic track is kept: a text with the track as its property",
    )
    sound: PointerProperty(
        type=Sound, name="Sound", description="The track as sound, packed into the file"
    )
    use_track: switch(
        "Play Baked Track",
        "While the timeline plays, read what is felt from the baked track instead of tracing; "
        "while it stands, the scene is traced",
        True,
        update=view_changed,
    )
    use_range: switch("Custom Range", "Bake these frames instead of the scene's frame range")
    frame_start: IntProperty(
        name="Start", description="First frame to bake", default=1, min=-1048574, max=1048574
    )
    frame_end: IntProperty(
        name="End", description="Last frame to bake", default=250, min=-1048574, max=1048574
    )
    write_curves: switch(
        "Write F-Curves",
        "Write intensity and frequency as F-curves on the listeners, to be seen in the graph "
        "editor and to drive others",
    )
    write_sound: switch(
        "Add Sound Strip",
        "Add what is felt as a sound strip to the sequencer: left side of the body left, right "
        "side right",
    )


class HapticFeltProperties(PropertyGroup):
    """Values that a bake animates on a listener."""

    intensity: number(
        "Intensity",
        "Strength that this listener feels: the amplitude of a sine of the same power. Written "
        "as an F-curve by Bake",
        0.0,
        (0.0, 1.0),
    )
    frequency: number(
        "Frequency (Hz)",
        "Vibrations per second that this listener feels, in hertz. Written as an F-curve by Bake",
        0.0,
        (0.0, 1000.0),
    )
