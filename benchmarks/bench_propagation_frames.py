"""Graph and propagation of simulated frames, all contacts of which have moved since the frame
before.

    python -m benchmarks.bench_propagation_frames [--bodies 100 1000] [--frames 120]

Boxes fall and settle as in `falling_bodies`, with 4 sources and 10 listeners; the second half of
the frames is computed again, anew each.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from dataclasses import asdict, dataclass

os.environ["OPENBLAS_NUM_THREADS"] = "1"

from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.values import Settings, Strategy

from .families import Family
from .frames import falling_boxes
from .report import milliseconds, publish, table

STRATEGIES = tuple(Strategy)
REPEATED = 3
"""Times that each frame is computed."""


@dataclass(frozen=True, slots=True)
class Row:
    """Median seconds of the processor over the frames."""

    bodies: int
    contacts: float
    strategy: str
    graph: float
    propagate: float


def measure(bodies: int, frames: list[Family], strategy: Strategy) -> Row:
    """The median frame."""
    settings = Settings(strategy=strategy)
    building, propagating = [], []
    for frame in frames * REPEATED:
        begun = time.process_time()
        graph = frame.graph()
        built = time.process_time()
        propagate(graph, settings)
        building.append(built - begun)
        propagating.append(time.process_time() - built)
    contacts = statistics.median(len(frame.contacts) for frame in frames)
    return Row(
        bodies, contacts, str(strategy), statistics.median(building), statistics.median(propagating)
    )


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=int, nargs="*", default=[100, 1000])
    parser.add_argument("--frames", type=int, default=120)
    options = parser.parse_args()
    rows = []
    for bodies in options.bodies:
        frames = falling_boxes(bodies, options.frames)[options.frames // 2 :]
        rows += [measure(bodies, frames, strategy) for strategy in STRATEGIES]
    heading = ("boxes", "contacts", "strategy", "graph [ms]", "propagate [ms]")
    lines = [
        (
            f"{r.bodies:,}",
            f"{r.contacts:,.0f}",
            r.strategy,
            milliseconds(r.graph),
            milliseconds(r.propagate),
        )
        for r in rows
    ]
    note = (
        "Milliseconds of the processor, one thread, median of "
        f"{options.frames - options.frames // 2} frames; 4 sources, 10 listeners."
    )
    publish(
        "propagation_frames",
        "Propagation of simulated frames",
        f"{note}\n\n{table(heading, lines)}",
        [asdict(row) for row in rows],
    )


if __name__ == "__main__":
    main()
