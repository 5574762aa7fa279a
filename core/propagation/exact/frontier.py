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
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray, IntArray, added_by
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

Join = tuple[int, int, int, int, int]
"""What one side of a contact can be joined to: shift of the slot, mask without it, the other end
where the state does not say (else 0), the bit that marks a fragment that ends at a listener, and
the number of the factor."""


@frozen
class _Side:
    """One side of a contact: its ``node``, the nodes of the object at which an end may be
    ``waiting``, and the ``joins``: to each of these, to an end that waits here, to the
    listeners."""

    node: int
    waiting: list[int]
    joins: list[Join]


@frozen
class _CrossedContact:
    """A contact, in the order in which they are taken. Of the slots in each of ``most`` only so
    many may still hold an end after it, because no more contacts are to come for them."""

    first: _Side
    second: _Side
    most: list[tuple[list[int], int]]


@dataclass(slots=True)
class _Transitions:
    """Transitions from the ``row`` of a state to that of another, the ``target``, with the number
    of their ``factor``; and the rows at which a path has ``ended``, with theirs."""

    row: list[int] = field(default_factory=list)
    target: list[int] = field(default_factory=list)
    factor: list[int] = field(default_factory=list)
    ended: list[int] = field(default_factory=list)
    ended_factor: list[int] = field(default_factory=list)


class Frontier:
    """The programme for the paths of a scene.

    Args:
        graph: the scene.
        contacts: those on paths (c, 2), given by their nodes.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        crossings: most contacts on a path; infinite where they need not be counted.

    Attributes:
        expected: an estimate of the work, infinite if more ends may wait at once than a state has
            room for.
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
        self._roots = np.array(roots, dtype=np.int64)
        self._listeners = np.array(listeners, dtype=np.int64)
        self._lanes = lanes_of(graph)
        self._limited = crossings < math.inf
        self._steps = int(crossings) + 1 if self._limited else 1
        self._cost = 1 + self._steps * len(listeners) * self._lanes / ELEMENTS
        order, transitions = contact_order(graph, contacts)
        self._contacts = self._planned(contacts[order])
        self.expected = math.inf if self._contacts is None else transitions * self._cost
        self.work = 0.0

    def sum(self, allowed: float) -> FloatArray | None:
        """The sums (listeners, lanes), or None where they take more than ``allowed`` work, or
        overflow."""
        if self._contacts is None or self.expected > allowed:
            return None
        most = self.work + allowed
        states = {SOURCE << SHIFT[slot + FIRST]: slot for slot in range(len(self._roots))}
        total = self._ends(self._roots).sum(axis=1)
        # (number of contacts crossed, listeners and lanes, states)
        values = np.zeros((self._steps, len(total), len(states)))
        values[0] = 1.0
        with np.errstate(over="ignore", invalid="ignore"):
            for contact, (first, second) in zip(
                self._contacts, self._factors(self._contacts), strict=True
            ):
                joins = len(contact.first.joins) * len(contact.second.joins)
                if self.work + self._cost * len(states) * joins > most:
                    return None
                found = _transitions(states, contact)
                self.work += self._cost * (len(found.row) + len(found.ended))
                factors = (first[:, :, None] * second[:, None]).reshape(len(total), -1)
                crossed = values
                if self._limited:
                    crossed = np.concatenate([np.zeros_like(values[:1]), values[:-1]])
                if found.ended:
                    through = crossed[..., found.ended].sum(axis=0)
                    total = total + (through * factors[:, found.ended_factor]).sum(axis=1)
                terms = crossed[..., found.row] * factors[:, found.factor]
                added = added_by(np.array(found.target, dtype=np.int64), terms, len(states))
                added[..., : values.shape[-1]] += values
                values = added
                for slots, ends in contact.most:
                    kept = _uncrowded(states, slots, ends)
                    if len(kept) < len(states):
                        values = values[..., list(kept.values())]
                        states = {state: row for row, state in enumerate(kept)}
        return total.reshape(-1, self._lanes) if np.all(total <= LARGEST) else None

    def _planned(self, contacts: IntArray) -> list[_CrossedContact] | None:
        """The contacts in this order, with slots for the ends that may wait; the roots wait at the
        first ones. None where more ends could wait than there are slots."""
        objects = self._graph.node_object
        heard = set(objects[self._listeners].tolist())
        left = np.bincount(
            objects[contacts].reshape(-1), minlength=len(self._graph.table.names)
        ).tolist()
        waiting: dict[int, list[tuple[int, int]]] = {}
        for slot, root in enumerate(self._roots.tolist()):
            waiting.setdefault(int(objects[root]), []).append((root, slot))
        free = list(range(SLOTS - 1, len(self._roots) - 1, -1))
        crossed: list[_CrossedContact] = []
        for nodes, ends in zip(contacts.tolist(), objects[contacts].tolist(), strict=True):
            sides = []
            for node, end in zip(nodes, ends, strict=True):
                here = waiting.setdefault(end, [])
                count = len(here)
                joins = [
                    (SHIFT[slot + FIRST], WITHOUT[slot + FIRST], 0, 0, k)
                    for k, (_, slot) in enumerate(here)
                ]
                sides.append(_Side(node, [other for other, _ in here], joins))
                left[end] -= 1
                if left[end]:
                    if not free:
                        return None
                    here.append((node, free.pop()))
                    joins.append((NOWHERE, -1, here[-1][1] + FIRST, 0, count))
                if end in heard:
                    joins.append((NOWHERE, -1, LISTENER, 1, count + 1))
            most = [
                ([slot for _, slot in waiting[end]], left[end])
                for end in ends
                if len(waiting[end]) > left[end]
            ]
            free += [slot for slots, count in most if not count for slot in slots]
            crossed.append(_CrossedContact(sides[0], sides[1], most))
        return crossed

    def _ends(self, nodes: IntArray) -> FloatArray:
        """Factors (listeners * lanes, n) of ending at the listeners from each node, 0 where they
        are in another object."""
        objects = self._graph.node_object
        number, which = np.nonzero(objects[self._listeners][:, None] == objects[nodes])
        table = np.zeros((len(self._listeners), self._lanes, len(nodes)))
        table[number, :, which] = intra_lanes(self._graph, nodes[which], self._listeners[number])
        return table.reshape(len(self._listeners) * self._lanes, len(nodes))

    def _factors(self, contacts: Sequence[_CrossedContact]) -> list[tuple[FloatArray, FloatArray]]:
        """Of each contact the factors (listeners * lanes, joins) of either side: of joining each
        waiting node, of waiting itself, and of ending at the listeners; those of the first side
        with the gain of the contact."""
        graph = self._graph
        sides = [side for contact in contacts for side in (contact.first, contact.second)]
        nodes = np.array([side.node for side in sides], dtype=np.int64)
        sizes = [len(side.waiting) for side in sides]
        others = np.array([node for side in sides for node in side.waiting], dtype=np.int64)
        count = len(self._listeners)
        joined = np.tile(intra_lanes(graph, nodes.repeat(sizes), others).T, (count, 1))
        alone = np.ones((len(joined), 1))
        ends = self._ends(nodes)
        first = np.cumsum([0, *sizes])
        factors = [
            np.concatenate([joined[:, first[k] : first[k + 1]], alone, ends[:, k : k + 1]], axis=1)
            for k in range(len(sides))
        ]
        contact = graph.contact[nodes[::2]]
        through = graph.transmission[contact][:, None].repeat(self._lanes, axis=1)
        if graph.contact_band_gains is not None:
            through[:, 1:] *= graph.contact_band_gains[contact]
        through = np.tile(through, count)[:, :, None]
        return [(factors[2 * k] * through[k], factors[2 * k + 1]) for k in range(len(contacts))]


def _transitions(states: dict[int, int], contact: _CrossedContact) -> _Transitions:
    """All ways in which the states cross a contact: either side is joined to an end that waits in
    its object, or to the listeners, or waits itself. New states are added to ``states``, which
    gives the row of each."""
    found = _Transitions()
    width = len(contact.second.waiting) + 2
    for state, row in list(states.items()):
        # Side 2 is not joined to the other end of what side 1 is joined to: the fragment would be a
        # cycle.
        begun = [
            (state & without & WITHOUT[mate] | mark, mate, number * width)
            for shift, without, alone, mark, number in contact.first.joins
            if (mate := state >> shift & FIELD or alone) and not state & mark
        ]
        for rest, mate_a, factor in begun:
            for shift, without, alone, mark, number in contact.second.joins:
                mate_b = rest >> shift & FIELD or alone
                if not mate_b or rest & mark:
                    continue
                key = rest & without & WITHOUT[mate_b] | mark
                if mate_a >= FIRST:
                    key |= mate_b << SHIFT[mate_a]
                elif mate_b < FIRST:
                    if key == 1:
                        found.ended.append(row)
                        found.ended_factor.append(factor + number)
                    continue
                if mate_b >= FIRST:
                    key |= mate_a << SHIFT[mate_b]
                found.row.append(row)
                found.target.append(states.setdefault(key, len(states)))
                found.factor.append(factor + number)
    return found


def _uncrowded(states: dict[int, int], slots: Sequence[int], most: int) -> dict[int, int]:
    """The states in which at most so many of the slots hold an end."""
    lowest = sum(1 << SHIFT[slot + FIRST] for slot in slots)
    mask = lowest * FIELD
    kept = {}
    for state, row in states.items():
        bits = state & mask
        if most:
            bits |= bits >> 1
            bits |= bits >> 2
            # The lowest bit of each field now says whether any of its seven is set.
            bits |= bits >> 3
            bits &= lowest
        if bits.bit_count() <= most:
            kept[state] = row
    return kept
