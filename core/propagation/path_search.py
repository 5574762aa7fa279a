"""Sums over paths by search: all partial paths with the same number of contacts are taken one step further at once, as arrays.

Without a threshold, partial paths that have crossed the same patches in different orders and stand at the same entry are one state from
there on: they are merged, their gains added. (A ground with m arches has m! orders of its arches but only 2^m sets of them.) With a
threshold each keeps its own gain, because each may or may not fall below it further on; what can't meet it any more, even on the cheapest
way to a listener, is not followed.

States of little weight may be dropped: the sum over all walks onwards (`walk_sums`) bounds what is lost, so the result is an interval, the
sum of what was found and a bound of the rest. How much is dropped follows from the tolerance wanted and from the number of states allowed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arena import Arena, Rows
from .connections import ROUNDING

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
KeyArray = NDArray[np.uint64]

PAIRS = 4
"""So many steps are looked at as quickly as one unit of work elsewhere is done."""

SPENT_PER_LEVEL = 0.15
"""Part of the error still allowed that one level may use: enough to thin the states out, and something is left for the deeper ones."""


@dataclass(frozen=True, slots=True)
class Limits:
    """``crossings`` contacts on a path at most; ``threshold`` of its gain; ``ahead`` (e,) the largest gain from each entry to a listener
    (infinite where it is not known). ``tolerance`` relative error allowed; ``known`` (l,) lower bounds of the sums; ``states`` kept at most
    at a time, and ``work`` allowed altogether."""

    crossings: float
    threshold: float
    ahead: FloatArray
    tolerance: float
    known: FloatArray
    states: int
    work: int


@dataclass(frozen=True, slots=True)
class Found:
    """``sums`` (k, l, lanes) over the paths with k contacts; ``missing`` (l,) a bound of all paths not in them; ``paths`` (l,) their
    number; ``work`` that was done."""

    sums: FloatArray
    missing: FloatArray
    paths: IntArray
    work: int


@dataclass(slots=True)
class _States:
    """Partial paths: the entry where each stands, its ``gain``, its ``value`` (n, lanes) with shares and bands, the patches crossed."""

    entry: IntArray
    gain: FloatArray
    value: FloatArray
    crossed: NDArray[np.int32]
    key: KeyArray

    def __len__(self) -> int:
        return len(self.entry)

    def pick(self, chosen: IntArray) -> _States:
        return _States(self.entry[chosen], self.gain[chosen], self.value[chosen], self.crossed[chosen], self.key[chosen])


def search(arena: Arena, starts: FloatArray, limits: Limits, onwards: Callable[[], FloatArray], merge: bool) -> Found:
    """Sum over all paths from the arena's roots, which have the values ``starts`` (r, lanes), to its listeners.

    ``onwards`` gives `walk_sums`, and is called only when something has to be dropped. ``merge`` only without a threshold.
    """
    count = len(arena.nodes)
    roots = np.arange(count - len(starts), count)
    generator = np.random.default_rng(0)  # keys of patches: equal sets are found by their sums, and compared before they are merged
    patch_key = generator.integers(0, 1 << 63, count, dtype=np.uint64)
    entry_key = generator.integers(0, 1 << 63, count, dtype=np.uint64)
    entering = np.unique(arena.patch, return_inverse=True)[1]
    least = limits.threshold * (1 - ROUNDING)
    ranked = _rank(arena, limits) if least > 0 and np.all(np.isfinite(limits.ahead)) else None
    steps = arena.steps if ranked is None else ranked[0]
    useful = limits.ahead > 0
    states = _States(roots, np.ones(len(roots)), starts, np.empty((len(roots), 0), dtype=np.int32), np.zeros(len(roots), dtype=np.uint64))
    sums: list[FloatArray] = []
    missing = np.zeros(arena.listeners)
    paths = np.zeros(arena.listeners, dtype=np.int64)
    work = 0
    level = 0
    while len(states):
        work += len(states)
        found, number = _finish(arena, states, least)
        sums.append(found)
        paths += number
        if level >= limits.crossings:
            break
        which, step = steps.expand(states.entry, None if ranked is None else _promising(steps, ranked[1], states, least))
        work += len(step) // PAIRS
        to = steps.to[step]
        gain = states.gain[which] * steps.gain[step]
        possible = useful[to]
        if least > 0:
            possible &= (gain * limits.ahead[to] >= least) & (gain >= least) & (states.gain[which] * steps.inside[step] >= least)
        kept = np.flatnonzero(possible)
        kept = kept[~(states.crossed[which[kept]] == entering[to[kept], None]).any(axis=1)]
        which, step, to, gain = which[kept], step[kept], to[kept], gain[kept]
        states = _States(
            to,
            gain,
            states.value[which] * steps.weight[step],
            np.concatenate([states.crossed[which], entering[to, None].astype(np.int32)], axis=1),
            states.key[which] + patch_key[entering[to]],
        )
        if merge:
            states = _merge(states, entry_key)
        level += 1
        total = np.sum(sums, axis=0)[:, 0]
        states = _drop(arena, states, limits, onwards, level, np.maximum(total, limits.known), missing, work)
    return Found(np.array(sums).reshape(-1, arena.listeners, arena.lanes), missing, paths, work)


def _finish(arena: Arena, states: _States, least: float) -> tuple[FloatArray, IntArray]:
    """Sums (l, lanes) and numbers (l,) of the paths that end at a listener now. Added pairwise, so that small terms are not lost."""
    which, end = arena.ends.expand(states.entry)
    sums = np.zeros((arena.listeners, arena.lanes))
    if least > 0:
        kept = np.flatnonzero(states.gain[which] * arena.ends.gain[end] >= least)
        which, end = which[kept], end[kept]
    to = arena.ends.to[end]
    order = np.argsort(to, kind="stable")
    numbers = np.bincount(to, minlength=arena.listeners)
    values = states.value[which[order]] * arena.ends.weight[end[order]]
    last = 0
    for listener, number in enumerate(numbers.tolist()):
        if number:
            sums[listener] = np.ascontiguousarray(values[last : last + number].T).sum(axis=1)
            last += number
    return sums, numbers


def _rank(arena: Arena, limits: Limits) -> tuple[Rows, FloatArray]:
    """Steps of each entry with the most promising first, and keys ``entry * scale + cost`` that are sorted over all of them."""
    steps = arena.steps
    entry = np.repeat(np.arange(len(arena.nodes)), np.diff(steps.start))
    with np.errstate(divide="ignore"):
        cost = -np.log(steps.gain * limits.ahead[steps.to])
    cost = np.minimum(cost, 800.0)
    order = np.lexsort((cost, entry))
    ranked = Rows(steps.start, steps.to[order], steps.inside[order], steps.gain[order], steps.weight[order])
    return ranked, np.asarray(entry[order] * _SCALE + cost[order], dtype=np.float64)


_SCALE = 1024.0
"""Larger than any cost of a gain that a float can hold, and a power of two."""


def _promising(steps: Rows, keys: FloatArray, states: _States, least: float) -> IntArray:
    """How many of the ranked steps of each state may still meet the threshold (a little more than that: it is checked again exactly)."""
    allowed = np.minimum(np.log(states.gain / least) + 1e-6, 900.0)
    number = np.searchsorted(keys, states.entry * _SCALE + allowed, side="right") - steps.start[states.entry]
    return np.asarray(np.maximum(number, 0), dtype=np.int64)


def _merge(states: _States, entry_key: KeyArray) -> _States:
    """One state for all that stand at the same entry with the same patches crossed."""
    if len(states) < 2:
        return states
    key = states.key ^ entry_key[states.entry]
    order = np.argsort(key, kind="stable")
    same = key[order[1:]] == key[order[:-1]]
    if not same.any():
        return states
    pairs = np.flatnonzero(same)
    a, b = order[pairs], order[pairs + 1]
    really = (states.entry[a] == states.entry[b]) & (np.sort(states.crossed[a], axis=1) == np.sort(states.crossed[b], axis=1)).all(axis=1)
    first = np.ones(len(order), dtype=np.bool_)
    first[pairs[really] + 1] = False
    begin = np.flatnonzero(first)
    merged = states.pick(order[begin])
    merged.value = np.add.reduceat(states.value[order], begin, axis=0)
    return merged


def _drop(
    arena: Arena,
    states: _States,
    limits: Limits,
    onwards: Callable[[], FloatArray],
    level: int,
    total: FloatArray,
    missing: FloatArray,
    work: int,
) -> _States:
    """Leave out the states of least weight: as many as the tolerance allows at this level, and all above the number allowed. What they
    might have added goes to ``missing``."""
    each = 1 + len(arena.steps.to) / (PAIRS * len(arena.nodes))
    most = max(0, min(limits.states, int((limits.work - work) / each)))
    if len(states) == 0 or (limits.tolerance == 0 and len(states) <= most):
        return states
    sums = onwards()
    left = int(min(limits.crossings, arena.patches)) - level  # a path crosses each patch once
    bounds = states.value[:, :1] * sums[min(left, len(sums) - 1)][states.entry]
    with np.errstate(divide="ignore", invalid="ignore"):
        score = np.nan_to_num(bounds / total, nan=0.0, posinf=math.inf).max(axis=1)
    order = np.lexsort((np.arange(len(states)), score))
    cut = max(0, len(states) - most)
    if limits.tolerance > 0:
        allowed = np.maximum(limits.tolerance / (1 + limits.tolerance) * total - missing, 0.0)
        lost = np.cumsum(bounds[order], axis=0)
        if (lost[-1] <= allowed).all():
            cut = len(states)
        else:
            cut = max(cut, int(np.searchsorted(~(lost <= SPENT_PER_LEVEL * allowed).all(axis=1), True)))
    missing += bounds[order[:cut]].sum(axis=0)
    return states.pick(np.sort(order[cut:]))
