"""Sums over paths by breadth-first search: all partial paths with the same number of contacts take
their next step at once, as arrays.

Without a threshold, partial paths that have crossed the same contacts in different orders and stand
at the same entry have the same continuations: they are merged into one state, their gains added. (A
ground with m arches has m! orders of its arches but only 2^m sets of them.) With a threshold each
partial path keeps its own gain, because each may or may not fall below the threshold later; those
that cannot reach it, even over the cheapest path to a listener, are dropped.

States of little weight may be dropped: the sum over all walks onwards bounds the loss, so the
result is an interval.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, IntArray
from ...frozen import frozen
from ..connections import LARGEST, ROUNDING
from .step_graph import StepGraph, walk_bounds

SetArray = NDArray[np.uint64]

STEPS_PER_WORK, WORDS_PER_WORK = 4, 32
"""Steps that are examined, and 64-bit words of contact sets that are copied, in one unit of
work."""

MANY = 1000
"""Number of steps above which they are sorted by what they can still contribute."""

BYTES = 1 << 28
"""Most bytes that the states may take."""

SPENT_ON_LEVEL, SPENT_PER_LEVEL = 0.5, 0.15
"""Parts of the remaining work and of the remaining error that one level may take, so that some is
left for the deeper ones."""

MISSED = 1e-11
"""Relative allowance for rounding in the bound on what is missing."""

MOST, SCALE = 800.0, 1024.0
"""A cost larger than ``-log`` of the least positive float, and a power of two above that, which
keeps the sorting keys of different entries apart."""


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
class PathSums:
    """Sums (l, lanes) of the ``gain`` over paths to each listener: the plain gain, then that of
    each band. ``missing`` (l,): a bound on the plain gain of all others, `LARGEST` without one.
    ``paths`` (l,): their number, -1 if they were not counted. ``work`` done."""

    gain: FloatArray
    missing: FloatArray
    paths: IntArray
    work: int

    def known_to(self, tolerance: float) -> bool:
        """Whether what is missing is at most this part of the sums."""
        return bool(np.all(self.missing <= tolerance * self.gain[:, 0]))


@dataclass(slots=True)
class _States:
    """Partial paths: the ``entry`` where each stands, its ``value`` (n, lanes), and the set of
    contacts ``crossed`` (n, words), as bits."""

    entry: IntArray
    value: FloatArray
    crossed: SetArray


class PathSearch:
    """Searches over the paths from the roots of a step graph to its listeners. ``ahead`` (e,): the
    largest gain from each entry to any listener, where it is known and no gain exceeds 1."""

    def __init__(self, paths: StepGraph, crossings: float, ahead: FloatArray | None = None) -> None:
        self._ahead = ahead
        contacts = int(paths.contact.max()) + 1
        self._crossings = int(min(crossings, contacts))
        self._bounds: tuple[FloatArray, FloatArray] | None = None
        self._ranked = ahead is not None and len(paths.steps.to) > MANY
        if ahead is not None and self._ranked:  # the most promising steps first
            steps = paths.steps
            with np.errstate(divide="ignore"):
                cost = np.minimum(-np.log(steps.gain[:, 0] * ahead[steps.to]), MOST)
            cost += np.arange(len(paths.nodes)).repeat(steps.size) * SCALE
            order = np.argsort(cost, kind="stable")
            steps = replace(
                steps, to=steps.to[order], inside=steps.inside[order], gain=steps.gain[order]
            )
            paths = replace(paths, steps=steps)
            self._cost = cost[order]
        self._paths = paths
        self._bit: SetArray = np.where(
            paths.contact < 0, 0, 1 << (paths.contact & 63).astype(np.uint64)
        ).astype(np.uint64)
        self._word = np.maximum(paths.contact, 0) >> 6
        self._words = contacts // 64 + 1

    def run(self, limits: PathLimits, known: FloatArray) -> PathSums:
        """The sums. ``known`` (l,): lower bounds on them. Without a threshold, partial paths with
        the same continuations are merged."""
        paths = self._paths
        least = limits.threshold * (1 - ROUNDING)
        roots = (paths.contact < 0).nonzero()[0]
        lanes = paths.ends.gain.shape[1]
        states = _States(
            roots,
            np.ones((len(roots), lanes)),
            np.zeros((len(roots), self._words), dtype=np.uint64),
        )
        sums = np.zeros((paths.listeners, lanes))
        missing = np.zeros(paths.listeners)
        counts = np.zeros(paths.listeners, dtype=np.int64)
        work, level = 0.0, 0
        while len(states.entry):
            sizes = (
                self._sizes(states, least)
                if level < limits.crossings
                else np.zeros(len(states.entry), dtype=np.int64)
            )
            cost = np.asarray(
                1.0 + sizes * (1 / STEPS_PER_WORK + self._words / WORDS_PER_WORK), dtype=np.float64
            )
            allowed = SPENT_ON_LEVEL * (limits.budget - work)
            room = min(max(1, limits.budget // 4), BYTES // (8 * self._words + 64))
            if level and (limits.tolerance > 0 or len(cost) > room or cost.sum() > allowed):
                kept = self._kept(
                    states,
                    cost,
                    (room, allowed),
                    limits.tolerance,
                    np.maximum(sums[:, 0], known),
                    missing,
                )
                states = _States(states.entry[kept], states.value[kept], states.crossed[kept])
                sizes = sizes[kept]
                cost = cost[kept]
            work += float(cost.sum())
            counts += self._end(states, least, sums)
            if level >= limits.crossings:
                break
            states = self._advanced(states, sizes, least)
            if not limits.threshold and len(states.entry) > 1:
                states = _merged(states)
            if not np.all(states.value <= LARGEST):
                np.minimum(states.value, LARGEST, out=states.value)
                missing[:] = LARGEST
            level += 1
        missing = np.where(
            (sums > LARGEST).any(), LARGEST, np.minimum(missing * (1 + MISSED), LARGEST)
        )
        return PathSums(np.minimum(sums, LARGEST), missing, counts, int(work))

    def _sizes(self, states: _States, least: float) -> IntArray:
        """How many steps each state takes: all, or those of the ranked ones that may still meet the
        threshold."""
        if not self._ranked or least == 0:
            return self._paths.steps.size[states.entry]
        allowed = np.minimum(np.log(states.value[:, 0] / least) + 1e-6, MOST)
        return (
            self._cost.searchsorted(states.entry * SCALE + allowed, side="right")
            - self._paths.steps.start[states.entry]
        )

    def _kept(
        self,
        states: _States,
        cost: FloatArray,
        affordable: tuple[int, float],
        tolerance: float,
        total: FloatArray,
        missing: FloatArray,
    ) -> IntArray:
        """Numbers of the states that stay. Those of least weight are dropped: as many as the
        tolerance allows at this level, and all that are not affordable.

        Args:
            states: all of them.
            cost: work that each takes (n,).
            affordable: most states, and most work.
            tolerance: relative error allowed.
            total: lower bounds on the sums (l,).
            missing: bound on what is left out (l,), to which the dropped states are added.
        """
        if self._bounds is None:
            self._bounds = walk_bounds(self._paths, self._crossings)
        bound, importance = self._bounds
        value = states.value[:, :1]
        left = np.minimum(value * bound[states.entry], LARGEST)
        with np.errstate(divide="ignore", over="ignore"):
            score = (value * (importance * np.minimum(1 / total, LARGEST))[states.entry]).max(
                axis=1
            )
        order = np.argsort(score, kind="stable")
        cut = len(order) - min(
            affordable[0], int(cost[order[::-1]].cumsum().searchsorted(affordable[1], side="right"))
        )
        if tolerance > 0:
            tolerated = np.maximum(tolerance / (1 + tolerance) * total - missing, 0.0)
            lost = left[order].cumsum(axis=0)
            share = SPENT_PER_LEVEL if (lost[-1] > tolerated).any() else 1.0
            cut = max(cut, int(np.searchsorted(~(lost <= share * tolerated).all(axis=1), True)))
        missing += left[order[:cut]].sum(axis=0)
        np.minimum(missing, LARGEST, out=missing)
        return np.sort(order[cut:])

    def _end(self, states: _States, least: float, sums: FloatArray) -> IntArray:
        """Add the paths that end at a listener from the states to the ``sums``; their numbers
        (l,)."""
        ends = self._paths.ends
        which, end = ends.expand(states.entry, ends.size[states.entry])
        if least > 0:
            kept = (states.value[:, 0][which] * ends.gain[:, 0][end] >= least).nonzero()[0]
            which = which[kept]
            end = end[kept]
        for lane in range(sums.shape[1]):
            sums[:, lane] += np.bincount(
                ends.to[end], states.value[:, lane][which] * ends.gain[:, lane][end], len(sums)
            )
        return np.bincount(ends.to[end], minlength=len(sums))

    def _advanced(self, states: _States, sizes: IntArray, least: float) -> _States:
        """The states one step further."""
        steps = self._paths.steps
        which, step = steps.expand(states.entry, sizes)
        to = steps.to[step]
        crossed = states.crossed.reshape(-1)
        possible = (crossed[which * self._words + self._word[to]] & self._bit[to]) == 0
        if least > 0:
            gain = states.value[:, 0][which] * steps.gain[:, 0][step]
            if self._ahead is not None:
                possible &= gain * self._ahead[to] >= least
            else:  # gains may exceed 1: every beginning of a path must meet the threshold
                possible &= (gain >= least) & (
                    states.value[:, 0][which] * steps.inside[step] >= least
                )
        kept = possible.nonzero()[0]
        which = which[kept]
        step = step[kept]
        to = to[kept]
        sets = states.crossed.take(which, axis=0)
        sets.reshape(-1)[np.arange(0, sets.size, self._words) + self._word[to]] |= self._bit[to]
        return _States(to, states.value.take(which, axis=0) * steps.gain.take(step, axis=0), sets)


def _merged(states: _States) -> _States:
    """The states with those added up that stand at the same entry and have crossed the same
    contacts."""
    order = np.lexsort((*states.crossed.T, states.entry))
    entry = states.entry[order]
    crossed = states.crossed[order]
    first = np.append(True, (entry[1:] != entry[:-1]) | (crossed[1:] != crossed[:-1]).any(axis=1))
    begin = first.nonzero()[0]
    return _States(
        entry[begin], np.add.reduceat(states.value[order], begin, axis=0), crossed[begin]
    )
