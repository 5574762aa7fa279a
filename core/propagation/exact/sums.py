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
from ..connections import HOPS, LARGEST, ROUNDING, SLACK, cost_limit, lanes_of
from ..hop_constrained import hop_constrained_paths
from ..walk_radius import WalkOperator
from .contact_order import contacts_on_paths
from .frontier import Frontier
from .path_search import PathSearch, PathSums
from .step_graph import build_step_graph

NARROW = 1 / 64
"""Part of the budget for the exact sum where the frontier is quick, and for the one that bounds
what limits leave out."""

ROUNDS = (NARROW, 1 / 16, 0.0), (1.0, 1.0, 1.0)
"""In turn: parts of the budget for the frontier and for the search, and of the tolerance that the
search uses. What is narrow or has few paths is summed exactly before much work is spent on the
wrong one of them."""

PAIRS = 1 << 22
"""Most pairs of nodes in a search; a larger scene is not searched."""

LONG = 64
"""Limit of contacts on a path above which the sum in a forest is taken from the best path, whose
gain is rounded in its exponent; below it the product of its gains is."""

EXACT = 1e-11
"""Relative difference between two sums up to which they count as equal, because of rounding."""


@frozen
class PathLimits:
    """Limits of the paths: most contacts (``crossings``) and least gain (``threshold``) of a path;
    the relative error asked for (``tolerance``) if the exact sum takes more than the ``budget`` of
    partial paths, states and transitions."""

    crossings: float
    threshold: float
    tolerance: float
    budget: int


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


def bounded_sums(
    graph: HapticGraph,
    operator: WalkOperator,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    costs: tuple[FloatArray, FloatArray] | None,
    least: FloatArray,
) -> BoundedSums:
    """The sums over the paths within the limits from the nodes ``roots`` of a source to each of the
    nodes ``listeners``.

    Args:
        graph: the scene.
        operator: its walk operator.
        roots: nodes at which paths begin.
        listeners: nodes at which they end, at least one.
        limits: threshold, contacts, tolerance and work.
        costs: least costs as in `sum_over_paths`.
        least: (l, lanes) gains of known paths within the limits: no sum is less.
    """
    no = np.zeros(len(listeners), dtype=np.bool_)
    known = np.all((least[:, 0] > 0) & (least[:, 0] < LARGEST))
    if known and limits.crossings > LONG and len(roots) == 1 and not operator.has_cycles:
        # In a forest a single path leads to each listener.
        return BoundedSums(least, np.zeros(len(no)), no, no, np.ones(len(no), dtype=np.int64), 0)
    sums = sum_over_paths(graph, roots, listeners, limits, costs)
    most = np.where(sums.missing < LARGEST, sums.gain[:, 0] + sums.missing, math.inf)
    gain = np.where((sums.missing > 0)[:, None], np.maximum(sums.gain, least), sums.gain)
    error = np.maximum(most - gain[:, 0], 0.0)
    tolerated = limits.tolerance * gain[:, 0] * (1 + ROUNDING)
    uncertain = error > tolerated
    has_limits = limits.threshold > 0 or limits.crossings < graph.contact_count
    limited = no
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


def _without_limits(
    graph: HapticGraph,
    operator: WalkOperator,
    roots: Sequence[int],
    listeners: Sequence[int],
    budget: int,
) -> FloatArray:
    """Upper bounds (l,) on the sums over all paths, infinite where nothing bounds them.

    They are these sums themselves where the scene is narrow, such as a forest, and otherwise the
    sums over all walks.
    """
    nothing = np.full(len(listeners), math.inf)
    if not operator.radius.well_posed:
        return nothing
    contacts = contacts_on_paths(graph, roots, listeners)
    exact = Frontier(graph, contacts, roots, listeners, math.inf).sum(NARROW * budget)
    totals = operator.totals(roots, listeners) if exact is None else exact[:, 0]
    return nothing if totals is None else np.where(totals < LARGEST, totals, math.inf)


def sum_over_paths(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    costs: tuple[FloatArray, FloatArray] | None = None,
) -> PathSums:
    """The sums over the paths within limits.

    Args:
        graph: the scene.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        limits: threshold, contacts, tolerance and work.
        costs: (n,) least cost from the roots to each node, and (n,) from entering at it to any
            listener, infinite where they are above the threshold's; None if some gain exceeds 1.
    """
    if limits.threshold == 0:
        return _all_paths(graph, roots, listeners, limits)
    limit = cost_limit(limits.threshold) + SLACK
    if costs is None:
        most = int(min(limits.crossings, graph.contact_count, HOPS))
        walks = hop_constrained_paths(graph, roots, limit, most, complete=True)
        arrival = behind = np.zeros(graph.node_count)
        if walks.complete or most == limits.crossings:
            arrival = walks.costs(graph.node_count)[-1]
    else:
        arrival, behind = costs
    before = arrival[graph.partner] + np.append(graph.transmission_loss, math.inf)[graph.contact]
    before[list(roots)] = 0.0
    entries = np.flatnonzero((graph.partner >= 0) & (before + behind <= limit))
    paths = build_step_graph(graph, entries, roots, listeners, (before, behind, limit))
    ahead = None if costs is None else np.exp(-behind[paths.nodes])
    return PathSearch(paths, limits.crossings, limits.threshold, ahead).run(0.0, limits.budget)


def _all_paths(
    graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int], limits: PathLimits
) -> PathSums:
    """The sums without a threshold: exact from the frontier where the scene is narrow enough, else
    by the search."""
    contacts = contacts_on_paths(graph, roots, listeners)
    crossings, tolerance = limits.crossings, 0.0
    if crossings >= len(contacts):
        crossings, tolerance = math.inf, limits.tolerance
    frontier = Frontier(graph, contacts, roots, listeners, crossings)
    search = None
    sizes = np.bincount(graph.node_object[contacts.reshape(-1)])
    searchable = int((sizes * sizes).sum()) <= PAIRS
    spent = 0
    nothing = np.zeros(len(listeners))
    uncounted = nothing.astype(np.int64) - 1
    found = PathSums(np.zeros((len(listeners), lanes_of(graph))), nothing + LARGEST, uncounted, 0)
    for for_frontier, for_search, tolerated in ROUNDS:
        exact = frontier.sum(for_frontier * limits.budget)
        if exact is not None:
            found = replace(found, gain=exact, missing=nothing)
        elif searchable:
            search = search or PathSearch(
                build_step_graph(graph, contacts.reshape(-1), roots, listeners), crossings
            )
            found = search.run(tolerated * tolerance, int(for_search * limits.budget))
            spent += found.work
        if found.known_to(tolerance):
            break
    return replace(found, paths=uncounted, work=spent + int(frontier.work))
