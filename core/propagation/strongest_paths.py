"""Paths in the order of their gain, the strongest first: best-first search (A*) over partial paths.

A partial path is ranked by its cost plus a lower bound on the rest (the cheapest walk to the
target, which may cross contacts that the path has crossed already). Paths are therefore completed
in ascending order of cost: P. E. Hart, N. Nilsson, B. Raphael, "A formal basis for the heuristic
determination of minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4, 1968.
Unlike a shortest-path tree this needs no assumption about the objects' functions; but it may
examine many partial paths, hence the budget.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph
from .connections import HOPS, bounded_exp, cost_limit, intra_costs, path_delay
from .hop_constrained import hop_constrained_paths
from .shortest_paths import shortest_paths

WALKED = 64
"""Length of a partial path, in nodes, whose examination takes about as long as expanding it."""

TAPS = 8
"""Most paths whose delays are given."""

SEARCHED = 4096
"""Most partial paths examined for one pair."""


@frozen
class FoundPath:
    """A path and its cost ``-log(gain)``."""

    cost: float
    nodes: tuple[int, ...]


@dataclass(slots=True)
class _Partial:
    """A partial path that has just entered an object, and its continuations.

    Attributes:
        node: through which the object is entered.
        before: the partial path that it continues, and by which of its continuations.
        contacts: crossed so far.
        ends: nodes at which the continuations leave the object, the most promising first.
        bounds: lower bounds on the cost of all paths by each of these.
        costs: of the path up to the next object, or to the target.
    """

    node: int
    before: tuple[_Partial, int] | None
    contacts: int
    ends: IntArray
    bounds: FloatArray
    costs: FloatArray


def _trail(node: int, before: tuple[_Partial, int] | None) -> list[int]:
    """Nodes of a partial path, from the last one back to the root."""
    nodes = [node]
    while before is not None:
        partial, place = before
        nodes += [int(partial.ends[place]), partial.node]
        before = partial.before
    return nodes


class StrongestPaths(Iterator[FoundPath]):
    """Iterates over the paths from any of ``roots`` to ``target``, the strongest first.

    Args:
        graph: the scene.
        roots: nodes at which paths begin.
        target: node at which they end.
        ahead: (k, n) lower bounds on the cost from entering at a node to the target with at most 0,
            1, ... further contacts; the last row holds for any larger number.
        crossings: most contacts on a path.
        limit: largest cost of a path and of each of its beginnings.
        budget: partial paths after which the iteration stops; `bound` then is a lower bound on the
            cost of all paths not returned.
    """

    def __init__(
        self,
        graph: HapticGraph,
        roots: Sequence[int],
        target: int,
        ahead: FloatArray,
        crossings: float,
        limit: float,
        budget: int,
    ) -> None:
        self._graph = graph
        self._target = target
        self._ahead = ahead
        self._crossings = crossings
        self._limit = limit
        self._budget = budget
        self._crossing = np.append(graph.transmission_loss, math.inf)[graph.contact]
        self._queue: list[tuple[float, int, _Partial, int]] = []
        self._numbers = itertools.count()
        self.expanded = 0
        for root in roots:
            self._expand(root, 0.0, None)

    @property
    def bound(self) -> float:
        """Lower bound on the cost of the paths not yet returned."""
        return self._queue[0][0] if self._queue else math.inf

    def __next__(self) -> FoundPath:
        while self._queue:
            if self.expanded >= self._budget:
                raise StopIteration
            _, _, partial, place = heapq.heappop(self._queue)
            self._push(partial, place + 1)
            end = int(partial.ends[place])
            cost = float(partial.costs[place])
            if end == self._target:
                return FoundPath(cost, (*reversed(_trail(partial.node, partial.before)), end))
            self._expand(int(self._graph.partner[end]), cost, (partial, place))
        raise StopIteration

    def _expand(self, node: int, cost: float, before: tuple[_Partial, int] | None) -> None:
        """Find the continuations of a partial path that has just entered an object through
        ``node``."""
        graph = self._graph
        contacts = 0 if before is None else before[0].contacts + 1
        crossed = _trail(node, before)[1:]
        self.expanded += 1 + len(crossed) // WALKED
        nodes = graph.nodes_of(int(graph.node_object[node]))
        others = np.arange(nodes.start, nodes.stop)
        inside = cost + intra_costs(graph, np.full(len(others), node), others)
        costs = inside + self._crossing[others]
        left = self._crossings - contacts - 1
        if left >= 0:
            row = self._ahead[int(min(left, len(self._ahead) - 1))]
            # Partner -1 only where the crossing costs infinity.
            bounds = costs + row[graph.partner[others]]
            bounds[
                np.isin(graph.contact[others], graph.contact[np.array(crossed, dtype=np.int64)])
            ] = math.inf
        else:
            bounds = np.full(len(others), math.inf)
        bounds[others == node] = math.inf
        bounds[costs > self._limit] = math.inf
        target = self._target - nodes.start
        if 0 <= target < len(others) and self._target != node:
            bounds[target] = costs[target] = inside[target]
        bounds[(inside > self._limit) | (bounds > self._limit)] = math.inf
        useful = np.flatnonzero(bounds < math.inf)
        order = useful[np.lexsort((useful, bounds[useful]))]
        self._push(_Partial(node, before, contacts, others[order], bounds[order], costs[order]), 0)

    def _push(self, partial: _Partial, place: int) -> None:
        if place < len(partial.ends):
            heapq.heappush(
                self._queue, (float(partial.bounds[place]), next(self._numbers), partial, place)
            )


def delay_taps(
    graph: HapticGraph, row: int, column: int, crossings: float, threshold: float, amplified: bool
) -> tuple[tuple[float, float], ...]:
    """Delays of a sum over paths: (delay [s], gain) of up to `TAPS` of the strongest paths of a
    pair, the strongest first.

    Args:
        graph: the scene.
        row: of the source.
        column: of the listener.
        crossings: most contacts on a path.
        threshold: least gain of a path.
        amplified: whether some gain exceeds 1.
    """
    target = int(graph.listener_nodes[column])
    limit = cost_limit(threshold)
    if amplified:
        most = int(min(crossings, graph.contact_count, HOPS))
        ahead = hop_constrained_paths(graph, (target,), math.inf, most, complete=True).costs(
            graph.node_count
        )
        crossings = min(crossings, most)
    else:
        ahead = shortest_paths(graph, [(target,)], np.array([limit]), complete=True).cost
    taps: list[tuple[float, float]] = []
    for path in StrongestPaths(
        graph, graph.sources[row].nodes, target, ahead, crossings, limit, SEARCHED
    ):
        taps.append((path_delay(graph, path.nodes), bounded_exp(-path.cost)))
        if len(taps) == TAPS:
            break
    return tuple(taps)
