"""What tracing costs in CPU time, of all threads, by what the falling bodies of `bench_frame` are
made of.

    python -m benchmarks.bench_materials [--bodies 100 300 1000] [--frames 100] [--passes 3]
                                         [--no-impacts]

Six Blenders play the same frames in turns: one without tracing, whose time is taken off, and one
for each kind of materials. Of several passes the quickest of each frame's times counts; the mean
over the frames is compared with that of the paper's function, or where stone has frequency bands
with its plain gain.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

from .bench_frame import PASSES, Blender, Traced, turn_of


class Kind(NamedTuple):
    """A value of ``materials`` of `falling_bodies.build`. The time is compared with that of the
    kind ``base`` and may be up to ``goal`` times as long."""

    materials: str | None
    title: str
    base: str | None = None
    goal: float = 1.0


KINDS = (
    Kind(None, "the paper's function"),
    Kind("made", "as Make Haptic makes them", None, 2.0),
    Kind("plain", "stone on soil, plain gain"),
    Kind("one", "stone on soil, sources of one band", "plain", 1.5),
    Kind("four", "stone on soil, sources of four bands", "plain", 1.5),
)


def measure(
    bodies: int, frames: int, passes: int, impacts: bool
) -> dict[str | None, tuple[float, Traced]]:
    """Milliseconds of CPU time that tracing adds to a frame, and what was traced: of each kind."""
    turn = turn_of(bodies)
    worked = np.full((1 + len(KINDS), frames), np.inf)
    traced: list[Traced] = []
    for _ in range(passes):
        scene = bodies, "BOX", False, "best_path", impacts
        blenders = [
            Blender(False, frames, *scene),
            *(Blender(True, frames, *scene, kind.materials) for kind in KINDS),
        ]
        for begin in range(0, frames, turn):
            numbers = range(begin + 1, min(begin + turn, frames) + 1)
            for cpu, blender in zip(worked, blenders, strict=True):
                cpu[begin:][: len(numbers)] = np.minimum(
                    cpu[begin:][: len(numbers)], blender.play(numbers)[1]
                )
        traced = [found for blender in blenders if (found := blender.end()) is not None]
    beside = np.arange(frames) % turn > 0
    added = 1000 * (worked[1:, beside] - worked[0, beside]).mean(axis=1)
    kinds = [kind.materials for kind in KINDS]
    return dict(zip(kinds, zip(added.tolist(), traced, strict=True), strict=True))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=int, nargs="*", default=[100, 300, 1000])
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--passes", type=int, default=PASSES)
    parser.add_argument("--impacts", action=argparse.BooleanOptionalAction, default=True)
    options = parser.parse_args()
    print(
        f"{options.frames} frames, {'with' if options.impacts else 'without'} impacts; "
        "milliseconds of tracing's CPU time a frame"
    )
    for bodies in options.bodies:
        rows = measure(bodies, options.frames, options.passes, options.impacts)
        for kind in KINDS:
            added, traced = rows[kind.materials]
            compared = "" if kind.goal == 1.0 else f"(goal {kind.goal:g})"
            stages = ", ".join(f"{stage} {time:.2f}" for stage, time in traced.stages.items())
            print(
                f"{bodies:7}  {kind.title:38} {added:7.2f}  {added / rows[kind.base][0]:5.2f} "
                f"times {compared:11} {stages}",
                flush=True,
            )


if __name__ == "__main__":
    main()
