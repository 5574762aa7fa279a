"""How long Blender waits for a trace that it cancels: file load, undo, render, exit and disabling
end it wherever it is.

    python -m benchmarks.bench_cancelling [--times 100]

Each work is begun on the worker thread and cancelled at a random moment of its first half second;
the goal is 100 ms at most.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from haptic_tracing.addon.session import worker
from haptic_tracing.core.contacts.tracker import ContactTracker
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.values import Mode, Settings, Strategy

from .bench_switch_interval import bodies_of
from .families import Family, pile, wall
from .report import table

PAPER = Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, None, 0.0)


def contacts(count: int) -> Callable[[], None]:
    """Contacts of capsules, cylinders and hulls that all move, frame after frame."""
    bodies, generator = bodies_of(count), np.random.default_rng(2)
    rest = np.tile(np.eye(4), (count, 1, 1))
    rest[:, :3, 3] = generator.uniform(0, 0.5 * count ** (1 / 3), (count, 3))

    def work() -> None:
        tracker, time_ = ContactTracker(bodies), 0.0
        while True:
            rest[:, :3, 3] += generator.normal(size=(count, 3)) * 0.01
            tracker.update(time_ := time_ + 1 / 24, rest.copy())

    return work


def gains(family: Family, settings: Settings) -> Callable[[], None]:
    """The gains of a family of scenes, again and again."""

    def work() -> None:
        while True:
            propagate(family.graph(), settings)

    return work


WORKS: dict[str, Callable[[], None]] = {
    "contacts of 1,000 bodies": contacts(1000),
    "best paths in a pile of 5,000": gains(pile(5000), Settings()),
    "sums over paths in a wall of 100": gains(wall(100), PAPER),
}


def waits(work: Callable[[], None], times: int) -> list[float]:
    """Seconds that a cancellation took, for each of so many."""
    generator, found = np.random.default_rng(3), []
    for _ in range(times):
        worker.submit(work)
        time.sleep(generator.uniform(0.0, 0.5))
        begun = time.perf_counter()
        worker.cancel()
        found.append(time.perf_counter() - begun)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=100)
    options = parser.parse_args()
    rows = []
    for name, work in WORKS.items():
        found = waits(work, options.times)
        rows.append(
            [
                name,
                *(
                    f"{1000 * value:.1f}"
                    for value in (*np.quantile(found, (0.5, 0.99)), max(found))
                ),
            ]
        )
    print(table(("cancelled", "median [ms]", "99 % [ms]", "longest [ms]"), rows))


if __name__ == "__main__":
    main()
