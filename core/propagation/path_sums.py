"""`all_paths`: sums over paths with bounds on what their limits leave out.

A threshold and a limit of connections bound the effort; the quantity asked for is the sum over all paths. Where that is well posed (in a
forest, or with a spectral radius of the walk operator below 1) the sum over all walks bounds what the limits leave out. Elsewhere nothing
does: such a sum is set by its limits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from .connections import LARGEST, ROUNDING, PathConnections, bounded_exp, lanes_of
from .exact import PathLimits, PathSums, ThresholdCosts, sum_over_paths
from .walk_radius import WalkOperator

EXACT = 1e-11
"""Relative difference to the sum over all walks that rounding explains."""


@dataclass(frozen=True, slots=True)
class BoundedSums:
    """Sums over paths from one source.

    Attributes:
        gain: (l, lanes) of each listener: the plain gain, then that of each band where bands are used.
        error: (l,) the sum over all paths lies in ``[gain, gain + error]``; infinite where nothing bounds it.
        limited: (l,) whether the limits may leave out more than the tolerance.
        uncertain: (l,) whether the budget ended before the sum within the limits was known to the tolerance.
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
    known: tuple[ThresholdCosts, int] | None,
    least: FloatArray,
) -> BoundedSums:
    """The sum over the paths within the limits from the nodes ``roots`` of a source to each of the nodes ``listeners``.

    Args:
        operator: the walk operator of the graph.
        known: costs up to the threshold, and the source's row in them.
        least: (l, lanes) gains of known paths within the limits: no sum is less.
    """
    sums = sum_over_paths(graph, roots, listeners, limits, known, recrossings=operator.radius.well_posed)
    most = np.where(sums.error < LARGEST, sums.gain[:, 0] + sums.error, math.inf)
    gain = np.where((sums.error > 0)[:, None], np.maximum(sums.gain, least), sums.gain)
    error = np.maximum(most - gain[:, 0], 0.0)
    uncertain = error > limits.tolerance * gain[:, 0] * (1 + ROUNDING)
    has_limits = limits.threshold > 0 or limits.crossings < graph.contact_count
    limited = np.zeros(len(listeners), dtype=np.bool_)
    if has_limits or uncertain.any():
        totals = _totals(graph, operator, roots, listeners, limits.budget, sums)
        bound = np.full(len(listeners), math.inf) if totals is None else _above(totals, gain[:, 0])
        error = bound if has_limits else np.minimum(error, bound)
        limited = has_limits & (bound > limits.tolerance * gain[:, 0] * (1 + ROUNDING))
    return BoundedSums(gain, error, limited, uncertain, sums.paths, sums.work)


def _totals(
    graph: HapticGraph, operator: WalkOperator, roots: Sequence[int], listeners: Sequence[int], budget: int, sums: PathSums
) -> FloatArray | None:
    """Upper bounds (l,) on the sums without limits; None where nothing bounds them.

    In a forest the sums themselves are known in linear time. A Neumann series has as many terms as its longest chain has contacts.
    """
    if not operator.radius.well_posed:
        return None
    if not operator.has_cycles:
        free = sum_over_paths(graph, roots, listeners, PathLimits(math.inf, 0.0, 0.0, budget), None)
        return np.where(free.error < LARGEST, free.gain[:, 0] + free.error, math.inf)
    return operator.totals(roots, listeners, sums.recrossings)


def _above(totals: FloatArray, gain: FloatArray) -> FloatArray:
    """How far the totals exceed the gains: 0 where that is rounding, infinite where either overflows."""
    difference = np.where(totals - gain <= EXACT * totals, 0.0, totals - gain)
    return np.where((totals < LARGEST) & (gain < LARGEST), difference, math.inf)


def path_gain(graph: HapticGraph, path: tuple[int, ...], cost: float) -> FloatArray:
    """Gains (lanes,) of one path."""
    gain = np.full(lanes_of(graph), bounded_exp(-cost))
    gain[1:] *= PathConnections(graph, [path]).bands()[0, : len(gain) - 1]
    return gain
