"""What keeping parts of the last frame's propagation saves, by the part of the contacts that has changed.

    python -m benchmarks.bench_propagation_reuse [--bodies 1000] [--frames 120]

Between two frames some contacts move by a millimetre. Of best paths, the labels are counted that are still right in the second frame: the
same cost by the same way, no contact of which has moved. Of sums over paths, those that come out the same. An *ideal* reuse would compute
only the others, at the cost of all in proportion, and nothing else; what it can't do without is timed: the graph, because contact nodes
carry places, and to find out what has changed and which labels hang on it. A reuse that *works* goes on from the labels that are still
right, with the entries of all objects in which one is not; its costs are checked to be those of a fresh run,
but for rounding.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
from dataclasses import asdict, dataclass

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from haptic_tracing.core.graph.haptic_graph import HapticGraph, distances
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.connections import cost_limit
from haptic_tracing.core.propagation.shortest_paths import Labels, _step, _Work, label
from haptic_tracing.core.scene.values import Settings, Strategy

from .families import Family, pile
from .frames import demo_family, falling_boxes
from .report import milliseconds, publish, table
from .timing import best_time

RUNS = 15

BEST = Settings(strategy=Strategy.BEST_PATH)
PARTS = (0.01, 0.1, 0.5, 1.0)
MOVED = 1e-3
"""Metres."""


@dataclass(frozen=True, slots=True)
class Row:
    """One pair of frames: parts of the contacts that have changed and of the results that are still right; seconds of graph and propagation
    anew, of the graph alone, of finding out, and of graph and propagation with an ideal reuse and with one that works."""

    scene: str
    changed: float
    valid: float
    anew: float
    graph: float
    finding: float
    ideal: float
    working: float | None


def labels_of(graph: HapticGraph) -> Labels:
    """Those that best paths are found by."""
    sources = [source.nodes for source in graph.sources]
    return label(graph, sources, np.full(len(sources), cost_limit(BEST.threshold)), np.unique(graph.listener_nodes))


def same_nodes(before: HapticGraph, after: HapticGraph) -> np.ndarray:
    """The number that each node of ``after`` had before, -1 where it is new or was elsewhere, or where its contact has changed."""
    if np.array_equal(before.node_object, after.node_object) and np.array_equal(before.partner, after.partner):  # none came, none went
        old, same = np.arange(after.node_count), np.ones(after.node_count, dtype=np.bool_)
    else:
        keys = [_keys(graph) for graph in (before, after)]
        order = np.argsort(keys[0], kind="stable")
        old = order[np.minimum(np.searchsorted(keys[0][order], keys[1]), len(order) - 1)]
        same = keys[0][old] == keys[1]
    for axis in range(3):
        same &= before.node_position[old, axis] == after.node_position[:, axis]
    crossed = np.flatnonzero(after.partner >= 0)
    same[crossed] &= same[after.partner[crossed]]
    same[crossed] &= before.transmission[before.contact[old[crossed]]] == after.transmission[after.contact[crossed]]
    return np.where(same, old, -1)


def _keys(graph: HapticGraph) -> np.ndarray:
    """(n,) by which a node is known again: its object and the one that it touches, or which source or listener it is."""
    other = graph.node_object[graph.partner]
    ends = np.flatnonzero(graph.partner < 0)
    other[ends] = -1 - np.arange(len(ends))  # the same ones in the same order
    return graph.node_object * (len(graph.table.names) + len(ends) + 1) + other + len(ends)


def renumbered(labels: Labels, old: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Costs and entries (r, n) of the frame before for the nodes of this one; -1 where nothing arrived, -2 for an entry that is no more."""
    kept = np.flatnonzero(old >= 0)
    if labels.entry.shape[1] == len(old) and np.array_equal(old[kept], kept):  # none came, none went
        return labels.arrival, labels.entry
    number = np.full(labels.entry.shape[1] + 1, -2, dtype=np.int64)
    number[-1] = -1
    number[old[kept]] = kept
    return labels.arrival[:, old], number[labels.entry[:, old]]


def still_right(after: HapticGraph, entry: np.ndarray, old: np.ndarray) -> np.ndarray:
    """(r, n) which of the entries come by a way of which nothing has moved."""
    rows, count = entry.shape
    same = old >= 0
    valid = (entry >= 0) & same & same[entry]
    before = np.where(valid, after.partner[entry], -1)
    pointer = np.where(before >= 0, before + count * np.arange(rows)[:, None], -1).reshape(-1)
    right = valid.flatten()
    pending = np.flatnonzero(pointer >= 0)
    while len(pending):
        back = pointer[pending]
        right[pending] &= right[back]
        pointer[pending] = pointer[back]
        pending = pending[pointer[pending] >= 0]
    return right.reshape(rows, count)


def found_out(before: HapticGraph, after: HapticGraph, known: Labels) -> np.ndarray:
    """(r, n) which labels are still right."""
    old = same_nodes(before, after)
    return still_right(after, renumbered(known, old)[1], old)


def carried_on(after: HapticGraph, known: Labels, old: np.ndarray) -> np.ndarray:
    """(r, n) costs of arriving, from the labels of the frame before that are still right."""
    rows = len(after.sources)
    arrival, entry = renumbered(known, old)
    right = still_right(after, entry, old)
    work = _Work(after, rows, np.full(rows, cost_limit(BEST.threshold)), False)
    work.arrival[right], work.entry[right] = arrival[right], entry[right]
    stale = ((entry != -1) & ~right) | (old < 0)
    filled = np.flatnonzero(np.diff(after.start))
    touched = np.zeros((rows, len(after.table.names)), dtype=np.bool_)
    touched[:, filled] = np.logical_or.reduceat(stale, after.start[filled], axis=1)
    cost = np.where(after.partner >= 0, work.arrival[:, after.partner] + work.crossing, np.inf)
    for row, source in enumerate(after.sources):
        cost[row, list(source.nodes)] = 0.0
    place, node = np.nonzero((cost <= work.limits[:, None]) & touched[:, after.node_object])
    pending = place, node, cost[place, node]
    targets = np.unique(after.listener_nodes)
    while len(pending[0]):
        pending = _step(work, *pending)
        np.minimum(work.limits, work.arrival[:, targets].max(axis=1), out=work.limits)
    return work.arrival


def compare(scene: str, before: Family, after: Family, settings: Settings) -> Row:
    """What the second frame could take over from the first one."""
    first, second = before.graph(), after.graph()
    old = same_nodes(first, second)
    crossed = second.partner >= 0
    changed = float(np.mean(old[crossed] < 0))
    building = best_time(lambda: after.graph(), RUNS)
    anew = best_time(lambda: propagate(after.graph(), settings), RUNS)
    if settings.strategy is Strategy.BEST_PATH:
        known, fresh = labels_of(first), labels_of(second)
        arrival, entry = renumbered(known, old)
        right = still_right(second, entry, old) & (arrival == fresh.arrival)
        reached = np.count_nonzero(fresh.entry >= 0)
        valid = np.count_nonzero(right & (fresh.entry >= 0)) / reached
        finding = best_time(lambda: found_out(first, second, known), RUNS)
        targets = second.listener_nodes
        limit = cost_limit(BEST.threshold)
        ours, expected = carried_on(second, known, old)[:, targets], fresh.arrival[:, targets]
        if not np.allclose(np.minimum(ours, limit), np.minimum(expected, limit), rtol=1e-12, atol=0):
            raise AssertionError("other gains")
        labels = best_time(lambda: labels_of(second), RUNS)
        working = anew - labels + best_time(lambda: carried_on(second, known, same_nodes(first, second)), RUNS)
    else:
        working = None
        valid = float(np.mean(propagate(first, settings).gain == propagate(second, settings).gain))
        finding = best_time(lambda: same_nodes(first, second), RUNS)
    ideal = building + finding + (1 - valid) * (anew - building)
    return Row(scene, changed, valid, anew, building, finding, ideal, working)


def nudged(family: Family, chosen: np.ndarray) -> Family:
    """The contacts ``chosen`` elsewhere by a millimetre."""
    positions = family.contacts.positions.copy()
    positions[chosen] += np.random.default_rng(1).uniform(-MOVED, MOVED, (len(chosen), 1, 3))
    return dataclasses.replace(family, contacts=dataclasses.replace(family.contacts, positions=positions))


def scattered(family: Family, part: float) -> np.ndarray:
    """A part of the contacts, anywhere."""
    count = len(family.contacts)
    return np.random.default_rng(2).choice(count, max(1, round(part * count)), replace=False)


def local(family: Family, part: float, away: bool) -> np.ndarray:
    """A part of the contacts, those around a place: a source, or as far as can be from all sources and listeners."""
    centre = family.contacts.positions.mean(axis=1)
    if away:
        ends = np.array([item.position for item in (*family.sources, *family.listeners)])
        place = centre[distances(centre[:, None], ends[None]).min(axis=1).argmax()]
    else:
        place = np.array(family.sources[0].position)
    return np.argsort(distances(centre, place[None]), kind="stable")[: max(1, round(part * len(centre)))]


def measure(bodies: int, frames: int) -> list[Row]:
    """All pairs of frames."""
    demo, heap = demo_family(), pile(1000)
    sums = dataclasses.replace(BEST, strategy=Strategy.ALL_PATHS)
    played = falling_boxes(bodies, frames)
    settled = played[-1]
    rows = [compare("demo, all paths: anywhere", demo, nudged(demo, scattered(demo, part)), sums) for part in PARTS]
    rows += [compare("demo, best paths: anywhere", demo, nudged(demo, scattered(demo, part)), BEST) for part in PARTS]
    rows += [compare("pile of 1,000: anywhere", heap, nudged(heap, scattered(heap, part)), BEST) for part in PARTS]
    for where, away in (("around a source", False), ("far from all ends", True)):
        name = f"{bodies:,} settled boxes: {where}"
        rows += [compare(name, settled, nudged(settled, local(settled, part, away)), BEST) for part in PARTS[:-1]]
    rows.append(compare(f"{bodies:,} falling boxes: as simulated", played[-2], played[-1], BEST))
    return rows


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=120)
    options = parser.parse_args()
    rows = measure(options.bodies, options.frames)
    heading = ("scene: what moves", "changed", "still right", "anew", "of it graph", "finding out", "ideal", "at most", "works", "gains")
    lines = [
        (
            row.scene,
            f"{row.changed:.0%}",
            f"{row.valid:.0%}",
            milliseconds(row.anew),
            milliseconds(row.graph),
            milliseconds(row.finding),
            milliseconds(row.ideal),
            f"{row.anew / row.ideal:.2f} times",
            milliseconds(row.working),
            "-" if row.working is None else f"{row.anew / row.working:.2f} times",
        )
        for row in rows
    ]
    note = "Milliseconds of the processor, one thread. Changed: of the contacts. Still right: of the labels of best paths, or of the sums."
    data = [asdict(row) for row in rows]
    publish("propagation_reuse", "What keeping parts of the last frame saves", f"{note}\n\n{table(heading, lines)}", data)


if __name__ == "__main__":
    main()
