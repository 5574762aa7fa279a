"""What the limits of sums as in the paper cost: run time against error.

    python -m benchmarks.bench_propagation_error [--seconds 20]

The error is the largest relative one of any listener, against the sum over all paths without any
limit, by plain enumeration where that ends within some seconds. Curves are swept by ``threshold``
and by ``max_connections``; a point that the budget of operations ended is drawn hollow. Times are
the best of some runs, the graph included.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.scene.values import Mode, Settings, Strategy

from .families import Family, grid, hub, ladder, pile, random_contacts, traced, tree
from .peers import OutOfTime, enumerate_paths
from .report import milliseconds, publish, table
from .timing import best_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAMILIES: tuple[Callable[[], Family], ...] = (
    lambda: tree(300),
    lambda: ladder(9),
    lambda: grid("wall", 3, 5),
    lambda: random_contacts(12),
    lambda: hub(5),
    lambda: pile(7, sources=1),
)
THRESHOLDS = tuple(10 ** (-k / 2) for k in range(2, 15))
CONNECTIONS = (3, 5, 7, 9, 11, 13, 15, 19, 23, 32)
DEFAULT = Settings(strategy=Strategy.AS_IN_THE_PAPER)
CURVES = {"threshold": "#1f5fa8", "max_connections": "#7fb0e0", "default limits": "#b3261e"}
ROUNDING = 1e-12
"""Errors below this are drawn as this."""


@dataclass(frozen=True, slots=True)
class Point:
    """A run: processor time [s], largest relative error, and whether the budget ended it."""

    curve: str
    setting: str
    seconds: float
    error: float
    ended: bool


@dataclass(frozen=True, slots=True)
class Measured:
    """The points of a family whose exact sums are known."""

    family: str
    objects: int
    contacts: int
    points: list[Point]


def measure(family: Family, seconds: float) -> Measured | None:
    """Sweep both limits; None if the exact sum takes longer than ``seconds``."""
    try:
        true = enumerate_paths(family, None, 0.0, seconds).gains
    except OutOfTime:
        return None
    heard = true > 0
    chosen = [
        *(("threshold", f"{t:.1g}", _paper(None, t)) for t in THRESHOLDS),
        *(("max_connections", str(n), _paper(n, 0.0)) for n in CONNECTIONS),
        ("default limits", "", DEFAULT),
    ]
    points = []
    for curve, setting, settings in chosen:
        used, result = best_run(traced, family, settings, patience=1.0)
        error = np.abs(result.gain[0, heard] - true[heard]) / true[heard]
        points.append(
            Point(curve, setting, used, float(error.max(initial=0.0)), bool(result.warnings))
        )
    return Measured(family.name, len(family.table.names), len(family.contacts), points)


def _paper(max_connections: int | None, threshold: float) -> Settings:
    return Settings(Mode.HT, Strategy.AS_IN_THE_PAPER, max_connections, threshold)


def summary(measured: list[Measured]) -> str:
    """The error of the default limits, and the time to 1 %."""
    rows = []
    for item in measured:
        default = item.points[-1]
        near = [p.seconds for p in item.points if p.error <= 0.01]
        rows.append(
            (
                f"{item.family}, {item.objects} objects",
                milliseconds(default.seconds),
                f"{100 * default.error:.2g} %",
                milliseconds(min(near, default=None)),
            )
        )
    return table(("family", "default limits [ms]", "their error", "to 1 % [ms]"), rows)


def draw(measured: list[Measured]) -> Figure:
    """One panel per family."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 8), layout="constrained")
    axes = figure.subplots(2, 3, sharey=True).ravel()
    for axis, item in zip(axes, measured, strict=False):
        for curve, colour in CURVES.items():
            points = [p for p in item.points if p.curve == curve]
            x, y = [1000 * p.seconds for p in points], [max(p.error, ROUNDING) for p in points]
            axis.plot(x, y, color=colour, label=curve, linewidth=1.2)
            face = ["white" if p.ended else colour for p in points]
            axis.scatter(x, y, c=face, edgecolors=colour, zorder=3)
        axis.set(xscale="log", yscale="log", title=f"{item.family}: {item.objects} objects")
        axis.grid(alpha=0.25)
        axis.set_xlabel("run time [ms]")
    for axis in axes[::3]:
        axis.set_ylabel("largest relative error")
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False
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
        help="an enumeration that takes longer is given up (20)",
    )
    seconds = parser.parse_args().seconds
    measured = [item for make in FAMILIES if (item := measure(make(), seconds)) is not None]
    text = (
        "Sums over all paths as in the paper, one source; processor time with building the graph. "
        "Errors are relative to the sum without limits, by enumeration.\n\n" + summary(measured)
    )
    data = [asdict(item) for item in measured]
    publish("propagation_error", "What limits of sums cost", text, data, draw(measured))


if __name__ == "__main__":
    main()
