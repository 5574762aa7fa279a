"""``haptic-tracing export FILE.blend --part K/N``: the K-th of N parts of a bake, or ``--part
K-L/N``, the K-th to the L-th one after the other."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from bpy.types import Scene

from ..addon.io.capture import Capture
from ..addon.session import session, timeline
from ..core.formats.io.error import FormatError
from ..core.forms import Form
from .frame_bar import frame_bar
from .part_file import HeardFrame, Origin, Part, checksum_of, programs, read_part, write_part


def write_parts_of(
    scene: Scene, args: argparse.Namespace, name: str, frames: tuple[int, int]
) -> list[Path]:
    """Bake parts of ``frames`` in the scene's mode, unless they exist already; their files."""
    first, last, parts = args.part
    if parts > frames[1] - frames[0] + 1:
        raise ValueError(
            f"--part: {parts} parts of {frames[1] - frames[0] + 1} frames: there must be a frame "
            "in each"
        )
    file = args.files[0].resolve()
    origin = Origin(
        name,
        str(file),
        checksum_of(file),
        scene.haptics.mode,
        tuple(args.set),
        frames,
        parts,
        programs(),
    )
    paths = []
    for number in range(first, last + 1):
        path = args.out / f"{name}.{number}-of-{parts}.npz"
        paths.append(path)
        if _is_there(path, origin, number):
            print(f"kept {path}: this part exists already")
            continue
        start = start_of(scene, origin, 1 if args.from_start else number)
        write_part(_baked(scene, origin, number, start, args.progress), path)
        print(f"wrote {path}: {origin.title(number)}, traced from frame {start}")
    return paths


def start_of(scene: Scene, origin: Origin, number: int) -> int:
    """The frame that a part is traced from."""
    begin = timeline.tracing_start(scene, origin.frames[0])
    if number == 1:
        return begin
    return max(
        timeline.warm_start(scene, origin.range_of(number)[0], timeline.sounding_seconds(scene)),
        begin,
    )


def _is_there(path: Path, origin: Origin, number: int) -> bool:
    try:
        found = read_part(path)
    except (FormatError, FileNotFoundError):
        return False
    return (replace(found.origin, file=origin.file), found.number) == (origin, number)


def _baked(scene: Scene, origin: Origin, number: int, start: int, progress: str = "bar") -> Part:
    """Trace the frames of a part of a bake.

    Args:
        scene: to trace.
        origin: what the part belongs to.
        number: of the part, from 1.
        start: first frame that is traced, before the part itself.
        progress: how progress is shown.
    """
    first, last = origin.traced(number)
    before, heard, rate = "", [], 0.0
    provenance: Form | None = None
    own = session.of(scene)
    with frame_bar(last - start + 1, origin.title(number), progress) as advance:
        for step in timeline.steps(scene, start, last, looks_back=False):
            if not step.result.listeners:
                raise ValueError("there is no listener: add one to feel something")
            if step.result.number == first - 1 and number > 1:
                before = own.tracer.checksum()
            elif step.result.number >= first or number == 1:
                heard.append(HeardFrame.of(step.result))
                rate = step.result.sample_rate
            if number == 1 and step.result.number == first:
                provenance = Capture.of(scene, step.result).provenance
            after = own.tracer.checksum() if step.result.number == last else ""
            advance()
    return Part(origin, number, rate, before, after, tuple(heard), provenance)
