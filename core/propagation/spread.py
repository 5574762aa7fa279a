"""How a signal spreads: the strongest arrival at every node from any of the sources, and its
predecessor.

The forest of strongest arrivals has at most one connection per node. The overlay draws it instead
of the implied intra-connections, which are too many.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, SourceNodes
from ..scene.values import Settings
from .best_path import crossings_of, most_connections
from .connections import HOPS, LARGEST, SLACK, amplifying, cost_limit
from .hop_constrained import hop_constrained_paths
from .shortest_paths import shortest_paths

ROWS_AT_ONCE = 1 << 20
"""Sources are treated together up to this number of pairs of source and node, a bound on memory."""


@frozen
class Spread:
    """The strongest arrival at each node.

    Attributes:
        amplitude: (n,) largest product of a source's amplitude and the gains from it to the node; 0
            if nothing arrives. A source's own node has its amplitude. The gains are those of each
            source's leading band where functions use bands.
        predecessor: (n,) the node before it; -1 at sources and where nothing arrives. Where no gain
            exceeds 1, following predecessors never lowers the amplitude.
    """

    amplitude: FloatArray
    predecessor: IntArray


def spread(
    graph: HapticGraph, settings: Settings, sources: Collection[str] | None = None
) -> Spread:
    """The spread from all sources of ``graph``, or from those named in ``sources``, within the two
    limits of ``settings``.

    A caller for another mode must pass the graph of that mode.
    """
    result = Spread(np.zeros(graph.node_count), np.full(graph.node_count, -1, dtype=np.int64))
    emitting = [
        s for s in graph.sources if s.amplitude > 0 and (sources is None or s.name in sources)
    ]
    at_once = max(1, ROWS_AT_ONCE // max(graph.node_count, 1))
    for band in sorted({source.band for source in emitting}):
        in_band = graph.in_band(band)
        alike = [source for source in emitting if source.band == band]
        for first in range(0, len(alike), at_once):
            _add_strongest(result, in_band, alike[first : first + at_once], settings)
    return result


def _add_strongest(
    result: Spread, graph: HapticGraph, sources: Sequence[SourceNodes], settings: Settings
) -> None:
    """Take over what arrives from ``sources`` where it is stronger."""
    cost, came_from = _strongest(graph, [source.nodes for source in sources], settings)
    amplitude = np.array([source.amplitude for source in sources])[:, None] * np.exp(
        np.minimum(-cost, math.log(LARGEST))
    )
    best = amplitude.argmax(axis=0)[None, :]
    strongest = np.take_along_axis(amplitude, best, axis=0)[0]
    stronger = strongest > result.amplitude
    result.amplitude[stronger] = strongest[stronger]
    result.predecessor[stronger] = np.take_along_axis(came_from, best, axis=0)[0][stronger]


def _strongest(
    graph: HapticGraph, roots: list[tuple[int, ...]], settings: Settings
) -> tuple[FloatArray, IntArray]:
    """Cost and predecessor (r, n) of every node from each set of roots, over its intra- or its
    inter-connection."""
    limit = cost_limit(settings.threshold)
    most = most_connections(settings)
    inside, entry, contacts = _arrivals(graph, roots, limit, crossings_of(most))
    # Arriving in an object and going on over a contact takes one connection more than arriving.
    one_less = most is not None and most % 2 == 1
    before, _, crossed_before = (
        _arrivals(graph, roots, limit, crossings_of(most) - 1)
        if one_less
        else (inside, entry, contacts)
    )
    crossed = graph.partner >= 0
    over = np.where(crossed, graph.partner, 0)
    across = np.full(inside.shape, math.inf)
    across[:, crossed] = before[:, over[crossed]] + graph.transmission_loss[graph.contact[crossed]]
    across[across > limit] = math.inf
    # Ties go to fewer contacts, so that following predecessors always approaches the source.
    crosses = (across < inside) | ((across == inside) & (crossed_before[:, over] < contacts))
    cost = np.minimum(inside, across)
    came_from = np.where(np.isinf(cost), -1, np.where(crosses, over, entry))
    for row, nodes in enumerate(roots):
        cost[row, list(nodes)], came_from[row, list(nodes)] = 0.0, -1
    return cost, came_from


def _arrivals(
    graph: HapticGraph, roots: list[tuple[int, ...]], limit: float, crossings: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Cost of arriving at every node inside its object, the node through which that was entered,
    and the contacts crossed; each (r, n)."""
    shape = len(roots), graph.node_count
    if crossings < 0:
        return (
            np.full(shape, math.inf),
            np.full(shape, -1, dtype=np.int64),
            np.zeros(shape, dtype=np.int64),
        )
    if amplifying(graph):
        rows = np.arange(len(roots))
        arrival = np.full(shape, math.inf)
        entry = np.full(shape, -1, dtype=np.int64)
        contacts = np.zeros(shape, dtype=np.int64)
    else:
        trees = shortest_paths(graph, roots, np.full(len(roots), limit + SLACK))
        arrival = trees.cost
        entry = trees.entry
        contacts = contacts_crossed(graph, trees.entry)
        rows = np.flatnonzero((contacts > crossings).any(axis=1))
    most = int(min(crossings, graph.contact_count, HOPS if crossings == math.inf else math.inf))
    for row in rows.tolist():
        arrival[row], entry[row], contacts[row] = math.inf, -1, 0
        for k, (nodes, cost, entered) in enumerate(
            hop_constrained_paths(graph, roots[row], limit + SLACK, most).changes
        ):
            arrival[row, nodes], entry[row, nodes], contacts[row, nodes] = cost, entered, k
    arrival[arrival > limit] = math.inf
    return arrival, entry, contacts


def contacts_crossed(graph: HapticGraph, entry: IntArray) -> IntArray:
    """(r, n) number of contacts on the path to each node of the trees with ``entry`` (r, n) as in
    `ShortestPaths`; 0 where none arrives."""
    rows, nodes = entry.shape
    before = np.where(entry >= 0, graph.partner[entry], -1) if nodes else entry
    # Pointer jumping: in every round each node adds the count of the node that it points to and
    # then points twice as far back.
    pointer = np.where(before >= 0, before + nodes * np.arange(rows)[:, None], -1).reshape(-1)
    count = (pointer >= 0).astype(np.int64)
    pending = np.flatnonzero(pointer >= 0)
    while len(pending):
        back = pointer[pending]
        count[pending] += count[back]
        pointer[pending] = pointer[back]
        pending = pending[pointer[pending] >= 0]
    return count.reshape(entry.shape)
