"""Run time against error of every way to sum over all paths.

    python -m benchmarks.bench_propagation_error [--seconds 20]

The error is the largest relative one of any listener, against the sum over all paths without any
limit: exact, or certified to 1e-6. Curves are swept by what each strategy can be told: `threshold`
and `max_connections` (both as in the paper, here and in plain breadth-first enumeration), and
`tolerance`. Times are the best of some runs, the graph included.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.values import Settings, Strategy

from .families import Family, grid, hub, ladder, pile, random_contacts, traced, tree
from .peers import OutOfTime, enumerate_paths
from .report import RESULTS, milliseconds, publish, table
from .timing import best_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAMILIES: tuple[Callable[[], Family], ...] = (
    lambda: tree(300),
    lambda: ladder(14),
    lambda: grid("wall", 4, 6),
    lambda: random_contacts(30),
    lambda: hub(8),
    lambda: pile(12, sources=1),
)
FREE = Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0)
THRESHOLDS = tuple(10 ** (-k / 2) for k in range(2, 33))
CONNECTIONS = (3, 5, 7, 9, 11, 13, 15, 19, 23, 27, 31, 39, 47, 63)
TOLERANCES = (1.0, 0.3, 0.1, 0.03, 0.01, 1e-3, 1e-4, 1e-6, 0.0)
EXACT = 1e-15
"""Errors below this are rounding; drawn as this."""
WANTED = 0.01
BUDGET = 1 << 40

ENUMERATION, BY_CONNECTIONS = "breadth-first, threshold", "breadth-first, max_connections"
CERTIFIED = "all_paths, tolerance"
STYLES = {
    ENUMERATION: ("#b3261e", "o-"),
    BY_CONNECTIONS: ("#e08a7f", "s-"),
    CERTIFIED: ("#1a6b3c", "D-"),
    "all_paths, threshold": ("#1f5fa8", "o-"),
    "all_paths, max_connections": ("#7fb0e0", "s-"),
    "best_path": ("#555555", "*"),
    "energy_balance": ("#b08900", "^"),
}


@dataclass(frozen=True, slots=True)
class Point:
    """One setting: seconds, largest relative error of any listener, and the certified one where
    there is one."""

    curve: str
    setting: str
    seconds: float
    error: float
    bound: float | None


@dataclass(frozen=True, slots=True)
class Measured:
    """All points of a family, and how good the sums are that they are measured against."""

    family: str
    objects: int
    contacts: int
    reference: float
    points: list[Point]

    def fastest(self, curves: tuple[str, ...], error: float) -> Point | None:
        """Of the points of these curves with at most this error the quickest."""
        good = [point for point in self.points if point.curve in curves and point.error <= error]
        return min(good, key=lambda point: point.seconds, default=None)

    def certified(self) -> Point:
        """The time to a certified `WANTED`."""
        return next(
            point
            for point in self.points
            if point.curve == CERTIFIED and point.setting == f"{WANTED:g}"
        )


def relative(gains: np.ndarray, true: np.ndarray) -> float:
    heard = true > 0
    return float(np.max(np.abs(gains[heard] - true[heard]) / true[heard], initial=0.0))


def measure(family: Family, seconds: float) -> Measured:
    """Sweep every curve; enumeration until it takes longer than ``seconds``."""
    graph = family.graph()
    sums = propagate(graph, replace(FREE, tolerance=1e-6), BUDGET)
    true = sums.gain[0]
    points = []
    for curve, limits in (
        (ENUMERATION, [(None, threshold) for threshold in THRESHOLDS]),
        (BY_CONNECTIONS, [(count, 0.0) for count in CONNECTIONS]),
    ):
        for max_connections, threshold in limits:
            begun = time.process_time()
            try:
                found = enumerate_paths(family, max_connections, threshold, seconds)
            except OutOfTime:
                break
            used = time.process_time() - begun
            error = relative(found.gains, true)
            points.append(Point(curve, f"{max_connections or threshold:g}", used, error, None))
            if error < 1e-9:
                break
    ours = (
        [(CERTIFIED, f"{t:g}", replace(FREE, tolerance=t)) for t in TOLERANCES]
        + [
            (
                "all_paths, threshold",
                f"{t:g}",
                Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=t),
            )
            for t in THRESHOLDS
        ]
        + [
            (
                "all_paths, max_connections",
                f"{n}",
                Settings(
                    strategy=Strategy.ALL_PATHS, max_connections=n, threshold=0.0, tolerance=0.0
                ),
            )
            for n in CONNECTIONS
        ]
        + [
            (str(s), "", replace(FREE, strategy=s))
            for s in (Strategy.BEST_PATH, Strategy.ENERGY_BALANCE)
        ]
    )
    done: set[str] = set()
    for curve, setting, chosen in ours:
        if curve in done:
            continue
        used, result = best_run(traced, family, chosen, patience=1.0)
        error = relative(result.gain[0], true)
        bound = relative(true + result.error_bound[0], true) if curve == CERTIFIED else None
        points.append(Point(curve, setting, used, error, bound))
        if (curve != CERTIFIED and error < 1e-9) or used > seconds / 4:
            done.add(curve)
    return Measured(
        family.name,
        len(family.table.names),
        len(family.contacts),
        relative(true + sums.error_bound[0], true),
        points,
    )


def measured_before() -> list[Measured]:
    """What was measured and written last."""
    results = json.loads((RESULTS / "propagation_error.json").read_text(encoding="utf-8"))[
        "results"
    ]
    return [
        Measured(**{**item, "points": [Point(**point) for point in item["points"]]})
        for item in results
    ]


def summary(measured: list[Measured]) -> str:
    """Time to a certified 1 % against enumeration, and the exact sum."""
    rows = []
    for item in measured:
        ours = item.certified()
        plain = item.fastest((ENUMERATION, BY_CONNECTIONS), WANTED)
        same = item.fastest((ENUMERATION, BY_CONNECTIONS), max(ours.error, 1e-9))
        exact = [
            p
            for p in item.points
            if p.curve == CERTIFIED and p.bound is not None and p.bound <= 1e-9
        ]
        reached = (
            "yes"
            if ours.bound is not None and ours.bound <= WANTED * (1 + 1e-9)
            else f"no, {ours.bound:.2g}"
        )
        rows.append(
            (
                f"{item.family}, {item.objects} objects",
                milliseconds(ours.seconds),
                reached,
                f"{ours.error:.1g}",
                *(
                    (milliseconds(plain.seconds), f"{plain.seconds / ours.seconds:.1f}")
                    if plain
                    else ("-", "-")
                ),
                *(
                    (milliseconds(same.seconds), f"{same.seconds / ours.seconds:.1f}")
                    if same
                    else ("-", "-")
                ),
                milliseconds(min((p.seconds for p in exact), default=None)),
            )
        )
    heading = (
        "family",
        "to a certified 1 % [ms]",
        "certified",
        "its true error",
        "enumeration to a true 1 % [ms]",
        "ratio",
        "enumeration to the same true error [ms]",
        "ratio",
        "exact [ms]",
    )
    return table(heading, rows)


def draw(measured: list[Measured]) -> Figure:
    """One panel per family."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 8), layout="constrained")
    axes = figure.subplots(2, 3, sharey=True).ravel()
    for axis, item in zip(axes, measured, strict=True):
        for curve, (colour, style) in STYLES.items():
            points = [p for p in item.points if p.curve == curve]
            if points:
                x, y = [1000 * p.seconds for p in points], [max(p.error, EXACT) for p in points]
                large = 11 if len(style) == 1 else 4
                axis.plot(x, y, style, color=colour, label=curve, markersize=large, linewidth=1.2)
        axis.set(
            xscale="log",
            yscale="log",
            title=f"{item.family}: {item.objects} objects, {item.contacts} contacts",
            ylim=(EXACT / 3, 3),
        )
        axis.axhline(WANTED, color="#999999", linewidth=0.7, linestyle=":")
        axis.grid(alpha=0.25)
        axis.set_xlabel("run time [ms]")
    for axis in axes[::3]:
        axis.set_ylabel("largest relative error")
    handles = {
        label: handle
        for axis in axes
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False
    )
    return figure


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=20.0,
        help="a run of the enumeration that takes longer is given up (20)",
    )
    seconds = parser.parse_args().seconds
    measured = [measure(make(), seconds) for make in FAMILIES]
    text = (
        "Sum over all paths, one source; processor time with building the graph, best of some "
        "runs. Plain breadth-first enumeration is\n"
        "given the setting (threshold or max_connections) that is quickest to the error, which "
        "nobody knows beforehand; runs of it over\n"
        f"{seconds:g} s are left out. A certified 1 %: the true sum is proven to lie that close. "
        "`best_path` and `energy_balance` compute\n"
        "something else: drawn is how far that is from the sum.\n\n" + summary(measured)
    )
    data = [asdict(item) for item in measured]
    publish(
        "propagation_error",
        "Run time against error of sums over all paths",
        text,
        data,
        draw(measured),
    )


if __name__ == "__main__":
    main()
