"""The export of the parts of a Blender file's bake, bit-identical to the export without parts."""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, replace
from pathlib import Path

from ..core.formats.export import Export
from ..core.formats.tracks.listener_tracks import Tracks
from ..core.formats.tracks.track_recorder import RenderedFrame, TrackRecorder
from ..core.render.arrival import arriving
from ..core.render.frame_result import Sounding
from ..core.render.mixdown import Mixdown
from ..core.render.renderer import sample_index
from . import say
from .part_file import HeardFrame, Origin, Part, checksum_of, read_part

_MOST_NAMED = 20
_SAME = {
    "blend": "another .blend file",
    "mode": "another mode",
    "settings": "other settings",
    "frames": "another range",
    "parts": "another number of parts",
    "programs": "other versions",
}


def exports(args: argparse.Namespace, formats: Sequence[str]) -> Iterator[Export]:
    """The tracks of each bake, once all its parts are there and continue each other."""
    if "scene" in formats:
        raise ValueError(
            "--to: parts carry what is felt, not the scene itself: write that by export without "
            "--part"
        )
    for name, parts in _bakes(args.files).items():
        tracks = _tracks(parts)
        say(
            f"{name}: '{item.name}' feels nothing"
            for row, item in enumerate(tracks.listeners)
            if not tracks.samples[row].any()
        )
        yield Export(name, tracks=tracks if tracks.listeners else None, origin=parts[0].provenance)


def _bakes(paths: Sequence[Path]) -> dict[str, list[Part]]:
    """The parts of each bake, in order. Raises ValueError, which names all damaged, stale or
    missing ones."""
    bakes: dict[str, dict[int, tuple[Path, Part]]] = defaultdict(dict)
    problems = []
    for path in _files(paths):
        try:
            part = read_part(path)
        except ValueError as error:
            problems.append(str(error))
            continue
        bakes[part.origin.name][part.number] = path, part
    for named in bakes.values():
        problems += _problems(named)
    if problems:
        raise ValueError("; ".join(problems))
    return {
        name: [part for _, (_, part) in sorted(named.items())]
        for name, named in sorted(bakes.items())
    }


def _files(paths: Sequence[Path]) -> Iterator[Path]:
    """The given files, and those in given folders."""
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        found = sorted(path.glob("*.npz"))
        if not found:
            raise ValueError(f"{path}: there are no parts (*.npz) in this folder")
        yield from found


def _problems(named: dict[int, tuple[Path, Part]]) -> Iterator[str]:
    """The problems of the parts of one bake."""
    first_path, first = next(iter(named.values()))
    origin = first.origin
    yield from (
        f"{path}: of {words} than {first_path}"
        for path, part in named.values()
        for words in _differences(part.origin, origin)
    )
    file = Path(origin.file)
    if file.is_file() and checksum_of(file) != origin.blend:
        yield f"{first_path}: stale: {file} has changed since"
    missing = [number for number in range(1, origin.parts + 1) if number not in named]
    yield from (f"missing: {origin.title(number)}" for number in missing[:_MOST_NAMED])
    if len(missing) > _MOST_NAMED:
        yield f"and {len(missing) - _MOST_NAMED} more"
    for number, (path, part) in named.items():
        earlier = named.get(number - 1)
        if earlier is not None and earlier[1].after != part.before:
            yield (
                f"{path}: what moved and touched before it is not known to the bit: bake it "
                "again with --from-start"
            )


def _differences(one: Origin, other: Origin) -> Iterable[str]:
    return [
        _SAME[item.name]
        for item in fields(one)
        if item.name in _SAME and getattr(one, item.name) != getattr(other, item.name)
    ]


def _tracks(parts: Sequence[Part]) -> Tracks:
    """The tracks of all frames."""
    rate, recorder, before, first = (
        parts[0].sample_rate,
        TrackRecorder(),
        None,
        parts[0].origin.frames[0],
    )
    mixdown = Mixdown(sample_rate=rate)
    for frame in (frame for part in parts for frame in part.frames):
        rendered, before = _rendered(mixdown, before, frame), frame.time
        if frame.number >= first:
            recorder.add(rendered if frame.number > first else replace(rendered, block=None))
    return recorder.tracks()


def _rendered(mixdown: Mixdown, before: float | None, frame: HeardFrame) -> RenderedFrame:
    end = Sounding(frame.time, frame.sources, frame.listeners, frame.propagation)
    block = mixdown.render(before, end)
    first = sample_index(frame.time if before is None else before, mixdown.sample_rate)
    amplitudes = arriving(frame.sources, frame.propagation)
    return RenderedFrame(
        frame.number, frame.sources, frame.listeners, amplitudes, block, first, mixdown.sample_rate
    )
