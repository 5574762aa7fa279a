"""Properties of haptic sources."""

from __future__ import annotations

from bpy.props import PointerProperty
from bpy.types import PropertyGroup

from ...core.scene.values import Source
from .callbacks import changed, object_changed, updating
from .declared import holding
from .drawing import drawing_property
from .kinds import choice, file_path, limited, share, switch, text
from .signal_kinds import HERTZ, PLAIN
from .sound import HapticSoundProperties

SIGNAL_ITEMS = (
    *((kind, plain.label, plain.about, "", plain.number) for kind, plain in PLAIN.items()),
    ("FILE", "WAV File", "A recorded signal", "", 3),
    ("DRAWN", "Drawn", "Amplitude and frequency as curves", "", 4),
    ("SOUND", "Sound", "Vibration that follows the loudness, pitch and onsets of a sound", "", 5),
    ("KEPT", "Imported", "The vibration of an imported file, kept in this one", "", 6),
    (
        "BLAST",
        "Blast",
        "The pressure wave of a shot or an explosion, whose overpressure lasts for the decay "
        "time (Friedlander)",
        "",
        7,
    ),
)


@updating(object_changed)
@holding(Source)
class HapticSourceProperties(PropertyGroup):
    """A haptic source, which emits a signal."""

    reasons = {
        "muted": "mute",
        "solo": "mute",
        "filepath": "file",
        "drawing": "file",
        "trigger_markers": "editors who mark moments in the timeline",
        "priority": "what counts more in a weighted mix",
    }

    enabled: switch("Haptic Source", "This object emits a haptic signal", update=changed)
    muted: switch("Mute", "Keep the source but silence it")
    solo: switch(
        "Solo",
        "Silence all sources that are not solo, and impacts",
        options=set(),
        update=changed,
    )
    signal: choice("Signal", "What the source emits", SIGNAL_ITEMS, default="SINE")
    frequency: limited(
        "Frequency (Hz)",
        "Vibrations or blows per second, in hertz; the skin feels 20 to 1000 Hz, best around 250 "
        "Hz",
        60.0,
        HERTZ,
        soft_min=10.0,
        soft_max=500.0,
    )
    kept: text("Kept", "The imported vibration as JSON", options={"HIDDEN"}, update=object_changed)
    drawing: drawing_property()
    filepath: file_path("WAV File", "The recorded signal, looped")
    sound: PointerProperty(type=HapticSoundProperties)
    decay: limited(
        "Decay Time (s)",
        "Time constant of an exponential decay from the first frame on: after this many seconds "
        "the amplitude is 37%; 0 means no decay",
        0.0,
        (0.0, 1e6),
        soft_max=60.0,
        precision=3,
    )
    one_shot: switch(
        "Once per Trigger", "Silent until a trigger below plays the signal, once per trigger"
    )
    trigger: share(
        "Trigger",
        "Plays at each keyframe above 0, with its value as the strength; with a driver, whenever "
        "the value rises above 0",
        0.0,
    )
    trigger_markers: text(
        "Markers",
        "Plays at the timeline markers of this name; * stands for any characters, ? for one",
        options=set(),
    )
