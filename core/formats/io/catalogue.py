"""The formats by name, those of plug-ins among them, with their options, described for menus and
command lines. Does not import the modules that write and read them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from ... import plugins
from ...declaration import Choice, Declaration, Number, Switch
from ...forms import JsonObject
from ...frozen import frozen
from ...scene import references

MAX_SAMPLE_RATE = 192_000
"""Largest sample rate of tracks [Hz]."""


Value = bool | int | float | str


def complete(options: Mapping[str, Declaration], chosen: Mapping[str, Value]) -> JsonObject:
    """The value of every option: the chosen one, checked, or the default. Raises ValueError for an
    unknown option."""
    values = {name: option.shown for name, option in options.items()}
    for name, value in chosen.items():
        if name not in options:
            raise ValueError(
                f"{name}: unknown option"
                + (f"; known are {', '.join(options)}" if options else "; there are none")
            )
        try:
            values[name] = options[name].checked(value)
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: {error}") from None
    return values


@frozen(kw_only=True)
class Format:
    """``label``: its name in menus. ``suffix``: of its files. ``module``: the name of the module
    that writes and, if it ``is_read``, reads it. ``files``: patterns of the names of its files.
    ``carries``: what they hold. ``options``: by their names."""

    name: str
    label: str
    suffix: str
    module: str
    files: str
    carries: str
    is_read: bool = False
    options: Mapping[str, Declaration] = field(default_factory=dict)


_PACKAGE = __package__.rpartition(".")[0]
_ENCODING = Choice(
    shown="pcm16",
    label="Encoding",
    about="Of the tracks",
    items={"pcm16": ("16 Bit", ""), "float32": ("Float", "Without any loss of range")},
)
SCENE = Format(
    name="scene",
    label="Haptic scene (JSON)",
    suffix=".json",
    module=f"{_PACKAGE}.haptic_scene",
    files="<scene>.json .json.gz .tracks.wav",
    carries="everything",
    is_read=True,
    options={
        "frames": Switch(shown=True, label="Frames", about="Changes over time"),
        "tracks": Choice(
            shown="none",
            label="Tracks",
            about="What the listeners feel, rendered",
            items={
                "none": ("None", "Not written: the scene can be rendered again"),
                "inline": ("In the File", "Within the JSON"),
                "wav": ("Beside It", "As a WAV file of the same name"),
            },
        ),
        "encoding": _ENCODING,
        "compressed": Switch(shown=False, label="Compressed", about="Packed, as .json.gz"),
    },
)
WAV = Format(
    name="wav",
    label="WAV, a channel per listener",
    suffix=".wav",
    module=f"{_PACKAGE}.tracks.wav",
    files="<scene>.wav <scene>.wav.json",
    carries="samples, names, body parts, impacts",
    is_read=True,
    options={
        "encoding": _ENCODING,
        "sample_rate": Number(
            shown=0,
            label="Sample rate",
            about="Hertz; 0: that of the tracks",
            low=0,
            high=MAX_SAMPLE_RATE,
            whole=True,
        ),
    },
)


def formats() -> dict[str, Format]:
    """The formats by name."""
    return {form.name: form for form in (SCENE, WAV, *plugins.offered("formats"))}


def track_formats() -> dict[str, Format]:
    """The formats of tracks by name."""
    return {name: form for name, form in formats().items() if form != SCENE}


def readers() -> dict[str, str]:
    """The format of each suffix of files from which a vibration can be read."""
    return {form.suffix: name for name, form in track_formats().items() if form.is_read}


def named(name: str) -> Format:
    """A format by its name. Raises ValueError, which lists the names, for any other."""
    return references.named(name, formats(), "format")
