"""Contact detection without Blender: agreement with Bullet per pair of shapes, and time per update
while bodies fall and settle.

    python -m benchmarks.bench_contacts [--bodies 100 1000 3000] [--frames 120] [--pairs 200]

Needs PyBullet. First table: random pairs of shapes near touching: how often the decision on contact
differs from Bullet's where the distance is not within 1 mm of the tolerance, and errors of
distances and points. Second: bodies simulated by PyBullet at 24 frames a second; median and worst
milliseconds of one update of the tracker (CPU time of its thread), median contacts, queries made
and avoided per frame, microseconds per query, impacts in all. `nothing sounds` computes contacts
only where impacts are possible, `one source, still` is heard everywhere with all bodies at rest,
and `one moves` with all at rest but one.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from haptic_tracing.core.contacts.settings import Body, Motion
from haptic_tracing.core.contacts.tracker import ContactTracker, Endpoints

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "core" / "contacts"))
import bullet_pairs
from test_against_bullet import table

RATE = 24.0
SIZE = 0.5


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the second table."""

    bodies: int
    kind: str
    wanted: str
    median: float
    worst: float
    contacts: float
    queries: float
    avoided: float
    per_query: float
    impacts: int


def simulated(bodies: int, kind: str, frames: int) -> tuple[tuple[Body, ...], list[np.ndarray]]:
    """Bodies of one kind or of all that fall in layers onto a ground: what they are, and their
    matrices (n, 4, 4) frame by frame."""
    import pybullet

    shapes = [
        bullet_pairs.SHAPES[name]
        for name in (bullet_pairs.SHAPES if kind == "mixed" else (kind,))
        if name not in ("plank", "mesh")
    ]
    bullet = bullet_pairs.Bullet()
    client = {"physicsClientId": bullet._client}
    pybullet.setGravity(0, 0, -9.81, **client)
    pybullet.setTimeStep(1 / RATE / 10, **client)
    generator = np.random.default_rng(bodies)
    width = max(3, round((bodies / 4) ** (1 / 3) * 2))
    ground = bullet_pairs.Box((8.0 * width, 8.0 * width, 2.0))
    known = [bullet._shape(shape) for shape in shapes]
    numbers = [
        pybullet.createMultiBody(0, bullet._shape(ground), basePosition=[0, 0, -1], **client)
    ]
    told = [Body("ground", ground, motion=Motion.STATIC)]
    for k in range(bodies):
        layer, row, column = k // width**2, k // width % width, k % width
        place = np.array([column - width / 2, row - width / 2, 0.8 + layer]) * 1.3 + [
            *generator.uniform(-0.1, 0.1, 2),
            0.0,
        ]
        turn = generator.normal(size=4)
        turn = (turn / np.linalg.norm(turn)).tolist()
        numbers.append(
            pybullet.createMultiBody(
                1,
                known[k % len(known)],
                basePosition=place.tolist(),
                baseOrientation=turn,
                **client,
            )
        )
        told.append(Body(f"body {k}", shapes[k % len(shapes)], 1.0))
    sequence = []
    for _ in range(frames):
        poses = np.empty((len(numbers), 7))
        for k, number in enumerate(numbers):
            place, (x, y, z, w) = pybullet.getBasePositionAndOrientation(number, **client)
            poses[k] = (*place, w, x, y, z)
        sequence.append(bullet_pairs.matrices(poses.astype(np.float32)))
        for _ in range(10):
            pybullet.stepSimulation(**client)
    bullet.close()
    return tuple(told), sequence


def timed(
    bodies: tuple[Body, ...],
    kind: str,
    wanted: str,
    sequence: list[np.ndarray],
    ends: Endpoints | None = None,
) -> Row:
    """Follow the bodies; the first frame, in which everything is new, is not counted."""
    tracker = ContactTracker(bodies)
    spent, contacts, queries, avoided, impacts = [], [], [], [], 0
    for frame, matrices in enumerate(sequence):
        begun = time.thread_time()
        found = tracker.update(frame / RATE, matrices, ends)
        spent.append(time.thread_time() - begun)
        contacts.append(len(found.contacts))
        queries.append(found.statistics.queries)
        avoided.append(found.statistics.avoided)
        impacts += len(found.impacts)
    each = 1000 * np.array(spent[1:])
    return Row(
        len(bodies) - 1,
        kind,
        wanted,
        float(np.median(each)),
        float(each.max()),
        float(np.median(contacts[1:])),
        float(np.median(queries[1:])),
        float(np.median(avoided[1:])),
        1000 * float(each.sum()) / max(sum(queries[1:]), 1),
        impacts,
    )


def rows(counts: list[int], frames: int) -> Iterator[Row]:
    """The rows of the second table."""
    for count in counts:
        for kind in ("box", "mixed"):
            bodies, sequence = simulated(count, kind, frames)
            yield timed(bodies, kind, "all", sequence)
            heard, one = np.ones(len(bodies), dtype=np.bool_), np.arange(len(bodies)) == 1
            yield timed(bodies, kind, "nothing sounds", sequence, Endpoints(heard, ~heard))
            still = [sequence[-1].copy() for _ in range(20)]
            yield timed(bodies, kind, "one source, still", still, Endpoints(heard, one))
            for frame, matrices in enumerate(still):
                matrices[1, :3, 3] += [0.0, 0.0, 0.001 * (frame % 2)]
            yield timed(bodies, kind, "one moves", still, Endpoints(heard, one))


def run(
    counts: tuple[int, ...] = (100, 1000, 3000), frames: int = 120, pairs: int = 200
) -> list[Row]:
    """Print both tables; the rows of the second."""
    print(table(bullet_pairs.asked(seed=3, count=pairs)))
    print(f"\n{frames} frames at {RATE:g} a second, milliseconds of CPU time")
    print(
        " bodies shapes   wanted              median   worst contacts  queries  avoided us/query "
        "impacts"
    )
    result = []
    for row in rows(list(counts), frames):
        result.append(row)
        print(
            f"{row.bodies:7} {row.kind:8} {row.wanted:18} {row.median:7.2f} {row.worst:7.2f} "
            f"{row.contacts:8.0f} {row.queries:8.0f}"
            f" {row.avoided:8.0f} {row.per_query:8.2f} {row.impacts:7}",
            flush=True,
        )
    return result


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--bodies", type=int, nargs="*", default=[100, 1000, 3000])
    parser.add_argument("--frames", type=int, default=120)
    parser.add_argument("--pairs", type=int, default=200)
    options = parser.parse_args()
    run(tuple(options.bodies), options.frames, options.pairs)


if __name__ == "__main__":
    main()
