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

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, IntArray, added_by
from ...frozen import frozen
from ..connections import LARGEST, ROUNDING
from .step_graph import StepGraph, walk_sums

SetArray = NDArray[np.uint64]

STEPS_PER_WORK, WORDS_PER_WORK = 4, 32
"""Steps that are examined, and 64-bit words of contact sets that are copied, in one unit of
work."""

BYTES = 1 << 28
"""Most bytes that the states may take."""

SPENT_ON_LEVEL, SPENT_PER_LEVEL = 0.5, 0.15
"""Parts of the remaining work and of the remaining error that one level may take, so that some is
left for the deeper ones."""

MISSED = 1e-11
"""Relative allowance for rounding in the bound on what is missing."""


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
    """The search over the paths from the roots of a step graph to its listeners.

    Args:
        paths: the step graph.
        crossings: most contacts on a path.
        threshold: least gain of a path. Without one, partial paths with the same continuations are
            merged.
        ahead: (e,) the largest gain from each entry to any listener, None where it is not known or
            some gain exceeds 1.
    """

    def __init__(
        self,
        paths: StepGraph,
        crossings: float,
        threshold: float = 0.0,
        ahead: FloatArray | None = None,
    ) -> None:
        self._paths = paths
        self._ahead = ahead
        contacts = int(paths.contact.max()) + 1
        self._crossings = int(min(crossings, contacts))
        self._least = threshold * (1 - ROUNDING)
        self._walks: tuple[FloatArray, FloatArray] | None = None
        self._bit: SetArray = np.where(
            paths.contact < 0, 0, 1 << (paths.contact & 63).astype(np.uint64)
        ).astype(np.uint64)
        self._word = np.maximum(paths.contact, 0) >> 6
        self._words = contacts // 64 + 1

    def run(self, tolerance: float, budget: int) -> PathSums:
        """The sums, to a relative ``tolerance``, or as many of the paths as the ``budget`` of
        partial paths and steps allows."""
        self._sums = np.zeros((self._paths.listeners, self._paths.ends.gain.shape[1]))
        self._missing = np.zeros(self._paths.listeners)
        room = min(max(1, budget // 4), BYTES // (8 * self._words + 64))
        roots = (self._paths.contact < 0).nonzero()[0]
        states = _States(
            roots,
            np.ones((len(roots), self._sums.shape[1])),
            np.zeros((len(roots), self._words), dtype=np.uint64),
        )
        counts = np.zeros(self._paths.listeners, dtype=np.int64)
        work, level = 0.0, 0
        while len(states.entry):
            affordable = SPENT_ON_LEVEL * (budget - work)
            states, cost = self._kept(states, level, room, affordable, tolerance)
            work += cost
            counts += self._end(states)
            if level == self._crossings:
                break
            states = self._advanced(states)
            if self._least == 0 and len(states.entry) > 1:
                states = _merged(states)
            if not np.all(states.value <= LARGEST):
                np.minimum(states.value, LARGEST, out=states.value)
                self._missing[:] = LARGEST
            level += 1
        missing = self._missing * (1 + MISSED)
        if (self._sums > LARGEST).any():
            missing[:] = LARGEST
        return PathSums(
            np.minimum(self._sums, LARGEST), np.minimum(missing, LARGEST), counts, int(work)
        )

    def _kept(
        self, states: _States, level: int, room: int, affordable: float, tolerance: float
    ) -> tuple[_States, float]:
        """The states that stay, and the work that they take. Those of least weight are dropped: as
        many as the ``tolerance`` allows at this ``level``, and all for which there is no ``room``
        or whose work is not ``affordable``."""
        cost = np.ones(len(states.entry))
        if level < self._crossings:
            steps = self._paths.steps.size[states.entry]
            cost += steps * (1 / STEPS_PER_WORK + self._words / WORDS_PER_WORK)
        if level == 0 or (tolerance == 0 and len(cost) <= room and float(cost.sum()) <= affordable):
            return states, float(cost.sum())
        if self._walks is None:
            self._walks = walk_sums(self._paths, self._crossings)
        bound, importance = self._walks
        total = self._sums[:, 0]
        value = states.value[:, :1]
        rest = np.minimum(value * bound[states.entry], LARGEST)
        with np.errstate(divide="ignore", over="ignore"):
            weight = (value * (importance * np.minimum(1 / total, LARGEST))[states.entry]).max(
                axis=1
            )
        order = np.argsort(weight, kind="stable")
        paid = int(cost[order[::-1]].cumsum().searchsorted(affordable, side="right"))
        cut = len(order) - min(room, paid)
        if tolerance > 0:
            tolerated = np.maximum(tolerance / (1 + tolerance) * total - self._missing, 0.0)
            lost = rest[order].cumsum(axis=0)
            share = SPENT_PER_LEVEL if (lost[-1] > tolerated).any() else 1.0
            cut = max(cut, int(np.searchsorted(~(lost <= share * tolerated).all(axis=1), True)))
        self._missing += rest[order[:cut]].sum(axis=0)
        np.minimum(self._missing, LARGEST, out=self._missing)
        kept = np.sort(order[cut:])
        return _States(states.entry[kept], states.value[kept], states.crossed[kept]), float(
            cost[kept].sum()
        )

    def _end(self, states: _States) -> IntArray:
        """Add the paths that end at a listener from the states to the sums; their numbers (l,)."""
        ends = self._paths.ends
        which, end = ends.expand(states.entry)
        if self._least > 0:
            kept = states.value[which, 0] * ends.gain[end, 0] >= self._least
            which = which[kept]
            end = end[kept]
        self._sums += added_by(
            ends.to[end], (states.value[which] * ends.gain[end]).T, len(self._sums)
        ).T
        return np.bincount(ends.to[end], minlength=len(self._sums))

    def _advanced(self, states: _States) -> _States:
        """The states one step further."""
        steps = self._paths.steps
        which, step = steps.expand(states.entry)
        to = steps.to[step]
        crossed = states.crossed.reshape(-1)
        possible = (crossed[which * self._words + self._word[to]] & self._bit[to]) == 0
        if self._least > 0:
            before = states.value[which, 0]
            gain = before * steps.gain[step, 0]
            if self._ahead is not None:
                possible &= gain * self._ahead[to] >= self._least
            else:  # gains may exceed 1: every beginning of a path must meet the threshold
                possible &= (gain >= self._least) & (before * steps.inside[step] >= self._least)
        which = which[possible]
        step = step[possible]
        to = to[possible]
        sets = states.crossed[which]
        sets.reshape(-1)[np.arange(0, sets.size, self._words) + self._word[to]] |= self._bit[to]
        return _States(to, states.value[which] * steps.gain[step], sets)


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
