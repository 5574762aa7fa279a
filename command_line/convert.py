"""``haptic-tracing convert IN OUT``: a vibration, or a haptic scene, from one format to another, by
file name endings; or a sound to the signal of a source, as the add-on converts it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..core.devices.profile_files import profile
from ..core.formats import haptic_scene, registry
from ..core.formats.export import Export
from ..core.formats.io.atomic import write_text
from ..core.formats.io.catalogue import named, track_formats
from ..core.formats.io.json_text import compact
from ..core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ..core.formats.tracks.vibration_file import Channel, VibrationFile
from ..core.signals.felt_sound import Feel, felt_onsets, vibration
from ..core.signals.sound import Clip, heard, mixed, outcome
from ..core.signals.wav import WavFile
from . import answer, say
from .export import chosen_options, may_replace, report
from .standard_streams import DASH, INPUT, OUTPUT, for_output, from_input, put_out

SAMPLE_RATE = 8000
"""Sample rate of the tracks of a file without samples [Hz]."""


def run(args: argparse.Namespace) -> int:
    """Read, write, print. Returns exit code 0."""
    source, target = given(args.source, args.read_as), args.target
    if target == DASH:
        target = for_output(target, _suffix(OUTPUT, args.to, "--to"))
    if source.suffix.lower() == ".wav" and target.suffix.lower() == ".json":
        name, written = "signal", _signal(source, target, args)
    else:
        for option in ("carrier", "gate", "gain"):
            if getattr(args, option) is not None:
                raise ValueError(f"--{option}: only where a sound (.wav) becomes a signal (.json)")
        name, written = _converted(source, target, args.options)
    if args.target != DASH:
        answer(args, report({name: written}))
        return 0
    put_out(written.files, args.stdout)
    say(written.losses)
    return 0


def _signal(source: Path, target: Path, args: argparse.Namespace) -> registry.Written:
    """Write the vibration that a sound becomes, as the signal of a source."""
    chosen: dict[str, Any] = {
        name: value for name in ("gate", "gain") if (value := getattr(args, name)) is not None
    }
    if args.carrier == "pitch":
        chosen["pitch"] = True
    elif args.carrier is not None:
        chosen["frequency"] = _frequency(args.carrier)
    feel = Feel(**chosen)
    try:
        with source.open("rb") as file:
            found = outcome(heard(outcome(mixed((Clip(WavFile(file)),)))))
        signal = vibration(found, feel)
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None
    write_text(target, (compact(signal.to_dict()),))
    say([f"{source.name}: {found.seconds:.2f} s, {len(felt_onsets(found, feel)[0])} onsets"])
    return registry.Written((target,), ())


def _frequency(carrier: str) -> float:
    """A frequency [Hz], given as such or as the device that plays it best."""
    try:
        return float(carrier)
    except ValueError:
        return profile(carrier).best_frequency


def given(path: Path, read_as: str | None) -> Path:
    """``path``, or for ``-`` what comes from standard input in the format ``read_as``."""
    return path if path != DASH else from_input(_suffix(INPUT, read_as, "--from"))


def _suffix(stream: str, name: str | None, flag: str) -> str:
    """The ending of the format of what is read from, or written to, ``-``."""
    if name is None:
        raise ValueError(f"{stream}: say its format by {flag}")
    return ".json" if name in ("scene", "signal") else named(name).suffix


def _converted(source: Path, target: Path, options: list[str]) -> tuple[str, registry.Written]:
    """Convert a file: the format's name and what was written."""
    if is_scene(source):
        if not is_scene(target):
            raise ValueError(
                f"{target}: a haptic scene becomes a haptic scene; to render it, use export"
            )
        export = haptic_scene.read_export(source)
        tracks = "none" if export.tracks is None else "inline"
        files = haptic_scene.write_export(export, target, tracks=tracks, encoding="float32")
        return "scene", registry.Written(tuple(files), ())
    names = {form.suffix: name for name, form in track_formats().items()}
    if target.suffix.lower() not in names:
        raise ValueError(
            f"{target}: can't be written: the ending must be one of {', '.join(names)}"
        )
    name = names[target.suffix.lower()]
    reading = registry.read(source)
    try:
        export = Export(target.stem, tracks=tracks_of(reading))
    except ValueError as error:
        raise ValueError(f"{source}: {error}") from None
    written = registry.write(
        name, export, target.parent, chosen_options(options, [name])[name], may_replace
    )
    lost = tuple(f"{source.name}: {loss}" for loss in reading.losses)
    return name, replace(written, losses=(*lost, *written.losses))


def is_scene(path: Path) -> bool:
    """Whether the ending is that of a haptic scene."""
    return path.name.lower().endswith((".json", ".json.gz"))


def tracks_of(reading: VibrationFile) -> Tracks:
    """The channels as tracks of the same length. Raises ValueError if there is no vibration or too
    much of it."""
    named = zip(_names(reading.channels), reading.channels, strict=True)
    listeners = tuple(
        ListenerTrack(name, item.body_part, device=item.device) for name, item in named
    )
    rate = (
        max((round(channel.sample_rate) for channel in reading.channels), default=0) or SAMPLE_RATE
    )
    if reading.stored is not None:
        return Tracks(listeners, rate, reading.stored)
    rows = [channel.at_rate(rate).astype(np.float32) for channel in reading.channels]
    count = max(map(len, rows), default=0)
    if not count:
        raise ValueError("there is no vibration to convert")
    samples = np.zeros((len(rows), count), dtype=np.float32)
    for target, row in zip(samples, rows, strict=True):
        target[: len(row)] = row
    return Tracks(listeners, rate, samples)


def _names(channels: Sequence[Channel]) -> list[str]:
    """The channels' names, made unique by numbers."""
    names: list[str] = []
    for channel in channels:
        name, number = channel.name, 2
        while name in names:
            name, number = f"{channel.name} {number}", number + 1
        names.append(name)
    return names
