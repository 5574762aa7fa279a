"""The exact sum over all paths, by a dynamic programme over the contacts (Simpath) whose time grows
with the width of the scene.

The contacts are taken one after the other, each crossed or not. What is crossed so far is a set of
path fragments; only their open ends matter for what can still follow, so sets of fragments with the
same open ends are one *state*, and its value is the sum of the products of all of them. An open end
waits at a contact node of an object until a later contact of that object, or a listener, is joined
to it by their intra-connection. A state says which ends wait and which of them belong together; one
of them is the fragment that begins at the source, and one may be the fragment that ends at a
listener. A path is complete when these two meet and nothing else is open.

Source: D. E. Knuth, *The Art of Computer Programming*, volume 4A, section 7.1.4, algorithm Simpath,
here with weights instead of counts, and with the open ends of an object (which a path may pass
several times) instead of vertices (which it may not).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray, runs
from ...frozen import frozen
from ...graph.haptic_graph import HapticGraph
from ..connections import LARGEST, intra_lanes, lanes_of
from .contact_order import contact_order

BITS = 7
FIELD = (1 << BITS) - 1
SOURCE, LISTENER, FIRST = 1, 2, 3
"""A state is an integer: bit 0 says whether it has the fragment that ends at a listener; above,
each slot has a field: 0 if no end waits there, `SOURCE` or `LISTENER` for the end of that fragment,
else the slot of the fragment's other end, counted from `FIRST`."""

SLOTS = FIELD - FIRST + 1

SHIFT = tuple(1 + BITS * (mate - FIRST) for mate in range(FIELD + 1))
WITHOUT = tuple(-1 if mate < FIRST else ~(FIELD << SHIFT[mate]) for mate in range(FIELD + 1))
"""By the other end of a fragment: shift of its slot, and mask without it."""

NOWHERE = SHIFT[-1] + BITS
"""Shift to a field that is always 0."""

ELEMENTS = 16
"""How many numbers are added up in the time that it takes to find one transition: converts vector
operations to the unit of work."""

Waiting = list[tuple[int, int]]
"""Nodes of an object at which an end may wait, with their slots."""

Join = tuple[int, int, int, int, int]
"""What one side of a contact can be joined to: shift of the slot, mask without it, the other end
where the state does not say (else 0), the bit that marks a fragment that ends at a listener, and
the number of the factor."""


@frozen
class _CrossedContact:
    """A contact, in the order in which they are taken.

    ``nodes`` on either side; ``waiting`` nodes on either side; ``slots`` of its own, -1 on a side
    where no contact is left to come. Of the slots in each of ``most`` only so many may still hold
    an end after it, because no more contacts are to come for them.
    """

    nodes: tuple[int, int]
    waiting: tuple[Waiting, Waiting]
    slots: tuple[int, int]
    most: list[tuple[list[int], int]]


class Frontier:
    """The programme for the paths of a scene.

    Args:
        graph: the scene.
        contacts: those on paths (c, 2), given by their nodes.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        crossings: most contacts on a path; infinite where they need not be counted.

    Attributes:
        width: an estimate of the states in all, infinite if more ends may wait at once than a state
            has room for.
        work: transitions so far, counted by their cost.
    """

    def __init__(
        self,
        graph: HapticGraph,
        contacts: IntArray,
        roots: Sequence[int],
        listeners: Sequence[int],
        crossings: float,
    ) -> None:
        self._graph = graph
        self._listeners = np.array(listeners, dtype=np.int64)
        self._lanes = lanes_of(graph)
        self._limited = crossings < math.inf
        order, width = contact_order(graph, contacts)
        self._crossings = self._planned(contacts[order], roots)
        self.width = math.inf if self._crossings is None else width
        self.work = 0.0
        self._place = 0
        steps = int(crossings) + 1 if self._limited else 1
        lanes = len(listeners) * self._lanes
        self._cost = 1 + steps * lanes / ELEMENTS
        self._states = {SOURCE << SHIFT[slot + FIRST]: slot for slot in range(len(roots))}
        self._values = np.zeros((len(roots), steps, lanes))
        self._values[:, 0] = 1.0
        self._total = sum((self._ends(np.array([root]))[0] for root in roots), np.zeros(lanes))
        self._factors: list[tuple[FloatArray, FloatArray]] = []

    def sum(self, allowed: float) -> FloatArray | None:
        """The sums (listeners, lanes), or None where they take more than ``allowed`` work
        altogether, or overflow. A later call goes on from where this one was."""
        if self.width > allowed or self._crossings is None:
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            self._factors = self._factors or self._weighed(self._crossings)
            while self._place < len(self._crossings):
                if self.work > allowed:
                    return None
                self._cross(self._crossings[self._place], *self._factors[self._place])
                self._place += 1
        return self._total.reshape(-1, self._lanes) if np.all(self._total <= LARGEST) else None

    def _planned(self, contacts: IntArray, roots: Sequence[int]) -> list[_CrossedContact] | None:
        """The crossings of contacts in this order; the roots wait at the first slots. None where
        more ends could wait than there are slots."""
        objects = self._graph.node_object
        left = np.bincount(
            objects[contacts].reshape(-1), minlength=len(self._graph.table.names)
        ).tolist()
        waiting: dict[int, Waiting] = {}
        for slot, root in enumerate(roots):
            waiting.setdefault(int(objects[root]), []).append((root, slot))
        free = list(range(SLOTS - 1, len(roots) - 1, -1))
        crossings: list[_CrossedContact] = []
        for nodes, ends in zip(contacts.tolist(), objects[contacts].tolist(), strict=True):
            before = [list(waiting.setdefault(end, [])) for end in ends]
            slots = [-1, -1]
            for side, end in enumerate(ends):
                left[end] -= 1
                if left[end]:
                    if not free:
                        return None
                    slots[side] = free.pop()
                    waiting[end].append((nodes[side], slots[side]))
            most = [
                ([slot for _, slot in waiting[end]], left[end])
                for end in ends
                if len(waiting[end]) > left[end]
            ]
            free += [slot for end in ends if not left[end] for _, slot in waiting[end]]
            crossings.append(
                _CrossedContact(
                    (nodes[0], nodes[1]), (before[0], before[1]), (slots[0], slots[1]), most
                )
            )
        return crossings

    def _ends(self, nodes: IntArray) -> FloatArray:
        """Factors (n, listeners * lanes) of ending at the listeners from each node, 0 where they
        are in another object."""
        objects = self._graph.node_object
        which, number = np.nonzero(objects[nodes][:, None] == objects[self._listeners])
        table = np.zeros((len(nodes), len(self._listeners), self._lanes))
        apart = nodes[which] != self._listeners[number]
        which = which[apart]
        number = number[apart]
        table[which, number] = intra_lanes(self._graph, nodes[which], self._listeners[number])
        return table.reshape(len(nodes), len(self._listeners) * self._lanes)

    def _weighed(self, crossings: Sequence[_CrossedContact]) -> list[tuple[FloatArray, FloatArray]]:
        """Of each crossing the factors (joins, listeners * lanes) of either side: of joining each
        waiting node, of waiting itself, and of ending at the listeners; those of the first side
        with the gain of the contact."""
        graph = self._graph
        sides = [
            (node, waiting)
            for crossing in crossings
            for node, waiting in zip(crossing.nodes, crossing.waiting, strict=True)
        ]
        nodes = np.array([node for node, _ in sides], dtype=np.int64)
        sizes = [len(waiting) for _, waiting in sides]
        others = np.array([node for _, waiting in sides for node, _ in waiting], dtype=np.int64)
        joins = np.tile(intra_lanes(graph, nodes.repeat(sizes), others), len(self._listeners))
        ends = self._ends(nodes)
        alone = np.ones((1, joins.shape[1]))
        first = np.cumsum([0, *sizes])
        factors = [
            np.concatenate([joins[first[k] : first[k + 1]], alone, ends[k : k + 1]])
            for k in range(len(sides))
        ]
        contact = graph.contact[nodes[::2]]
        through = graph.transmission[contact][:, None].repeat(self._lanes, axis=1)
        if graph.contact_band_gains is not None:
            through[:, 1:] *= graph.contact_band_gains[contact]
        through = np.tile(through, len(self._listeners))
        return [(factors[2 * k] * through[k], factors[2 * k + 1]) for k in range(len(crossings))]

    def _cross(self, crossing: _CrossedContact, first: FloatArray, second: FloatArray) -> None:
        """Add all ways in which the states cross a contact: either side is joined to an end that
        waits in its object, or to the listeners, or waits itself. ``first`` and ``second`` are the
        factors of the sides."""
        sides = [
            _joins(*side)
            for side in zip(crossing.waiting, crossing.slots, (first, second), strict=True)
        ]
        states = self._states
        width = len(second)
        source: list[int] = []
        target: list[int] = []
        factor: list[int] = []
        ended: list[int] = []
        ended_factor: list[int] = []
        for state, row in list(states.items()):
            # Side 2 is not joined to the other end of what side 1 is joined to: the fragment would
            # be a cycle.
            begun = [
                (state & without & WITHOUT[mate] | mark, mate, code * width)
                for shift, without, alone, mark, code in sides[0]
                if (mate := state >> shift & FIELD or alone) and not state & mark
            ]
            for rest, mate_a, code in begun:
                for shift, without, alone, mark, k in sides[1]:
                    mate_b = rest >> shift & FIELD or alone
                    if not mate_b or rest & mark:
                        continue
                    key = rest & without & WITHOUT[mate_b] | mark
                    if mate_a >= FIRST:
                        key |= mate_b << SHIFT[mate_a]
                    elif mate_b < FIRST:
                        if key == 1:
                            ended.append(row)
                            ended_factor.append(code + k)
                        continue
                    if mate_b >= FIRST:
                        key |= mate_a << SHIFT[mate_b]
                    source.append(row)
                    target.append(states.setdefault(key, len(states)))
                    factor.append(code + k)
        self.work += self._cost * (len(source) + len(ended))
        table = (first[:, None] * second).reshape(-1, first.shape[1])
        crossed = self._one_crossing_later(self._values)
        if ended:
            self._total = self._total + (crossed[ended].sum(axis=1) * table[ended_factor]).sum(
                axis=0
            )
        rows = np.zeros((len(states) - len(self._values), *self._values.shape[1:]))
        self._values = np.concatenate([self._values, rows])
        if source:
            _add(self._values, target, crossed[source] * table[factor][:, None])
        for slots, most in crossing.most:
            self._drop_crowded(slots, most)

    def _one_crossing_later(self, values: FloatArray) -> FloatArray:
        """The ``values``, which are kept by number of contacts crossed, for one more contact."""
        if not self._limited:
            return values
        shifted = np.zeros_like(values)
        shifted[:, 1:] = values[:, :-1]
        return shifted

    def _drop_crowded(self, slots: Sequence[int], most: int) -> None:
        """Drop the states in which more than ``most`` of the slots hold an end."""
        lowest = sum(1 << SHIFT[slot + FIRST] for slot in slots)
        mask = lowest * FIELD
        kept = []
        for state, row in self._states.items():
            bits = state & mask
            if most:
                bits |= bits >> 1
                bits |= bits >> 2
                # The lowest bit of each field now says whether any of its seven is set.
                bits |= bits >> 3
                bits &= lowest
            if bits.bit_count() <= most:
                kept.append((state, row))
        if len(kept) < len(self._states):
            self._states = {state: number for number, (state, _) in enumerate(kept)}
            self._values = self._values[[row for _, row in kept]]


def _joins(waiting: Waiting, slot: int, factors: FloatArray) -> list[Join]:
    """What a side of a contact can be joined to."""
    joins = [(SHIFT[at + FIRST], WITHOUT[at + FIRST], 0, 0, k) for k, (_, at) in enumerate(waiting)]
    if slot >= 0:
        joins.append((NOWHERE, -1, slot + FIRST, 0, len(waiting)))
    if factors[-1].any():
        joins.append((NOWHERE, -1, LISTENER, 1, len(waiting) + 1))
    return joins


def _add(values: FloatArray, target: Sequence[int], terms: FloatArray) -> None:
    """Add each term to the row of ``values`` that is its ``target``."""
    if values[0].size == 1:
        values.reshape(-1)[:] += np.bincount(
            target, weights=terms.reshape(-1), minlength=len(values)
        )
        return
    rows = np.array(target)
    order = np.argsort(rows, kind="stable")
    begin, _ = runs(rows[order])
    values[rows[order[begin]]] += np.add.reduceat(terms[order], begin, axis=0)
