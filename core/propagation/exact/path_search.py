"""Sums over paths by breadth-first search: all partial paths with the same number of contacts take their next step at once, as arrays.

Without a threshold, partial paths that have crossed the same contacts in different orders and stand at the same entry have the same
continuations: they are merged into one state, their gains added. (A ground with m arches has m! orders of its arches but only 2^m sets of
them.) With a threshold each partial path keeps its own gain, because each may or may not fall below the threshold later; those that cannot
reach it, even over the cheapest path to a listener, are dropped.

States of little weight may be dropped: the sum over all walks onwards (`walk_sums`) bounds the loss, so the result is an interval: the sum
found and a bound on the rest. The tolerance and the allowed number of states determine how many are dropped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import BoolArray, FloatArray, IntArray
from ..connections import LARGEST, ROUNDING
from .search_graph import Arcs, SearchGraph
from .walk_bounds import WalkBounds

KeyArray = NDArray[np.uint64]
BitArray = NDArray[np.uint8]

STEPS_PER_WORK = 4
"""Steps examined in the time of one unit of work."""

FEW = 1000
"""Up to this many steps or paths, plain loops and sums are faster, and precise enough."""

BINS, TABLE = 64, 1 << 20
"""Bins of the costs of steps, fewer where the table of counts would exceed this size."""

BYTES_PER_WORK = 256
"""Bytes of crossed contacts copied in the time of one unit of work."""

NUMBERED = 64
"""Largest number of contacts of a graph for which sets have a bit per contact of the graph; otherwise, per contact of the search."""

BYTES = 1 << 28
"""Most bytes that the states may take."""

SPENT_ON_LEVEL = 0.5
"""Part of the remaining work that one level may take, so that some is left for the deeper ones."""

SPENT_PER_LEVEL = 0.15
"""Part of the remaining error that one level may use: enough to thin out the states, with some left for the deeper levels."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a search.

    Attributes:
        crossings: most contacts on a path.
        threshold: least gain of a path.
        ahead: (e,) largest gain from each entry to a listener; infinite if it is unknown.
        tolerance: relative error allowed.
        known: (l,) lower bounds on the sums.
        states: most states held at a time.
        work: most work in all.
    """

    crossings: float
    threshold: float
    ahead: FloatArray
    tolerance: float
    known: FloatArray
    states: int
    work: int


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The result of a search.

    Attributes:
        sums: (k, l, lanes) over the paths with k contacts to each listener.
        missing: (l,) bound on the sum of all paths left out.
        paths: (l,) number of paths summed.
        work: work done.
        recrossed: (e,) values of the walks that were not continued because they cross a contact twice, by the entry where they end.
    """

    sums: FloatArray
    missing: FloatArray
    paths: IntArray
    work: int
    recrossed: FloatArray | None = None


class ArcRanking:
    """The steps of each entry, the most promising first: ranked by the cost of the step and of the strongest path onwards."""

    def __init__(self, steps: Arcs, cost: FloatArray) -> None:
        self.steps = steps
        self._cost = cost
        self._bins = max(1, min(BINS, TABLE // len(steps.size)))
        self._least = 0.0
        self._within = np.zeros(0, dtype=np.int64)

    @classmethod
    def of(cls, search_graph: SearchGraph, ahead: FloatArray) -> ArcRanking | None:
        """The ranking, or None if it does not pay off or the gains ahead are unknown."""
        steps = search_graph.steps
        if len(steps.to) <= FEW or not np.all(np.isfinite(ahead)):
            return None
        entry = np.arange(len(search_graph.nodes)).repeat(steps.size)
        with np.errstate(divide="ignore"):
            cost = np.minimum(-np.log(steps.gain * ahead[steps.to]), 800.0)
        order = np.argsort(entry * _SCALE + cost, kind="stable")
        ranked = steps.to[order], steps.inside[order], steps.gain[order], steps.weight.take(order, axis=0)
        return cls(Arcs(steps.start, steps.size, *ranked), cost[order])

    def promising(self, entry: IntArray, gain: FloatArray, least: float) -> IntArray:
        """How many of the ranked steps may still meet the threshold from each state, or a few more: the search checks exactly."""
        scale = self._bins / (1e-6 - math.log(least))
        if least != self._least:
            self._least, self._within = least, self._counted(scale)
        allowed = np.minimum((np.log(gain / least) + 1e-6) * scale, self._bins + 1).astype(np.int64)
        allowed += entry * (self._bins + 2)
        return np.asarray(self._within[allowed])

    def _counted(self, scale: float) -> IntArray:
        """Cumulative counts of steps by entry and bin of cost, the last bin for any cost."""
        count = len(self.steps.size)
        step = np.clip(self._cost * scale, 0, self._bins + 1).astype(np.int64)
        step += np.arange(count).repeat(self.steps.size) * (self._bins + 2)
        each = np.bincount(step, minlength=count * (self._bins + 2)).reshape(count, -1)
        return np.asarray(each.cumsum(axis=1).reshape(-1))


_SCALE = 1024.0
"""Larger than any cost of a gain that a float can hold, and a power of two."""


@dataclass(slots=True)
class _States:
    """Partial paths: the entry where each stands, its gain, its value (n, lanes) in lanes, the bit set of the contacts crossed
    (n, bytes), and the hash of that set where states are merged."""

    entry: IntArray
    gain: FloatArray
    value: FloatArray
    crossed: BitArray
    key: KeyArray

    def __len__(self) -> int:
        return len(self.entry)

    def pick(self, chosen: IntArray) -> _States:
        key = self.key[chosen] if len(self.key) == len(self.entry) else self.key
        crossed = self.crossed.take(chosen, axis=0)
        return _States(self.entry[chosen], self.gain[chosen], self.value.take(chosen, axis=0), crossed, key)


class PathSearch:
    """The sum over all paths from the roots of a search graph to its listeners, which `run` computes once.

    Args:
        search_graph: entries and steps.
        starts: (r, lanes) values of the roots.
        limits: which paths count, and how much work is allowed.
        bounds: computed only when something has to be dropped.
        merge: merge partial paths with the same continuations; only without a threshold.
        ranking: steps ranked by the same ``ahead`` as in the limits, which makes a search with a threshold faster where there are many.
        recrossings: collect the walks that are not continued because they cross a contact twice.
    """

    def __init__(
        self,
        search_graph: SearchGraph,
        starts: FloatArray,
        limits: Limits,
        bounds: WalkBounds,
        merge: bool,
        ranking: ArcRanking | None = None,
        recrossings: bool = False,
    ) -> None:
        self._graph, self._limits, self._bounds, self._ranking = search_graph, limits, bounds, ranking
        self._least = limits.threshold * (1 - ROUNDING)
        steps = self._steps = search_graph.steps if ranking is None else ranking.steps
        self._promise = limits.ahead[steps.to] if self._least == 0 else steps.gain * limits.ahead[steps.to]
        self._growing = bool(np.max(steps.gain, initial=0.0) > 1 or np.max(search_graph.ends.gain, initial=0.0) > 1)
        self._amplified = not np.all(np.isfinite(limits.ahead))
        self._keys = _keys(search_graph) if merge else None
        self._plain = not merge and search_graph.lanes == 1 and np.all(starts == 1) and np.array_equal(steps.weight[:, 0], steps.gain)
        self._sets = _ContactSets(search_graph.contact)
        self._each = 1 / STEPS_PER_WORK + self._sets.size / BYTES_PER_WORK
        self._room = min(limits.states, BYTES // (self._sets.size + 64))
        roots = np.arange(len(search_graph.nodes) - len(starts), len(search_graph.nodes))
        none = self._sets.none(len(roots)), np.zeros(len(roots), dtype=np.uint64)
        self._states = _States(roots, np.ones(len(roots)), starts, *none)
        self._standing: list[_States] = []
        self._ended: list[tuple[IntArray, FloatArray]] = []
        self._missing = np.zeros(search_graph.listeners)
        self._total = np.zeros(search_graph.listeners)
        self._recrossed = np.zeros(len(search_graph.nodes)) if recrossings else None
        self._work = 0

    def run(self) -> SearchResult:
        """Search level by level; a level has the partial paths with one number of contacts."""
        level = levels = 0
        while len(self._states):
            sizes = self._chosen_steps(level)
            self._standing.append(self._states)
            levels = level + 1
            self._end_paths(level)
            if level >= self._limits.crossings:
                break
            self._advance(level, sizes)
            level += 1
        if self._standing:
            self._ended.append(_end(self._graph, self._standing, levels, self._least))
        sums, paths = _add_up(self._ended, levels, self._graph)
        if self._growing:
            self._missing[(sums[..., 0].sum(axis=0) > LARGEST) | (np.max(self._steps.gain, initial=0.0) > LARGEST)] = LARGEST
            np.minimum(sums, LARGEST, out=sums)
        return SearchResult(sums, self._missing, paths, self._work, self._recrossed)

    def _chosen_steps(self, level: int) -> IntArray:
        """How many steps each state takes, after states that are too many or of too little weight are dropped."""
        limits, states = self._limits, self._states
        sizes = self._steps.size[states.entry]
        if self._ranking is not None:
            sizes = self._ranking.promising(states.entry, states.gain, self._least)
        allowed = SPENT_ON_LEVEL * (limits.work - self._work) if level else math.inf
        needed = len(states) + float(sizes.sum()) * self._each
        if level and (limits.tolerance > 0 or len(states) > self._room or needed > allowed):
            kept = self._kept(level, 1.0 + sizes.astype(np.float64) * self._each, allowed)
            self._states, sizes = states.pick(kept), sizes[kept]
            needed = len(kept) + float(sizes.sum()) * self._each
        self._work += int(needed)
        return sizes

    def _kept(self, level: int, cost: FloatArray, allowed: float) -> IntArray:
        """Numbers of the states that stay. Those of least weight are dropped: as many as the tolerance allows at this level, and all for
        which there is no room or no work ``allowed`` (each state takes its ``cost``). What they might have added counts as missing."""
        limits, bounds, states, missing = self._limits, self._bounds, self._states, self._missing
        total = np.maximum(self._total, limits.known)
        value = states.value[:, :1]
        left = np.minimum(value * bounds.sums(level)[states.entry], LARGEST)
        with np.errstate(divide="ignore", over="ignore"):
            score = (value * (bounds.importance(level) * np.minimum(1 / total, LARGEST))[states.entry]).max(axis=1)
        order = np.argsort(score, kind="stable")
        affordable = int(np.searchsorted(np.cumsum(cost[order[::-1]]), allowed, side="right"))
        cut = len(states) - min(self._room, affordable)
        if limits.tolerance > 0:
            tolerated = np.maximum(limits.tolerance / (1 + limits.tolerance) * total - missing, 0.0)
            lost = np.cumsum(left[order], axis=0)
            if (lost[-1] <= tolerated).all():
                cut = len(states)
            else:
                cut = max(cut, int(np.searchsorted(~(lost <= SPENT_PER_LEVEL * tolerated).all(axis=1), True)))
        missing += left[order[:cut]].sum(axis=0)
        np.minimum(missing, LARGEST, out=missing)
        return np.sort(order[cut:])

    def _end_paths(self, level: int) -> None:
        """End paths at the listeners: of many states at once, and of each level where the sum so far decides what is dropped."""
        tolerant = self._limits.tolerance > 0
        if tolerant or sum(map(len, self._standing)) > FEW:
            self._ended.append(_end(self._graph, self._standing, level + 1, self._least))
            self._standing = []
        if tolerant:
            cell, value = self._ended[-1]
            listeners = self._graph.listeners
            self._total += np.bincount(cell - level * listeners, weights=value[:, 0], minlength=listeners)

    def _advance(self, level: int, sizes: IntArray) -> None:
        """Take the states one step further."""
        states, steps, least = self._states, self._steps, self._least
        which, step = steps.expand(states.entry, sizes)
        possible = self._promise[step] > 0 if least == 0 else states.gain[which] * self._promise[step] >= least
        if self._amplified and least > 0:  # else the gain of the whole path decides
            inside, gain = states.gain[which] * steps.inside[step], states.gain[which] * steps.gain[step]
            possible &= (gain >= least) & (inside >= least)
        to = steps.to[step]
        if level:
            new = self._sets.missing(states.crossed, which, to)
            if self._recrossed is not None:
                self._collect(states, which, step, possible & ~new)
            possible &= new
        kept = possible.nonzero()[0]
        which, step, to = which[kept], step[kept], to[kept]
        gain = states.gain[which] * steps.gain[step]
        self._states = _States(
            to,
            gain,
            gain[:, None] if self._plain else states.value.take(which, axis=0) * steps.weight.take(step, axis=0),
            self._sets.added(states.crossed, which, to),
            states.key if self._keys is None else states.key[which] + self._keys[0][to],
        )
        if self._keys is not None:
            self._states = _merge(self._states, self._keys[1])
        if self._growing and not np.all(self._states.value <= LARGEST):
            np.minimum(self._states.value, LARGEST, out=self._states.value)
            np.minimum(self._states.gain, LARGEST, out=self._states.gain)
            self._missing[:] = LARGEST

    def _collect(self, states: _States, which: IntArray, step: IntArray, crossed: BoolArray) -> None:
        """Add the values of walks that cross a contact twice to the entries where they end; back through the same contact is no walk."""
        assert self._recrossed is not None
        again = crossed.nonzero()[0]
        to, begin = self._steps.to[step[again]], states.entry[which[again]]
        other = (self._graph.contact[to] != self._graph.contact[begin]).nonzero()[0]
        again, to = again[other], to[other]
        values = states.value[which[again], 0] * self._steps.weight[step[again], 0]
        self._recrossed += np.bincount(to, weights=values, minlength=len(self._recrossed))


class _ContactSets:
    """Bit sets of contacts, a row of bytes each."""

    def __init__(self, contact: IntArray) -> None:
        which, count = contact, int(contact.max()) + 1
        if count > NUMBERED:
            numbers, which = np.unique(contact, return_inverse=True)
            none = int(numbers[0] == -1)
            which, count = which - none, len(numbers) - none
        self.size = count // 8 + 1
        """Bytes per set."""
        self._bit = np.where(contact == -1, 0, 1 << (which & 7)).astype(np.uint8)
        self._place = np.maximum(which, 0) >> 3

    def none(self, count: int) -> BitArray:
        """``count`` empty sets."""
        return np.zeros((count, self.size), dtype=np.uint8)

    def missing(self, crossed: BitArray, which: IntArray, entry: IntArray) -> BoolArray:
        """Whether the contact that leads into ``entry[k]`` is missing from the set ``crossed[which[k]]``."""
        return np.asarray((crossed.reshape(-1)[which * self.size + self._place[entry]] & self._bit[entry]) == 0)

    def added(self, crossed: BitArray, which: IntArray, entry: IntArray) -> BitArray:
        """Sets with the contacts that lead into the entries added."""
        sets = crossed.take(which, axis=0)
        sets.reshape(-1)[np.arange(0, sets.size, self.size) + self._place[entry]] |= self._bit[entry]
        return sets


def _keys(search_graph: SearchGraph) -> tuple[KeyArray, KeyArray]:
    """Random keys of the contacts that lead into the entries, and of the entries. A set is hashed by the sum of its keys, and compared in
    full before states are merged."""
    generator = np.random.default_rng(0)
    count = len(search_graph.contact)
    _, contact = np.unique(search_graph.contact, return_inverse=True)
    of_contacts: KeyArray = generator.integers(0, 1 << 63, count, dtype=np.uint64)
    of_entries: KeyArray = generator.integers(0, 1 << 63, count, dtype=np.uint64)
    return of_contacts[contact], of_entries


def _end(search_graph: SearchGraph, standing: list[_States], levels: int, least: float) -> tuple[IntArray, FloatArray]:
    """The paths that end at a listener from the states of the last levels: their cells ``level * listeners + listener``, and their values
    (n, lanes)."""
    entry = np.concatenate([states.entry for states in standing])
    gain = np.concatenate([states.gain for states in standing])
    value = np.concatenate([states.value for states in standing])
    cell = (np.arange(levels - len(standing), levels) * search_graph.listeners).repeat([len(states) for states in standing])
    which, end = search_graph.ends.expand(entry)
    if least > 0:
        kept = (gain[which] * search_graph.ends.gain[end] >= least).nonzero()[0]
        which, end = which[kept], end[kept]
    return cell[which] + search_graph.ends.to[end], value.take(which, axis=0) * search_graph.ends.weight.take(end, axis=0)


def _add_up(ended: list[tuple[IntArray, FloatArray]], levels: int, search_graph: SearchGraph) -> tuple[FloatArray, IntArray]:
    """Sums (k, l, lanes) and numbers (l,) of paths by contacts crossed. Many terms are added pairwise, so that small ones are not lost."""
    cells = levels * search_graph.listeners
    cell = np.concatenate([cell for cell, _ in ended])
    values = np.concatenate([values for _, values in ended])
    numbers = np.bincount(cell, minlength=cells)
    sums = np.zeros((cells, search_graph.lanes))
    if len(cell) <= FEW:
        for lane in range(search_graph.lanes):
            sums[:, lane] = np.bincount(cell, weights=values[:, lane], minlength=cells)
    else:
        ordered = values.take(np.argsort(cell, kind="stable"), axis=0)
        last = 0
        for place in np.flatnonzero(numbers).tolist():
            first, last = last, last + int(numbers[place])
            sums[place] = np.ascontiguousarray(ordered[first:last].T).sum(axis=1)
    return sums.reshape(levels, search_graph.listeners, search_graph.lanes), numbers.reshape(levels, -1).sum(axis=0)


def _merge(states: _States, entry_key: KeyArray) -> _States:
    """The states with those merged that stand at the same entry and have crossed the same contacts."""
    if len(states) < 2:
        return states
    key = states.key ^ entry_key[states.entry]
    order = np.argsort(key, kind="stable")
    same = key[order[1:]] == key[order[:-1]]
    if not same.any():
        return states
    pairs = np.flatnonzero(same)
    a, b = order[pairs], order[pairs + 1]
    really = (states.entry[a] == states.entry[b]) & (states.crossed[a] == states.crossed[b]).all(axis=1)
    first = np.ones(len(order), dtype=np.bool_)
    first[pairs[really] + 1] = False
    begin = np.flatnonzero(first)
    merged = states.pick(order[begin])
    merged.value = np.add.reduceat(states.value.take(order, axis=0), begin, axis=0)
    return merged
