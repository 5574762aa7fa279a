"""The formats by name, with all that menus and command lines offer of them. The modules that write and read them are not imported here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .options import Option

MAX_SAMPLE_RATE = 192_000
"""Hertz, of tracks."""


@dataclass(frozen=True, slots=True)
class Format:
    """``label``: its name in menus. ``suffix``: of its files. ``module``: the module in `core.formats` that writes and reads it."""

    name: str
    label: str
    suffix: str
    module: str
    options: tuple[Option, ...] = ()


_ALL = (
    Format(
        "scene",
        "Haptic scene (JSON)",
        ".json",
        "haptic_scene",
        (
            Option("frames", True, "Frames", "Changes over time"),
            Option(
                "tracks", "none", "Tracks", "Rendered tracks: not written, in the file itself, or in a WAV file", ("none", "inline", "wav")
            ),
            Option("encoding", "pcm16", "Encoding", "Encoding of the tracks: 16 bit, or float", ("pcm16", "float32")),
            Option("compressed", False, "Compressed", "Write .json.gz"),
        ),
    ),
    Format(
        "wav",
        "WAV, a channel per listener",
        ".wav",
        "tracks.wav",
        (
            Option("encoding", "pcm16", "Encoding", "16 bit, or float without any loss of range", ("pcm16", "float32")),
            Option("sample_rate", 0, "Sample rate", "Hertz; 0: that of the tracks", (), 0, MAX_SAMPLE_RATE),
        ),
    ),
    Format(
        "ohm",
        "OHM and WAV, for the MPEG reference encoder",
        ".ohm",
        "tracks.ohm",
    ),
    Format(
        "hjif",
        "MPEG haptics (HJIF)",
        ".hjif",
        "tracks.hjif",
        (
            Option("profile", "Main", "Profile", "Main, or Simple Parametric, which more players take", ("Main", "Simple Parametric")),
            Option(
                "error", 0.03, "Error", "Power of the error in relation to the signal's that a keyframe may be left out for", (), 0.001, 0.5
            ),
            Option("transients", True, "Transients", "Impacts as transients, which devices may render as clicks"),
        ),
    ),
    Format(
        "wyvrn",
        "Razer Sensa / WYVRN (folder)",
        ".haps",
        "tracks.wyvrn",
        (
            Option(
                "error", 0.1, "Error", "Power of the error in relation to the signal's that a keyframe may be left out for", (), 0.001, 0.5
            ),
            Option("transients", True, "Transients", "Impacts as transients"),
        ),
    ),
    Format(
        "haptic",
        "Meta Haptics (.haptic)",
        ".haptic",
        "tracks.haptic",
        (
            Option("points", 40, "Points", "Breakpoints a second at most; 0: as many as the wave needs", (), 0, 80),
            Option("error", 0.05, "Error", "With 0 points: power of the error relative to the signal's", (), 0.001, 0.5),
            Option("frequency_min", 5.0, "Lowest frequency", "Hertz that the actuator plays for 0", (), 1.0, 500.0),
            Option("frequency_max", 500.0, "Highest frequency", "Hertz that the actuator plays for 1", (), 2.0, 1000.0),
            Option("emphasis", True, "Emphasis", "Impacts as emphasised breakpoints"),
        ),
    ),
    Format(
        "ahap",
        "Apple Core Haptics (AHAP)",
        ".ahap",
        "tracks.ahap",
        (
            Option("step", 0.02, "Step", "Seconds between the points of a curve, before what is redundant goes", (), 0.005, 1.0),
            Option("error", 0.02, "Error", "Intensity that a point may be off for being left out", (), 0.0, 0.5),
        ),
    ),
    Format(
        "tact",
        "bHaptics (.tact)",
        ".tact",
        "tracks.tact",
        (Option("levels", 50, "Levels", "Steps of strength: fewer make smaller files", (), 2, 100),),
    ),
    Format(
        "hla",
        "Android vibration (HLA)",
        ".hla",
        "tracks.hla",
        (Option("step", 20, "Step", "Milliseconds between changes", (), 5, 1000),),
    ),
    Format(
        "csv",
        "Table (CSV)",
        ".csv",
        "tracks.csv_table",
    ),
    Format(
        "npz",
        "NumPy arrays (NPZ)",
        ".npz",
        "tracks.npz",
        (Option("compressed", False, "Compressed", "Smaller, but slower to write"),),
    ),
    Format(
        "web",
        "Web page that plays by itself (HTML)",
        ".html",
        "tracks.web",
    ),
)

FORMATS: Mapping[str, Format] = MappingProxyType({form.name: form for form in _ALL})
"""The formats by name."""

READERS: Mapping[str, str] = MappingProxyType(
    {".wav": "wav", ".hjif": "hjif", ".haptic": "haptic", ".ahap": "ahap", ".haps": "wyvrn", ".tact": "tact"}
)
"""The format of each file suffix that can be imported."""


def named(name: str) -> Format:
    """A format by its name. Raises ValueError that lists the names."""
    if name not in FORMATS:
        raise ValueError(f"format {name!r} is unknown: use one of {', '.join(FORMATS)}")
    return FORMATS[name]
