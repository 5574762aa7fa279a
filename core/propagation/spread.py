"""How a signal spreads: the strongest arrival at every node from any of the sources, and where it came from.

All implied intra-connections of a frame can't be drawn, and say little: this tree of strongest arrivals has at most one connection per
node and shows where the signal goes.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from ..scene.values import Settings
from .best_path import ERROR_LIMIT, SLACK, crossings_of
from .connections import amplifying, cost_limit
from .hop_constrained import layers
from .shortest_paths import label

ROWS_AT_ONCE = 1 << 20
"""Nodes of several sources are labelled together up to this number, a bound on memory."""
LAYERS_UNLIMITED = 64
"""Contacts crossed where gains exceed 1 and nothing limits the connections."""


@dataclass(frozen=True, slots=True)
class Spread:
    """``gain`` (n,): the largest product from any source to each node, the source's amplitude included, 0 where nothing arrives;
    a source's own node has its amplitude. ``predecessor`` (n,): the node that it came from, -1 at sources and where nothing arrives.
    Where no gain exceeds 1, following predecessors never lowers the gain."""

    gain: FloatArray
    predecessor: IntArray


def spread(graph: HapticGraph, settings: Settings, sources: Collection[str] | None = None) -> Spread:
    """The spread from all sources of ``graph``, or from those named in ``sources``, within the two limits of ``settings``. The graph is
    taken as it is: a rendering that exchanges its functions does so before."""
    result = Spread(np.zeros(graph.node_count), np.full(graph.node_count, -1, dtype=np.int64))
    emitting = [s for s in graph.sources if s.amplitude > 0 and (sources is None or s.name in sources)]
    at_once = max(1, ROWS_AT_ONCE // max(graph.node_count, 1))
    for first in range(0, len(emitting), at_once):
        part = emitting[first : first + at_once]
        cost, came_from = _strongest(graph, [source.nodes for source in part], settings)
        gain = np.array([source.amplitude for source in part])[:, None] * np.exp(np.minimum(-cost, math.log(ERROR_LIMIT)))
        best = gain.argmax(axis=0)[None, :]
        strongest = np.take_along_axis(gain, best, axis=0)[0]
        stronger = strongest > result.gain
        result.gain[stronger] = strongest[stronger]
        result.predecessor[stronger] = np.take_along_axis(came_from, best, axis=0)[0][stronger]
    return result


def _strongest(graph: HapticGraph, roots: list[tuple[int, ...]], settings: Settings) -> tuple[FloatArray, IntArray]:
    """Cost and predecessor of every node (r, n) from each set of roots, by whichever connection costs less."""
    limit = cost_limit(settings.threshold)
    most = settings.max_connections
    inside, entry, contacts = _arrivals(graph, roots, limit, crossings_of(most))
    # Arriving in an object and going on over a contact takes one connection more than arriving.
    one_less = most is not None and most % 2 == 1
    before, _, crossed_before = _arrivals(graph, roots, limit, crossings_of(most) - 1) if one_less else (inside, entry, contacts)
    crossed = graph.partner >= 0
    over = np.where(crossed, graph.partner, 0)
    across = np.full(inside.shape, math.inf)
    across[:, crossed] = before[:, over[crossed]] + graph.transmission_loss[graph.contact[crossed]]
    across[across > limit] = math.inf
    # Of equal ways the shorter one, so that following predecessors always comes closer to the source.
    crosses = (across < inside) | ((across == inside) & (crossed_before[:, over] < contacts))
    cost = np.minimum(inside, across)
    came_from = np.where(np.isinf(cost), -1, np.where(crosses, over, entry))
    for row, nodes in enumerate(roots):
        cost[row, list(nodes)], came_from[row, list(nodes)] = 0.0, -1
    return cost, came_from


def _arrivals(graph: HapticGraph, roots: list[tuple[int, ...]], limit: float, crossings: float) -> tuple[FloatArray, IntArray, IntArray]:
    """Cost of arriving at every node inside its object, the node through which that was entered, and the contacts crossed, each (r, n)."""
    shape = len(roots), graph.node_count
    if crossings < 0:
        return np.full(shape, math.inf), np.full(shape, -1, dtype=np.int64), np.zeros(shape, dtype=np.int64)
    if amplifying(graph):
        rows = np.arange(len(roots))
        arrival, entry, contacts = np.full(shape, math.inf), np.full(shape, -1, dtype=np.int64), np.zeros(shape, dtype=np.int64)
    else:
        labels = label(graph, roots, np.full(len(roots), limit + SLACK))
        arrival, entry, contacts = labels.arrival, labels.entry, contacts_crossed(graph, labels.entry)
        rows = np.flatnonzero((contacts > crossings).any(axis=1))
    most = int(min(crossings, graph.contact_count, LAYERS_UNLIMITED if crossings == math.inf else math.inf))
    for row in rows.tolist():
        arrival[row], entry[row], contacts[row] = math.inf, -1, 0
        for k, (nodes, cost, entered) in enumerate(layers(graph, roots[row], limit + SLACK, most).changes):
            arrival[row, nodes], entry[row, nodes], contacts[row, nodes] = cost, entered, k
    arrival[arrival > limit] = math.inf
    return arrival, entry, contacts


def contacts_crossed(graph: HapticGraph, entry: IntArray) -> IntArray:
    """(r, n) number of contacts on the way to each node of trees given by ``entry`` (r, n), see `Labels`; 0 where there is no way."""
    rows, nodes = entry.shape
    before = np.where(entry >= 0, graph.partner[entry], -1) if nodes else entry
    # Pointer doubling: each node adds up its way back to a node whose sum is already known, twice as far in every round.
    pointer = np.where(before >= 0, before + nodes * np.arange(rows)[:, None], -1).reshape(-1)
    count = (pointer >= 0).astype(np.int64)
    pending = np.flatnonzero(pointer >= 0)
    while len(pending):
        back = pointer[pending]
        count[pending] += count[back]
        pointer[pending] = pointer[back]
        pending = pending[pointer[pending] >= 0]
    return count.reshape(entry.shape)
