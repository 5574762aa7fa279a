"""`all_paths`: sums over paths with bounds on what is missing from them.

All paths are summed exactly by the frontier, or most of them by a search that bounds the rest;
those whose gain stays at a threshold, by the search alone. A threshold and a limit of connections
bound the effort; the quantity asked for is the sum over all paths. Where that is well posed (in a
forest, or with a spectral radius of the walk operator below 1) the sum over all walks bounds what
the limits leave out. Elsewhere nothing does: such a sum is set by its limits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from ...frozen import frozen
from ...graph.haptic_graph import HapticGraph
from ..connections import (
    HOPS,
    LARGEST,
    ROUNDING,
    SLACK,
    PathConnections,
    bounded_exp,
    cost_limit,
    lanes_of,
)
from ..hop_constrained import hop_constrained_paths
from ..shortest_paths import ShortestPaths, shortest_paths
from ..walk_radius import WalkOperator
from .contact_order import contacts_on_paths
from .frontier import Frontier
from .path_search import PathLimits, PathSearch, PathSums
from .step_graph import build_step_graph

NARROW, WIDE = 4, 60
"""Transitions of the frontier per state that its order predicts: in a scene as narrow as a wall,
and where it is given up (in the families of the benchmarks there are 1 to 170)."""

QUICK = 1 / 64
SHARE = 0.4
"""Parts of the budget for the first attempt with the frontier, and for the second, whose unit of
work takes longer than the search's."""

PAIRS = 1 << 22
"""Most pairs of nodes in a search; a larger scene is not searched."""

LONG = 64
"""Limit of contacts on a path above which the sum in a forest is taken from the best path, whose
gain is exactly rounded."""

EXACT = 1e-11
"""Relative difference between two sums up to which they count as equal, because of rounding."""


@frozen
class BoundedSums:
    """Sums over paths from one source.

    Attributes:
        gain: (l, lanes) of each listener: the plain gain, then that of each band where bands are
            used.
        error: (l,) the sum over all paths lies in ``[gain, gain + error]``; infinite where nothing
            bounds it.
        limited: (l,) whether the limits may leave out more than the tolerance.
        uncertain: (l,) whether the budget ended before the sum within the limits was known to the
            tolerance.
        paths: (l,) number of paths summed, -1 where they were not counted.
        work: work done.
    """

    gain: FloatArray
    error: FloatArray
    limited: BoolArray
    uncertain: BoolArray
    paths: IntArray
    work: int


@frozen
class ThresholdCosts:
    """Shortest paths up to a threshold. ``forward``: those of each source (a row); ``behind`` (n,):
    least cost from entering at a node to any listener."""

    forward: ShortestPaths
    behind: FloatArray


def threshold_costs(
    graph: HapticGraph, sources: Sequence[Sequence[int]], threshold: float
) -> ThresholdCosts:
    """Costs from the nodes of each source and from all listeners together, up to the threshold. No
    gain may exceed 1."""
    limit = cost_limit(threshold) + SLACK
    trees = shortest_paths(
        graph,
        [*sources, graph.listener_nodes.tolist()],
        np.full(len(sources) + 1, limit),
        complete=True,
    )
    return ThresholdCosts(
        ShortestPaths(trees.cost[:-1], trees.entry[:-1], trees.relaxed), trees.cost[-1]
    )


def bounded_sums(
    graph: HapticGraph,
    operator: WalkOperator,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    known: tuple[ThresholdCosts, int] | None,
    least: FloatArray,
) -> BoundedSums:
    """The sum over the paths within the limits from the nodes ``roots`` of a source to each of the
    nodes ``listeners``.

    Args:
        operator: the walk operator of the graph.
        known: costs up to the threshold, and the source's row in them; None if some gain exceeds 1.
        least: (l, lanes) gains of known paths within the limits: no sum is less.
    """
    known_paths = np.all((least[:, 0] > 0) & (least[:, 0] < LARGEST))
    if not listeners or (
        limits.crossings > LONG and not operator.has_cycles and len(roots) == 1 and known_paths
    ):
        no = np.zeros(len(listeners), dtype=np.bool_)  # one path alone leads to each listener
        return BoundedSums(
            least, np.zeros(len(listeners)), no, no, np.ones(len(listeners), dtype=np.int64), 0
        )
    sums = sum_over_paths(graph, roots, listeners, limits, known)
    most = np.where(sums.missing < LARGEST, sums.gain[:, 0] + sums.missing, math.inf)
    gain = np.where((sums.missing > 0)[:, None], np.maximum(sums.gain, least), sums.gain)
    error = np.maximum(most - gain[:, 0], 0.0)
    tolerated = limits.tolerance * gain[:, 0] * (1 + ROUNDING)
    uncertain = error > tolerated
    has_limits = limits.threshold > 0 or limits.crossings < graph.contact_count
    limited = np.zeros(len(listeners), dtype=np.bool_)
    if has_limits or uncertain.any():
        bound = _without_limits(graph, operator, roots, listeners, limits.budget) - gain[:, 0]
        bound = np.where(
            np.isnan(bound) | (gain[:, 0] >= LARGEST),
            math.inf,
            np.where(bound <= EXACT * gain[:, 0], 0.0, bound),
        )
        error = bound if has_limits else np.minimum(error, bound)
        limited = has_limits & (bound > tolerated)
    return BoundedSums(gain, error, limited, uncertain, sums.paths, sums.work)


def path_gain(graph: HapticGraph, path: tuple[int, ...], cost: float) -> FloatArray:
    """Gains (lanes,) of one path."""
    gain = np.full(lanes_of(graph), bounded_exp(-cost))
    gain[1:] *= PathConnections(graph, [path]).bands()[0, : len(gain) - 1]
    return gain


def _without_limits(
    graph: HapticGraph,
    operator: WalkOperator,
    roots: Sequence[int],
    listeners: Sequence[int],
    budget: int,
) -> FloatArray:
    """Upper bounds (l,) on the sums over all paths, infinite where nothing bounds them.

    They are these sums themselves where the scene is narrow, such as a forest, and otherwise the
    sums over all walks, series with as many terms as the longest chain has contacts.

    Args:
        graph: the scene.
        operator: its walk operator.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        budget: work allowed.
    """
    nothing = np.full(len(listeners), math.inf)
    if not operator.radius.well_posed:
        return nothing
    frontier = Frontier(
        graph, contacts_on_paths(graph, roots, listeners), roots, listeners, math.inf
    )
    exact = frontier.sum(QUICK / 4 * budget)
    totals = operator.totals(roots, listeners) if exact is None else exact[:, 0]
    return nothing if totals is None else np.where(totals < LARGEST, totals, math.inf)


def sum_over_paths(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    known: tuple[ThresholdCosts, int] | None = None,
) -> PathSums:
    """The sums over the paths within limits, as in `bounded_sums`.

    Args:
        graph: the scene.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        limits: threshold, contacts, tolerance and work.
        known: least costs for all sources, and the row of this one.
    """
    if limits.threshold == 0:
        return _all_paths(graph, roots, listeners, limits)
    limit = cost_limit(limits.threshold) + SLACK
    behind = np.zeros(graph.node_count)
    if known is None:
        most = int(min(limits.crossings, graph.contact_count))
        reached = hop_constrained_paths(graph, roots, limit, min(most, HOPS), complete=True)
        arrival = (
            reached.costs(graph.node_count)[-1] if reached.complete or most <= HOPS else behind
        )
    else:
        arrival = known[0].forward.cost[known[1]]
        behind = known[0].behind
    before = arrival[graph.partner] + np.append(graph.transmission_loss, math.inf)[graph.contact]
    before[list(roots)] = 0.0
    entries = np.flatnonzero((graph.partner >= 0) & (before + behind <= limit))
    paths = build_step_graph(graph, entries, roots, listeners, (before, behind, limit))
    search = PathSearch(
        paths, limits.crossings, None if known is None else np.exp(-behind[paths.nodes])
    )
    return search.run(replace(limits, tolerance=0.0), np.zeros(len(listeners)))


def _all_paths(
    graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int], limits: PathLimits
) -> PathSums:
    """The sums without a threshold: frontier and search work in turns, with growing parts of the
    budget."""
    contacts = contacts_on_paths(graph, roots, listeners)
    crossings = limits.crossings if limits.crossings < len(contacts) else math.inf
    frontier = Frontier(graph, contacts, roots, listeners, crossings)
    sizes = np.bincount(graph.node_object[contacts.reshape(-1)])
    search = None
    hopeful = frontier.width * WIDE <= limits.budget
    budget = limits.budget
    spent = 0
    none = np.zeros(len(listeners))
    best = PathSums(
        np.zeros((len(listeners), lanes_of(graph))), none + LARGEST, none.astype(np.int64) - 1, 0
    )
    for allowed, share, tolerance in (
        (min(NARROW * frontier.width, QUICK * budget), budget / 16, 0.0),
        (SHARE * budget * hopeful, budget, limits.tolerance),
        (budget * hopeful, 0, 0.0),
    ):
        exact = frontier.sum(allowed)
        if exact is not None:
            best = replace(best, gain=exact, missing=none)
        elif share and int((sizes * sizes).sum()) <= PAIRS:
            search = search or PathSearch(
                build_step_graph(graph, contacts.reshape(-1), roots, listeners), crossings
            )
            found = search.run(PathLimits(crossings, 0.0, tolerance, int(share)), best.gain[:, 0])
            spent += found.work
            most = np.minimum(best.gain[:, 0] + best.missing, found.gain[:, 0] + found.missing)
            gain = np.maximum(best.gain, found.gain)
            best = replace(
                best,
                gain=gain,
                missing=np.where(most < LARGEST, np.maximum(most - gain[:, 0], 0.0), LARGEST),
            )
        if best.known_to(limits.tolerance if crossings == math.inf else 0.0):
            break
    return replace(best, work=spent + int(frontier.work))
