"""Time that Blender's main thread waits for the GIL while contacts are computed on the worker
thread, by Python's switch interval.

    python -m benchmarks.bench_switch_interval [--bodies 250] [--seconds 6]

The main thread acquires the GIL after every pause of 2 ms, as draw callbacks do; the table has the
delays. The worker updates the contacts of bodies that all move. The two intervals, Python's own of
5 ms and that of `worker.SWITCH_INTERVAL`, take turns, so that both meet the same load.
"""

from __future__ import annotations

import argparse
import sys
import threading
import time

import numpy as np
from haptic_tracing.core.contacts.settings import Body
from haptic_tracing.core.contacts.shapes import Capsule, ConvexHull, Cylinder
from haptic_tracing.core.contacts.tracker import ContactTracker

from .report import table

INTERVALS = (5e-3, 2e-4)
PAUSE = 0.002
TURNS = 2


def bodies_of(count: int) -> tuple[Body, ...]:
    """Capsules, cylinders and hulls in turn."""
    points = np.random.default_rng(1).normal(size=(24, 3)) * 0.3
    shapes = (
        Capsule(radius=0.25, height=0.4),
        Cylinder(radius=0.3, height=0.5),
        ConvexHull(points),
    )
    return tuple(Body(f"body {k}", shapes[k % 3], 1.0) for k in range(count))


def waits(bodies: tuple[Body, ...], seconds: float) -> tuple[list[float], int]:
    """The waits [s] of the main thread for the GIL, and how often the worker updated the contacts
    meanwhile."""
    ended, updates = threading.Event(), 0
    generator = np.random.default_rng(2)
    rest = np.tile(np.eye(4), (len(bodies), 1, 1))
    rest[:, :3, 3] = generator.uniform(0, 0.5 * len(bodies) ** (1 / 3), (len(bodies), 3))

    def work() -> None:
        nonlocal updates
        tracker = ContactTracker(bodies)
        while not ended.is_set():
            moved = rest.copy()
            moved[:, :3, 3] += generator.normal(size=(len(bodies), 3)) * 0.01
            tracker.update(updates / 24.0, moved)
            updates += 1

    worker = threading.Thread(target=work)
    worker.start()
    found = []
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        due = time.perf_counter() + PAUSE
        time.sleep(PAUSE)  # without the GIL, as Blender's own code between two callbacks
        found.append(time.perf_counter() - due)
    ended.set()
    worker.join()
    return found, updates


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=250)
    parser.add_argument("--seconds", type=float, default=6.0)
    options = parser.parse_args()
    bodies, before, rows = bodies_of(options.bodies), sys.getswitchinterval(), []
    try:
        for interval in INTERVALS * TURNS:
            sys.setswitchinterval(interval)
            found, updates = waits(bodies, options.seconds)
            values = 1000 * np.quantile(found, (0.5, 0.9, 0.99))
            rows.append(
                [f"{1000 * interval:g} ms", *(f"{value:.2f}" for value in values), str(updates)]
            )
    finally:
        sys.setswitchinterval(before)
    print(table(("switch interval", "median [ms]", "90 % [ms]", "99 % [ms]", "updates"), rows))


if __name__ == "__main__":
    main()
