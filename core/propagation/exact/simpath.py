"""The sum over all paths of a component by a dynamic programme over its patches (Simpath): exact, in a time that grows with the width.

The patches are taken one after the other, each crossed or not. What is crossed so far is a set of path fragments; only their open ends
matter for what can still follow, so sets of fragments with the same open ends are one *state*, and its value is the sum of the products of
all of them. An open end waits at a contact node of an object until a later contact of that object, or a listener, is joined to it by their
intra-connection. A state says which ends wait and which of them belong together; one of them is the fragment that begins at the source,
and one may be the fragment that ends at a listener. A path is complete when these two meet and nothing else is open.

Source: D. E. Knuth, *The Art of Computer Programming*, volume 4A, section 7.1.4, algorithm Simpath, here with weights instead of counts,
and with the open ends of an object (which a path may pass several times) instead of vertices (which it may not).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray, runs

BITS = 7
FIELD = (1 << BITS) - 1
SOURCE, LISTENER, FIRST = 1, 2, 3
"""A state is an integer with a field per slot: 0 if no end waits there, `SOURCE` or `LISTENER` for the end of that fragment, else the slot
of the fragment's other end, counted from `FIRST`."""

SLOTS = FIELD - FIRST + 1

SHIFT = tuple(BITS * (mate - FIRST) for mate in range(FIELD + 1))
WITHOUT = tuple(-1 if mate < FIRST else ~(FIELD << SHIFT[mate]) for mate in range(FIELD + 1))
"""By the other end of a fragment: shift of its slot, and mask without it."""

WIDEST = 48
"""With more objects than this at once in the frontier, no order is narrow."""

HOPELESS = 0.05
"""From this part of the work allowed on, it is given up where the rest is expected to take more than twice as much as allowed."""

ELEMENTS = 16
"""Adding up so many numbers takes as long as finding one transition."""


class TooWide(Exception):
    """More ends may wait than a state has room for."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """One contact, in the order in which they are taken.

    ``nodes`` on either side; ``patch`` its number in the order, ``first`` whether it is the first of it (a path takes one contact of a
    patch or none); ``waiting`` nodes that may wait on either side, with their slots; ``slots`` of its own; ``waits`` whether either side
    may wait for a patch still to come; ``most``, after the last contact of a patch: of these slots only so many may still hold a waiting
    end, because no more patches are to come for them.
    """

    nodes: tuple[int, int]
    patch: int
    first: bool
    waiting: tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]
    slots: tuple[int, int]
    waits: tuple[bool, bool]
    most: tuple[tuple[tuple[int, ...], int], ...]


@dataclass(frozen=True, slots=True)
class Weights:
    """Factors of one crossing in lanes (the plain gain, and each band), that of the contact included.

    ``joins`` (side a's joins and no join, side b's, lanes); ``alone`` the same of each side by itself; ``ends`` (listeners, lanes) of
    ending at the listeners from either node, None where there are none in its object.
    """

    joins: FloatArray
    alone: tuple[FloatArray, FloatArray]
    ends: tuple[FloatArray | None, FloatArray | None]


def plan(patches: Sequence[Sequence[tuple[int, int, int, int]]], start: tuple[int, int]) -> list[Crossing]:
    """The crossings of patches, given by their contacts as (object, node, object, node), in this order. ``start``: the object and node that
    all paths come from, which waits at slot 0. Raises TooWide where more ends could wait than there are slots."""
    left: dict[int, int] = {}
    for contacts in patches:
        for index in {k for one, _, other, _ in contacts for k in (one, other)}:
            left[index] = left.get(index, 0) + 1
    free = list(range(SLOTS - 1, 0, -1))
    waiting: dict[int, list[tuple[int, int]]] = {start[0]: [(start[1], 0)]}
    crossings: list[Crossing] = []
    for patch, contacts in enumerate(patches):
        touched = sorted({k for one, _, other, _ in contacts for k in (one, other)})
        for index in touched:
            left[index] -= 1
        if len(free) < 2 * len(contacts):
            raise TooWide
        slots = [(free.pop(), free.pop()) for _ in contacts]
        sides = [(tuple(waiting.get(one, ())), tuple(waiting.get(other, ()))) for one, _, other, _ in contacts]
        for (one, a, other, b), (slot_a, slot_b) in zip(contacts, slots, strict=True):
            waiting.setdefault(one, []).append((a, slot_a))
            waiting.setdefault(other, []).append((b, slot_b))
        most = tuple((tuple(slot for _, slot in waiting[index]), left[index]) for index in touched if len(waiting[index]) > left[index])
        for number, (one, a, other, b) in enumerate(contacts):
            waits = left[one] > 0, left[other] > 0
            last = number + 1 == len(contacts)
            crossings.append(Crossing((a, b), patch, number == 0, sides[number], slots[number], waits, most if last else ()))
        for index in touched:
            if left[index] == 0:
                free += [slot for _, slot in waiting.pop(index)]
    return crossings


Neighbours = Mapping[int, Sequence[tuple[int, int]]]
"""Of each object: the number of every patch at it, and the object on its other side."""


def order_patches(patches: Sequence[tuple[int, int]], places: Mapping[int, Sequence[float]], first: int) -> tuple[list[int], list[float]]:
    """An order of the edges (object, object) that keeps few ends waiting, and for each an estimate of the states up to it.

    Objects are finished one by one. Tried are orders along the three axes (``places``: a point of each object), and always the object that
    leaves the fewest ends waiting, beginning with ``first`` and with an object far from it. The narrowest one is taken.
    """
    around: dict[int, list[tuple[int, int]]] = {}
    for number, (one, other) in enumerate(patches):
        around.setdefault(one, []).append((number, other))
        around.setdefault(other, []).append((number, one))
    if first not in around:
        return list(range(len(patches))), [math.inf] * len(patches)
    far = list(hops({index: [other for _, other in ways] for index, ways in around.items()}, [first]))[-1]
    objects = [sorted(around, key=lambda index: (*places[index][axis:], *places[index][:axis], index)) for axis in range(3)]
    objects += [order for start in (first, far) if (order := _narrowest(around, start))]
    orders = [_finish_one_by_one(around, candidate) for candidate in objects]
    widths = [_width(patches, around, order) for order in orders]
    best = min(range(len(widths)), key=lambda k: widths[k][-1])
    return orders[best], widths[best]


def hops(neighbours: Mapping[int, Sequence[int]], starts: Sequence[int]) -> dict[int, int]:
    """Distances, in edges, of all objects that are reached from ``starts``, the nearest first."""
    reached = dict.fromkeys(starts, 0)
    queue = list(reached)
    for index in queue:
        for other in neighbours.get(index, ()):
            if other not in reached:
                reached[other] = reached[index] + 1
                queue.append(other)
    return reached


def _may_wait(done: int, size: int) -> int:
    """Ends that may wait in an object of which ``done`` of ``size`` patches are taken: each of them needs one still to come."""
    return min(done, size - done)


def _narrowest(around: Neighbours, start: int) -> list[int]:
    """Objects in an order in which each next one leaves as few ends waiting as possible; [] where there is no narrow one."""
    size = {index: len(patches) for index, patches in around.items()}
    taken = dict.fromkeys(around, 0)
    done: set[int] = set()
    order: list[int] = []
    frontier = {start: 0}

    def growth(index: int) -> int:
        new: dict[int, int] = {}
        for _, other in around[index]:
            if other not in done:
                new[other] = new.get(other, 0) + 1
        return sum(_may_wait(taken[k] + n, size[k]) - _may_wait(taken[k], size[k]) for k, n in new.items()) - _may_wait(
            taken[index], size[index]
        )

    while frontier:
        if len(frontier) > WIDEST:
            return []
        index = min(frontier, key=lambda k: (growth(k), frontier[k]))
        del frontier[index]
        done.add(index)
        order.append(index)
        for _, other in around[index]:
            if other not in done:
                taken[other] += 1
                frontier.setdefault(other, len(order))
    return order


def _finish_one_by_one(around: Neighbours, objects: Sequence[int]) -> list[int]:
    rank = {index: k for k, index in enumerate(objects)}
    order: list[int] = []
    for index in objects:
        here = rank[index]
        order += [number for other, number in sorted((rank[other], number) for number, other in around[index]) if other > here]
    return order


def _width(patches: Sequence[tuple[int, int]], around: Neighbours, order: Sequence[int]) -> list[float]:
    """An estimate of the states of all steps up to each: a small power of the number of ends that may wait."""
    size = {index: len(patches) for index, patches in around.items()}
    taken = dict.fromkeys(around, 0)
    waiting = 0
    states = []
    for number in order:
        for index in patches[number]:
            before = taken[index]
            taken[index] = before + 1
            waiting += _may_wait(before + 1, size[index]) - _may_wait(before, size[index])
        states.append(2.0 ** min(waiting, 500))
    return list(itertools.accumulate(states))


@dataclass(slots=True)
class _Layer:
    """The states after some patches, without (``opened``) and with (``closed``) the fragment that ends at a listener: row of each state in
    the values (rows, contacts crossed, lanes) and (rows, listeners, contacts crossed, lanes)."""

    opened: dict[int, int]
    closed: dict[int, int]
    open_values: FloatArray
    closed_values: FloatArray


@dataclass(slots=True)
class _Moves:
    """Transitions of one contact, as parallel lists: from which row, to which row, with which factor."""

    source: list[int] = field(default_factory=list)
    target: list[int] = field(default_factory=list)
    factor: list[int] = field(default_factory=list)


class SumOverPaths:
    """Sum (listeners, contacts crossed, lanes) over all paths from the start to the listeners, which can be paused between two crossings.

    ``start`` (contacts crossed, lanes): the value at the start; ``at_start`` (listeners, lanes): factors of ending there at once. With
    ``limited`` contacts are counted, and paths with more than there is room for are left out; else there is room for one count, which
    stands for all. ``expected``: an estimate of the states up to each patch. ``work`` is what has been done so far.
    """

    def __init__(
        self,
        crossings: Sequence[Crossing],
        weights: Sequence[Weights],
        start: FloatArray,
        at_start: FloatArray,
        limited: bool,
        expected: Sequence[float],
    ) -> None:
        listeners, (steps, lanes) = len(at_start), start.shape
        self.work = 0.0
        self._crossings, self._weights, self._limited, self._expected = crossings, weights, limited, expected
        self._place = 0
        self._total = at_start[:, None] * start
        self._layer = self._following = _Layer({SOURCE: 0}, {}, start[None], np.zeros((0, listeners, steps, lanes)))
        self._cost = 1 + listeners * steps * lanes / ELEMENTS

    def run(self, allowed: float) -> FloatArray | None:
        """The sum, or None where it takes more than ``allowed`` work altogether, or will as far as can be told. It goes on from where it
        was."""
        while self._place < len(self._crossings):
            if self.work > allowed or self._hopeless(allowed):
                return None
            self._take(self._crossings[self._place], self._weights[self._place])
            self._place += 1
        return self._total

    def _hopeless(self, allowed: float) -> bool:
        done = self._expected[self._crossings[self._place - 1].patch] if self._place else math.inf
        return self.work > HOPELESS * allowed and self.work * self._expected[-1] > 2 * allowed * done

    def _take(self, crossing: Crossing, weight: Weights) -> None:
        if crossing.first:
            layer = self._layer = self._following
            self._following = _Layer(dict(layer.opened), dict(layer.closed), layer.open_values, layer.closed_values)
        following = self._following
        self.work += self._cost * _cross(self._layer, following, self._total, crossing, weight, self._limited)
        for slots, most in crossing.most:
            following.opened, following.open_values = _at_most(following.opened, following.open_values, slots, most)
            following.closed, following.closed_values = _at_most(following.closed, following.closed_values, slots, most)


def _cross(layer: _Layer, following: _Layer, total: FloatArray, crossing: Crossing, weight: Weights, limited: bool) -> int:
    """All ways in which the states of ``layer`` cross a contact, added to those of ``following`` and to ``total``; how many there are.

    Either side of the contact is joined to an end that waits in its object, or to the listeners, or waits itself.
    """
    sides, width = _sides(crossing), weight.joins.shape[1]
    open_moves, _ = _joined(layer.opened, following.opened, sides, width)
    ending = [
        (*_ended(layer.opened, following.closed, side), ends, alone)
        for side, ends, alone in zip(sides, weight.ends[::-1], weight.alone, strict=True)
        if ends is not None
    ]
    closed_moves, met = _joined(layer.closed, following.closed, sides, width)
    opened, closed = layer.open_values, layer.closed_values
    if limited:
        opened, closed = _one_more(opened), _one_more(closed)
    table = weight.joins.reshape(-1, weight.joins.shape[-1])
    following.open_values = _grown(following.open_values, len(following.opened))
    following.closed_values = _grown(following.closed_values, len(following.closed))
    if open_moves.source:
        _add(following.open_values, open_moves, opened[open_moves.source] * table[open_moves.factor, None])
    if closed_moves.source:
        _add(following.closed_values, closed_moves, closed[closed_moves.source] * table[closed_moves.factor, None, None])
    for begun, ended, ends, alone in ending:
        if begun.source:
            value = opened[begun.source] * alone[begun.factor, None]
            _add(following.closed_values, begun, value[:, None] * ends[None, :, None])
        if ended.source:
            total += (opened[ended.source] * alone[ended.factor, None]).sum(axis=0) * ends[:, None]
    if met.source:
        total += (closed[met.source] * table[met.factor, None, None]).sum(axis=0)
    done = [open_moves, closed_moves, met, *(moves for begun, ended, _, _ in ending for moves in (begun, ended))]
    return sum(len(moves.source) for moves in done)


_Side = list[tuple[int, int, int, int]]
"""Ends that a side of a contact can be joined to: shift of the slot, mask without it, the other end of what waits there where the state
does not say (else 0), and number of the factor. The last one is the side itself, which then waits alone: both ends of a fragment."""


def _sides(crossing: Crossing) -> tuple[_Side, _Side]:
    """Both sides of a contact."""
    sides = []
    for waiting, slot, waits in zip(crossing.waiting, crossing.slots, crossing.waits, strict=True):
        ends = [(SHIFT[at + FIRST], WITHOUT[at + FIRST], 0, k) for k, (_, at) in enumerate(waiting)]
        if waits:
            ends.append((SHIFT[slot + FIRST], -1, slot + FIRST, len(waiting)))
        sides.append(ends)
    return sides[0], sides[1]


def _joined(states: Mapping[int, int], following: dict[int, int], sides: tuple[_Side, _Side], width: int) -> tuple[_Moves, _Moves]:
    """Moves to states in which both sides are joined to ends that wait, or wait; and those where the source's fragment meets a
    listener's and nothing else is open."""
    moves, met = _Moves(), _Moves()
    if not states:
        return moves, met
    source, target, factors = moves.source, moves.target, moves.factor
    ends_a, ends_b = sides
    starts = [(shift, without, alone, k * width) for shift, without, alone, k in ends_a]
    for state, row in states.items():
        # Side b is not joined to the other end of what side a is joined to: the fragment would be a cycle.
        joined = [
            (state & without & WITHOUT[mate], mate, code)
            for shift, without, alone, code in starts
            if (mate := state >> shift & FIELD or alone)
        ]
        for rest, mate_a, code in joined:
            for shift, without, alone, k in ends_b:
                mate_b = rest >> shift & FIELD or alone
                if not mate_b:
                    continue
                key = rest & without & WITHOUT[mate_b]
                if mate_a >= FIRST:
                    key |= mate_b << SHIFT[mate_a]
                elif mate_b < FIRST:
                    if not key:
                        met.source.append(row)
                        met.factor.append(code + k)
                    continue
                if mate_b >= FIRST:
                    key |= mate_a << SHIFT[mate_b]
                source.append(row)
                target.append(following.setdefault(key, len(following)))
                factors.append(code + k)
    return moves, met


def _ended(states: Mapping[int, int], closed: dict[int, int], side: _Side) -> tuple[_Moves, _Moves]:
    """Moves where one ``side`` of the contact is joined or waits and the other ends at the listeners: to states with a fragment that ends
    there, and to whole paths."""
    begun, ended = _Moves(), _Moves()
    for state, row in states.items():
        for shift, without, alone, factor in side:
            mate = state >> shift & FIELD or alone
            if mate >= FIRST:
                key = state & without & WITHOUT[mate] | LISTENER << SHIFT[mate]
                begun.source.append(row)
                begun.target.append(closed.setdefault(key, len(closed)))
                begun.factor.append(factor)
            elif mate == SOURCE and not state & without:
                ended.source.append(row)
                ended.factor.append(factor)
    return begun, ended


def _one_more(values: FloatArray) -> FloatArray:
    """Values by contacts crossed, one contact later."""
    shifted = np.zeros_like(values)
    shifted[..., 1:, :] = values[..., :-1, :]
    return shifted


def _grown(values: FloatArray, rows: int) -> FloatArray:
    """A copy with zeros for new rows."""
    return np.concatenate([values, np.zeros((rows - len(values), *values.shape[1:]))])


def _add(values: FloatArray, moves: _Moves, terms: FloatArray) -> None:
    """Add each term to the row that it moves to."""
    if values[0].size == 1:
        values.reshape(-1)[:] += np.bincount(moves.target, weights=terms.reshape(-1), minlength=len(values))
        return
    target = np.array(moves.target)
    order = np.argsort(target, kind="stable")
    begin, _ = runs(target[order])
    values[target[order[begin]]] += np.add.reduceat(terms[order], begin, axis=0)


def _at_most(states: dict[int, int], values: FloatArray, slots: Sequence[int], most: int) -> tuple[dict[int, int], FloatArray]:
    """The states in which at most ``most`` of the slots hold a waiting end."""
    lowest = sum(1 << BITS * slot for slot in slots)
    mask = lowest * FIELD
    if most == 0:
        kept = [(state, row) for state, row in states.items() if not state & mask]
    else:
        kept = []
        for state, row in states.items():
            any_bit = state & mask
            any_bit |= any_bit >> 1
            any_bit |= any_bit >> 2
            any_bit |= any_bit >> 3  # the lowest bit of each field now says whether any of its seven is set
            if (any_bit & lowest).bit_count() <= most:
                kept.append((state, row))
    if len(kept) == len(states):
        return states, values
    return {state: number for number, (state, _) in enumerate(kept)}, values[[row for _, row in kept]]
