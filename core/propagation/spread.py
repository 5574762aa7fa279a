"""How a signal spreads: the strongest arrival at every node from any of the sources, and its
predecessor.

The forest of strongest arrivals has at most one connection per node. The overlay draws it instead
of the implied intra-connections, which are too many.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, SourceNodes
from .shortest_paths import LIMIT, shortest_paths

ROWS_AT_ONCE = 1 << 20
"""Sources are treated together up to this number of pairs of source and node, a bound on memory."""


@frozen
class Spread:
    """The strongest arrival at each node.

    Attributes:
        amplitude: (n,) largest product of a source's amplitude and the gains from it to the node; 0
            if nothing arrives. A source's own node has its amplitude. The gains are those of each
            source's leading band where functions use bands.
        predecessor: (n,) the node before it; -1 at sources and where nothing arrives. Following
            predecessors never lowers the amplitude.
    """

    amplitude: FloatArray
    predecessor: IntArray


def spread(graph: HapticGraph, sources: Collection[str] | None = None) -> Spread:
    """The spread from all sources of ``graph``, or from those named in ``sources``.

    A caller for another mode must pass the graph of that mode.
    """
    result = Spread(np.zeros(graph.node_count), np.full(graph.node_count, -1, dtype=np.int64))
    emitting = [
        s for s in graph.sources if s.amplitude > 0 and (sources is None or s.name in sources)
    ]
    at_once = max(1, ROWS_AT_ONCE // max(graph.node_count, 1))
    for first in range(0, len(emitting), at_once):
        _add_strongest(result, graph, emitting[first : first + at_once])
    return result


def _add_strongest(result: Spread, graph: HapticGraph, sources: Sequence[SourceNodes]) -> None:
    """Take over what arrives from ``sources`` where it is stronger."""
    cost, came_from = _strongest(graph, sources)
    amplitude = np.array([source.amplitude for source in sources])[:, None] * np.exp(-cost)
    best = amplitude.argmax(axis=0)[None, :]
    strongest = np.take_along_axis(amplitude, best, axis=0)[0]
    stronger = strongest > result.amplitude
    result.amplitude[stronger] = strongest[stronger]
    result.predecessor[stronger] = np.take_along_axis(came_from, best, axis=0)[0][stronger]


def _strongest(graph: HapticGraph, sources: Sequence[SourceNodes]) -> tuple[FloatArray, IntArray]:
    """Cost and predecessor (r, n) of every node from each source, over its intra- or its
    inter-connection."""
    trees = shortest_paths(
        graph, [source.nodes for source in sources], [source.band for source in sources]
    )
    crossing = np.stack([graph.in_band(source.band).crossing_costs() for source in sources])
    contacts = contacts_crossed(graph, trees.entry)
    over = np.where(graph.partner >= 0, graph.partner, 0)
    across = np.where(graph.partner >= 0, trees.cost + crossing, np.inf)[:, over]
    across[:, graph.partner < 0] = np.inf
    across[across > LIMIT] = np.inf
    # Ties go to fewer contacts, so that following predecessors always approaches the source.
    crosses = (across < trees.cost) | ((across == trees.cost) & (contacts[:, over] < contacts))
    cost = np.minimum(trees.cost, across)
    came_from = np.where(np.isinf(cost), -1, np.where(crosses, over, trees.entry))
    for row, source in enumerate(sources):
        nodes = list(source.nodes)
        cost[row, nodes], came_from[row, nodes] = 0.0, -1
    return cost, came_from


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
