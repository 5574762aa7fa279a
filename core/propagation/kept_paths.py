"""Best paths that stay the best from frame to frame.

Let some bodies move, and everything else stand still. A path that crosses none of them costs what
it did. One that does leaves the last of them over a contact into a body at the cost E. It is
better for no node of that body than the path that is known if E is at least A - a: A is the cost of
arriving at the contact's node without the moved bodies, and a the constant cost in that body (see
`shortest_paths`). So only the contacts of what has moved are examined.
"""

from __future__ import annotations

import math

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, differing
from ..graph.haptic_graph import HapticGraph
from .best_path import BestPaths, Grown, best_paths
from .shortest_paths import BATCH, SLACK, Search


class KeptPaths:
    """`best_paths`, which are those of an earlier graph where they are still the best. Searches
    that have examined fewer than ``least`` connections are made again, which is as fast."""

    def __init__(self, least: int = BATCH) -> None:
        self._least = least
        self._last: tuple[HapticGraph, BoolArray, BestPaths] | None = None

    def __call__(self, graph: HapticGraph, wanted: BoolArray) -> BestPaths:
        """The best paths of the ``wanted`` (s, l) pairs of a source and a listener."""
        if self._last is not None:
            old, pairs, found = self._last
            grown = found.grown if found.examined >= self._least else None
            if grown is not None and np.array_equal(wanted, pairs) and _stay(old, graph, grown):
                return found
        found = best_paths(graph, wanted)
        self._last = graph, wanted, found
        return found


def _stay(old: HapticGraph, graph: HapticGraph, grown: Grown) -> bool:
    """Whether the paths that have ``grown`` in the ``old`` graph are surely the best ones of
    ``graph``."""
    moved = _moved(old, graph)
    if moved is None:
        return False
    inner = moved.nonzero()[0]
    across = inner[~moved[graph.partner[inner]]]
    nodes = graph.partner[across]  # of other bodies
    search = Search(graph, len(grown.roots), grown.bands, None, grown.backwards, math.inf)
    size, other = search.others(nodes)
    within, begin = search.others(inner)
    if len(other) + len(begin) > graph.node_count:
        return False
    behind = graph.partner[other]
    behind[np.isin(other, nodes)] = -1  # nothing comes from the moved bodies yet
    place = np.full(graph.node_count, -1)
    place[inner] = np.arange(len(inner))
    onwards = place[graph.partner[inner]]
    for row, roots in enumerate(grown.roots):
        cost, entry = grown.trees.cost[row], grown.trees.entry[row]
        if (entry[other] == nodes.repeat(size)).any():
            return False  # a path led through them
        lane = int(search.lane[row])
        crossing, loss = (
            values[lane * search.count : (lane + 1) * search.count]
            for values in (search.crossing, search.loss)
        )
        entering = np.where(behind >= 0, cost[behind] + crossing[behind], math.inf)
        entering[np.isin(other, roots)] = 0.0
        arriving = _least(entering + search.costs(lane, nodes, size, other), size)
        inside = search.costs(lane, inner, within, begin)
        entered = np.full(len(inner), math.inf)
        entered[place[across]] = arriving + crossing[nodes]
        while True:
            leaving = _least(entered[place[begin]] + inside, within) + crossing[inner]
            nearer = np.minimum(entered, np.where(onwards >= 0, leaving[onwards], math.inf))
            if np.array_equal(nearer, entered):
                break
            entered = nearer
        back = leaving[place[across]]
        better = back + loss[nodes] <= arriving + SLACK * (1 + arriving)
        if (better & (back <= grown.trees.limit[row])).any():
            return False
    return True


def _moved(old: HapticGraph, graph: HapticGraph) -> BoolArray | None:
    """Which nodes (n,) are those of bodies that have moved; None if more has changed than the
    contacts of these."""
    if (
        graph.table is not old.table
        or graph.partner is not old.partner
        or graph.sources != old.sources
        or graph.table.special
        or (graph.fronts is None) != (old.fronts is None)
        or (graph.contact_band_gains is None) != (old.contact_band_gains is None)
        or not np.array_equal(_reach(graph), _reach(old))
    ):
        return None
    touched = (graph.node_position.T != old.node_position.T).any(axis=0)
    if graph.fronts is not None:
        touched |= (graph.fronts != old.fronts).any(axis=0)
    values = ("transmission_loss", "contact_band_gains")
    used = values if graph.contact_band_gains is not None else values[:1]
    changed = np.append(differing(old, graph, used), False)
    changed[graph.contact[touched]] = True
    touched = changed[graph.contact]
    alone = np.ones(len(graph.start) - 1, dtype=np.bool_)
    alone[graph.node_object[~touched]] = False
    moved = alone[graph.node_object]
    # A source or a listener belongs to no contact, whose number is -1.
    return moved if not changed[-1] and (moved | moved[graph.partner])[touched].all() else None


def _reach(graph: HapticGraph) -> FloatArray:
    return np.zeros(0) if graph.reach is None else graph.reach


def _least(values: FloatArray, size: IntArray) -> FloatArray:
    """The least of each run of ``size`` (k,) values, infinite of none."""
    found = np.full(len(size), math.inf)
    some = size > 0
    found[some] = np.minimum.reduceat(values, (size.cumsum() - size)[some]) if some.any() else []
    return found
