"""``haptic-tracing convert IN OUT``: a vibration, or a haptic scene, from one format to another, by
file name endings."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..core.formats import haptic_scene, registry
from ..core.formats.export import Export
from ..core.formats.io.catalogue import named
from ..core.formats.tracks.listener_tracks import ListenerTrack, Tracks
from ..core.formats.tracks.vibration_file import Channel, VibrationFile
from . import warn_of_unknown
from .export import chosen_options, may_replace, print_written

SAMPLE_RATE = 8000
"""Sample rate of the tracks of a file without samples [Hz]."""


def run(args: argparse.Namespace) -> int:
    """Read, write, print. Returns exit code 0."""
    folder = args.target.parent
    if is_scene(args.source):
        if not is_scene(args.target):
            raise ValueError(
                f"{args.target}: a haptic scene becomes a haptic scene; to render it, use export"
            )
        export = haptic_scene.read_export(args.source)
        warn_of_unknown(args.source, export.unknown)
        tracks = "none" if export.tracks is None else "inline"
        files = haptic_scene.write_export(export, args.target, tracks=tracks, encoding="float32")
        print_written({"scene": registry.Written(tuple(files), ())})
        return 0
    names = {named(name).suffix: name for name in registry.FORMATS if name != "scene"}
    if args.target.suffix.lower() not in names:
        raise ValueError(
            f"{args.target}: can't be written: the ending must be one of {', '.join(names)}"
        )
    name = names[args.target.suffix.lower()]
    reading = registry.read(args.source)
    try:
        export = Export(args.target.stem, tracks=_tracks(reading))
    except ValueError as error:
        raise ValueError(f"{args.source}: {error}") from None
    written = registry.write(
        name, export, folder, chosen_options(args.options, [name])[name], may_replace
    )
    lost = tuple(f"{args.source.name}: {loss}" for loss in reading.losses)
    print_written({name: replace(written, losses=(*lost, *written.losses))})
    return 0


def is_scene(path: Path) -> bool:
    """Whether the ending is that of a haptic scene."""
    return path.name.lower().endswith((".json", ".json.gz"))


def _tracks(reading: VibrationFile) -> Tracks:
    """The channels as tracks of the same length. Raises ValueError if there is no vibration or too
    much of it."""
    named = zip(_names(reading.channels), reading.channels, strict=True)
    listeners = tuple(ListenerTrack(name, channel.body_part) for name, channel in named)
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
