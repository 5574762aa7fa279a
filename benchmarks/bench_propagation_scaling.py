"""Time, memory and nodes visited from 10 to 100,000 objects, beside NetworkX, SciPy and rustworkx
on the explicit graph.

    python -m benchmarks.bench_propagation_scaling [--largest 100000] [--seconds 20]

Every time includes building the graph from the arrays of contacts. `best_path` ends at -120 dB,
`as_in_the_paper` has the default limits (32 connections, a gain of 0.001); the peers have none.
Memory is the peak of what Python allocates, in a run of its own.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.scene.values import Settings, Strategy

from .families import FAMILIES, Family, traced
from .peers import PEERS
from .report import milliseconds, publish, table
from .timing import best_run, peak

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZES = (10, 100, 1000, 10_000, 100_000)
RUNS = {str(strategy): Settings(strategy=strategy) for strategy in Strategy}
MOST = {"NetworkX": 600_000, "SciPy": 15_000_000, "rustworkx": 3_000_000}
"""Explicit connections that a peer is given at most: more would not fit into memory, or take
minutes."""
COLOURS = {
    "best_path": "#1a6b3c",
    "as_in_the_paper": "#1f5fa8",
    "NetworkX": "#b3261e",
    "SciPy": "#8e44ad",
    "rustworkx": "#e0703a",
}


@dataclass(frozen=True, slots=True)
class Row:
    """One family at one size: seconds and megabytes by what ran, without what was left out."""

    family: str
    objects: int
    contacts: int
    nodes: int
    implied: int
    visited: int
    seconds: dict[str, float]
    megabytes: dict[str, float]


def measure(family: Family, seconds: float, slow: set[str]) -> Row:
    """Measure all; what takes longer than ``seconds`` goes into ``slow`` and is left out from then
    on."""
    graph = family.graph()
    used: dict[str, float] = {}
    memory: dict[str, float] = {}
    best = traced(family, RUNS["best_path"])
    for name in (*RUNS, *PEERS):
        if name in slow or (name in PEERS and graph.intra_connection_count() > MOST[name]):
            continue

        def run(name: str = name) -> object:
            return PEERS[name](family) if name in PEERS else traced(family, RUNS[name])

        used[name], _ = best_run(run, patience=1.0)
        memory[name] = peak(run) / 1e6
        if name in PEERS and not np.allclose(PEERS[name](family), best.gain, rtol=1e-9, atol=1e-6):
            raise AssertionError(f"{name} finds other gains in {family.name}")
        if used[name] > seconds:
            slow.add(name)
    return Row(
        family=family.name,
        objects=len(family.table.names),
        contacts=len(family.contacts),
        nodes=graph.node_count,
        implied=graph.intra_connection_count(),
        visited=int(best.statistics["nodes_visited"]),
        seconds=used,
        megabytes=memory,
    )


def summary(rows: list[Row]) -> str:
    """Two tables: times, and what they are made of."""
    names = [*RUNS, *PEERS]
    times = table(
        ["family", "objects", *(f"{name} [ms]" for name in names)],
        [
            (r.family, f"{r.objects:,}", *(milliseconds(r.seconds.get(n)) for n in names))
            for r in rows
        ],
    )
    sizes = table(
        [
            "family",
            "objects",
            "contacts",
            "nodes",
            "implied intra-connections",
            "visited",
            "best_path [MB]",
            "bytes per contact",
            "SciPy [MB]",
        ],
        [
            (
                r.family,
                f"{r.objects:,}",
                f"{r.contacts:,}",
                f"{r.nodes:,}",
                f"{r.implied:,}",
                f"{r.visited:,}",
                f"{r.megabytes['best_path']:.3g}",
                f"{1e6 * r.megabytes['best_path'] / r.contacts:.0f}",
                f"{r.megabytes['SciPy']:.3g}" if "SciPy" in r.megabytes else "-",
            )
            for r in rows
        ],
    )
    return f"{times}\n\n{sizes}"


def draw(rows: list[Row]) -> Figure:
    """One panel per family."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13, 8), layout="constrained")
    axes = figure.subplots(2, 3, sharex=True, sharey=True).ravel()
    for axis, family in zip(axes, dict.fromkeys(row.family for row in rows), strict=True):
        here = [row for row in rows if row.family == family]
        for name, colour in COLOURS.items():
            points = [
                (row.objects, 1000 * row.seconds[name]) for row in here if name in row.seconds
            ]
            axis.plot(
                *zip(*points, strict=True),
                "--s" if name in PEERS else "-o",
                color=colour,
                label=name,
                markersize=4,
                linewidth=1.3,
            )
        axis.set(xscale="log", yscale="log", title=family)
        axis.grid(alpha=0.25)
    for axis in axes[3:]:
        axis.set_xlabel("objects")
    for axis in axes[::3]:
        axis.set_ylabel("run time with building the graph [ms]")
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=7, frameon=False
    )
    return figure


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--largest", type=int, default=SIZES[-1], help=f"objects at most ({SIZES[-1]})"
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=20.0,
        help="what takes longer at one size is left out at larger ones (20)",
    )
    options = parser.parse_args()
    rows = []
    for make in FAMILIES.values():
        slow: set[str] = set()
        rows += [
            measure(make(size), options.seconds, slow) for size in SIZES if size <= options.largest
        ]
    text = (
        "One source, up to 10 listeners; processor time with building the graph, the best of "
        "some runs. `best_path` ends at -120 dB, `as_in_the_paper` at the default limits; the "
        "peers, whose gains are checked to be the same, have none. `visited`: nodes that "
        "`best_path` reaches, of those present. Left out (-): peers where the explicit graph would "
        "be too large.\n\n" + summary(rows)
    )
    publish(
        "propagation_scaling",
        f"Propagation from 10 to {options.largest:,} objects",
        text,
        [asdict(row) for row in rows],
        draw(rows),
    )


if __name__ == "__main__":
    main()
