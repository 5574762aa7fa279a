"""Draws docs/pictures/levels.svg: the level in a pile of boxes against the threshold, by strategy.

python docs/pictures/draw_levels.py

The pile: 5 x 5 x 4 boxes of 40 cm, κ 0.1 and ρ 0.9, of which 60 % of all neighbours touch. The same
bytes each time.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import matplotlib
import numpy as np
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from matplotlib.figure import Figure

SIZE, COUNTS, TOUCHING = 0.4, (5, 5, 4), 0.6
SOURCES, LISTENERS = 4, 10
THRESHOLDS = 10.0 ** -np.linspace(1, 4, 25)
BUDGET = 1 << 30
SHOWN = (0.98, 0.6, 0.2)
"""Quantiles of the pairs that are drawn: a near one, a farther one, and one in the middle."""
CURVES = {
    Strategy.ALL_PATHS: ("All Paths", "#1f5fa8"),
    Strategy.BEST_PATH: ("Best Path (the default)", "#1a6b3c"),
    Strategy.ENERGY_BALANCE: ("Energy Balance", "#b08900"),
}


def pile() -> HapticScene:
    """The boxes, sources and listeners in some of them."""
    random = np.random.default_rng(1)
    cells = [np.array(cell) for cell in itertools.product(*map(range, COUNTS))]
    names = {tuple(cell): f"box {number:02d}" for number, cell in enumerate(cells)}
    contacts = []
    for cell, step in itertools.product(cells, np.eye(3, dtype=int)):
        beside = cell + step
        if tuple(beside) in names and random.uniform() < TOUCHING:
            place = tuple(((cell + beside) / 2 * SIZE).tolist())
            contacts.append(Contact((names[tuple(cell)], names[tuple(beside)]), (place, place)))
    ends = [
        (names[tuple(cells[k])], tuple((cells[k] * SIZE).tolist()))
        for k in random.permutation(len(cells))[: SOURCES + LISTENERS]
    ]
    return HapticScene(
        tuple(HapticObject(name, 0.1, 0.9) for name in names.values()),
        tuple(contacts),
        tuple(Source(f"source {k}", *end) for k, end in enumerate(ends[:SOURCES])),
        tuple(Listener(f"listener {k}", *end) for k, end in enumerate(ends[SOURCES:])),
    )


def drawn() -> Figure:
    """Levels of three pairs, by strategy."""
    graph = graph_of_scene(pile())
    best = propagate(graph, Settings(threshold=0.0)).gain
    order = np.argsort(best, axis=None)
    pairs = [np.unravel_index(order[int(part * (len(order) - 1))], best.shape) for part in SHOWN]
    figure = Figure(figsize=(7.2, 4.0), layout="constrained")
    axis = figure.subplots()
    for strategy, (name, colour) in CURVES.items():
        gains = np.array(
            [
                propagate(
                    graph, Settings(strategy=strategy, threshold=t, max_connections=None), BUDGET
                ).gain
                for t in THRESHOLDS
            ]
        )
        for pair, style in zip(pairs, ("-", "--", ":"), strict=True):
            here = gains[:, *pair]
            level = np.where(here > 0, 20 * np.log10(np.maximum(here, 1e-12)), np.nan)
            axis.plot(
                THRESHOLDS,
                level,
                style,
                color=colour,
                linewidth=1.8,
                label=name if style == "-" else None,
            )
    axis.axhline(0, color="#888", linewidth=0.8)
    axis.text(THRESHOLDS[-1], 1.0, "as strong as the source", color="#666", fontsize=8, ha="right")
    axis.axvline(Settings().threshold, color="#888", linewidth=0.8, linestyle=(0, (4, 4)))
    axis.text(Settings().threshold * 0.97, -59, "default", color="#666", fontsize=8)
    axis.set(xscale="log", xlabel="threshold", ylabel="level at the listener [dB]", ylim=(-70, 30))
    axis.invert_xaxis()
    axis.grid(alpha=0.25)
    axis.legend(frameon=False, fontsize=8, loc="lower center", ncols=3)
    return figure


if __name__ == "__main__":
    matplotlib.rcParams["svg.hashsalt"] = "levels"
    drawn().savefig(Path(__file__).with_name("levels.svg"), metadata={"Date": None})
