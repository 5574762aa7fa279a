"""The walk operator of a scene: whether sums over paths are well posed, and bounds on them.

Rows and columns of the walk operator W are contact crossings, given by the contact nodes through
which an object is entered. The entry from a to b is the gain of the intra-connection from a to the
exit before b, times that of the inter-connection; a walk does not return through the contact that
it has just crossed. The sum over all walks is the Neumann series of W. It converges where the
spectral radius is below 1: always in a forest, whose operator is nilpotent. Where it diverges, a
sum over paths is finite only because no contact is crossed twice, and a limited sum depends on its
limits.

For a vector x > 0 the ratios ``(W x)_i / x_i`` enclose the spectral radius (L. Collatz,
Mathematische Zeitschrift 48, 1942; H. Wielandt, Mathematische Zeitschrift 52, 1950); for the lower
bound x may vanish outside the cycles. Power iteration brings the two together. The radius of a
subset of the contacts is a lower bound: for objects with many contacts a subset of neighbouring
ones is examined first, and all of them only if these do not already prove divergence.

Where the upper bound q is below 1, the same vector bounds the rest of a Neumann series: exchanging
the two sides of every contact turns W into its transpose, so ``W x <= q x`` gives a v with ``Wᵀ v
<= q v``, and what follows after a term f <= c v sums to at most c q / (1 - q) v.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, ranges, runs
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, distances
from .connections import LARGEST, intra_gains

DENSE = 24
"""Objects with at least this many contacts have their part of the operator as a dense matrix."""

PAIRS = 1 << 23
"""Most pairs of contacts inside objects; of a larger scene only a subset is examined."""

EXCERPTS = 128, 512
"""Sizes of the subsets of contacts per object that are examined before all of them."""

STEPS, CHECKED = 240, 8
"""Most steps of the power iteration, and steps between two evaluations of the bounds."""

PRECISE = 0.01
"""Relative width at which bounds of 1 or more are precise enough."""

SETTLED = 5e-4
"""Relative change between two evaluations at which an upper bound below 1 is precise enough."""

TERMS = 1000
"""Most terms of a Neumann series."""

ROUNDS = 32
"""Rounds in which all vertices of degree 1 are removed at once; long chains are then removed one by
one."""

OUTSIDE = 1e-6
"""Initial components of the vector outside the cycles, relative to the least one on a cycle."""

NEGLIGIBLE = 1e-9
"""Part of the sum below which the bound on the remaining terms is small enough."""


@frozen
class WalkRadius:
    """Certified bounds on the spectral radius; ``high`` is infinite if only a part of the scene was
    examined."""

    low: float
    high: float

    @property
    def well_posed(self) -> bool:
        """Whether the sum over all walks certainly converges."""
        return self.high < 1

    @property
    def value(self) -> float:
        """A single value: the lower bound if that is 1 or more, else the upper one."""
        return self.low if self.low >= 1 else self.high


class WalkOperator:
    """The walk operator of a graph, or of some of its ``contacts`` (c,), and its spectral
    radius."""

    def __init__(self, graph: HapticGraph, contacts: BoolArray | None = None) -> None:
        self._graph = graph
        self._entry = np.flatnonzero(graph.partner >= 0)
        if contacts is not None:
            self._entry = self._entry[contacts[graph.contact[self._entry]]]
        self._number = np.full(graph.node_count, -1, dtype=np.int64)
        self._number[self._entry] = np.arange(len(self._entry))
        self._other_side = self._number[graph.partner[self._entry]]
        contact = graph.contact[self._entry]
        self._crossing: FloatArray = graph.transmission[contact]
        self._cyclic = self._entries_on_cycles()
        self._vector: FloatArray = self._cyclic
        size = np.bincount(graph.node_object[self._entry], minlength=1)
        self.radius: WalkRadius
        low = 0.0
        for most in EXCERPTS:
            if contacts is None and self.has_cycles and size.max() > most and low < 1:
                low = WalkOperator(graph, self._excerpt(most)).radius.low
        if low >= 1 or int((size * size).sum()) > PAIRS:
            self.radius = WalkRadius(low, math.inf)
        else:
            self._assemble()
            self.radius = self._spectral_radius()

    @property
    def has_cycles(self) -> bool:
        """Whether some contacts lie on cycles: without cycles, at most one path joins any two
        nodes."""
        return bool(self._cyclic.any())

    def _excerpt(self, most: int) -> BoolArray:
        """Which contacts (c,) are, in each of their objects, among the ``most`` that are nearest to
        the middle of all contacts."""
        graph = self._graph
        object_of = graph.node_object[self._entry]
        kept = np.ones(graph.contact_count, dtype=np.bool_)
        for index in np.flatnonzero(np.bincount(object_of) > most).tolist():
            nodes = self._entry[object_of == index]
            position = graph.node_position[nodes]
            away = distances(position, position.mean(axis=0))
            kept[graph.contact[nodes[np.argsort(away, kind="stable")[most:]]]] = False
        return kept

    def _assemble(self) -> None:
        """Gains of the intra-connections: in compressed rows, but of objects with many contacts as
        dense matrices."""
        graph = self._graph
        object_of = graph.node_object[self._entry]
        begin, size = runs(object_of)
        self._blocks: list[tuple[slice, FloatArray]] = []
        for first, count in zip(
            begin[size >= DENSE].tolist(), size[size >= DENSE].tolist(), strict=True
        ):
            part = slice(first, first + count)
            nodes = self._entry[part]
            gains, _ = intra_gains(graph, nodes.repeat(count), np.tile(nodes, count))
            gains = gains.reshape(count, count)
            np.fill_diagonal(gains, 0.0)
            self._blocks.append((part, np.minimum(gains, LARGEST)))
        few = (size > 1) & (size < DENSE)
        begin = begin[few]
        size = size[few]
        self._row = ranges(begin, size)
        each = size.repeat(size)
        self._first = each.cumsum() - each
        self._column = ranges(begin.repeat(size), each)
        row = self._row.repeat(each)
        gains, _ = intra_gains(graph, self._entry[row], self._entry[self._column])
        gains[row == self._column] = 0.0
        self._gain = np.minimum(gains, LARGEST)

    def _inside(self, values: FloatArray) -> FloatArray:
        """The symmetric matrix of the intra-connections' gains, times ``values`` (e,)."""
        result = np.zeros(len(values))
        if len(self._row):
            result[self._row] = np.add.reduceat(self._gain * values[self._column], self._first)
        for part, gains in self._blocks:
            result[part] = np.einsum(
                "ij,j->i", gains, values[part]
            )  # no BLAS: the same bits with any number of threads
        return result

    def _applied(self, values: FloatArray) -> FloatArray:
        """The walk operator times ``values`` (e,)."""
        return self._inside((self._crossing * values)[self._other_side])

    def _entries_on_cycles(self) -> FloatArray:
        """1 for the entries through contacts that are left when objects with a single contact are
        removed again and again, else 0."""
        graph = self._graph
        first = np.flatnonzero(self._entry < graph.partner[self._entry])
        ends = np.column_stack(
            [
                graph.node_object[self._entry[first]],
                graph.node_object[graph.partner[self._entry[first]]],
            ]
        )
        contact = graph.contact[self._entry]
        return np.isin(contact, contact[first[_on_cycles(ends)]]).astype(np.float64)

    def _spectral_radius(self) -> WalkRadius:
        """Collatz-Wielandt bounds by power iteration on the cycles. Stores the vector of the upper
        bound for `_contracted`. Ends once the bounds agree to `PRECISE`, or, below 1, once the
        upper one has settled."""
        inside = np.flatnonzero(self._cyclic)
        vector, low, high = self._cyclic, 0.0, math.inf
        for step in range(STEPS if len(inside) else 0):
            applied = self._applied(vector) * self._cyclic
            if step % CHECKED == 0:
                ratio = float(np.max(applied[inside] / vector[inside])) * (1 + 1e-12)
                before = high
                if ratio < high:
                    high, self._vector = ratio, vector
                if high < 1 and before - high < SETTLED * high:
                    low = self._lower_bound(vector, (1 - PRECISE) * high)
                    break
                if high >= 1:
                    low = max(low, self._lower_bound(vector, (1 - PRECISE) * high))
                    if low >= (1 - PRECISE) * high:
                        break
            if not applied.any():  # nothing passes through any object on a cycle
                break
            # The mean of two steps: a cycle alone would oscillate.
            vector = vector / vector.max() + applied / applied.max()
        return WalkRadius(low, high if len(inside) else 0.0)

    def _lower_bound(self, vector: FloatArray, wanted: float) -> float:
        """A lower bound on the spectral radius by ``vector`` on a part of the cycles, without
        entries whose ratio is below ``wanted``."""
        best = 0.0
        support = self._cyclic
        for _ in range(CHECKED):
            inside = np.flatnonzero(support)
            if len(inside) == 0:
                break
            ratio = self._applied(vector * support)[inside] / vector[inside]
            best = max(best, float(ratio.min()) * (1 - 1e-12))
            if best >= wanted:
                break
            support = support.copy()
            support[inside[ratio < wanted]] = 0.0
        return best

    def _contracted(self) -> tuple[FloatArray, float]:
        """A vector x > 0 and q with ``W x <= q x``, found from the vector of the spectral radius; q
        is infinite where none was found."""
        wanted = (1 + self.radius.high) / 2
        outside = self._cyclic == 0
        # Small outside the cycles, so that what leads away from them hardly adds there; what leads
        # to them is then made large enough.
        least = float(self._vector[~outside].min(initial=1.0))
        vector = np.where(outside, OUTSIDE * (wanted - self.radius.high) * least, self._vector)
        for _ in range(TERMS):
            applied = self._applied(vector) / wanted
            larger = outside & (applied > vector)
            if not larger.any():
                ratio = float(np.max(self._applied(vector) / vector, initial=0.0)) * (1 + 1e-12)
                return vector, ratio if ratio < 1 else math.inf
            vector = np.where(larger, applied, vector)
        return vector, math.inf

    def totals(self, roots: Sequence[int], listeners: Sequence[int]) -> FloatArray | None:
        """Upper bounds (l,) on the sum over all walks from the nodes ``roots`` to each of the nodes
        ``listeners``, None where nothing bounds it."""
        (_, entry, gain), ends = self._steps(roots), self._steps(listeners)
        first = np.zeros(len(self._entry))
        np.add.at(first, self._other_side[entry], gain * self._crossing[entry])
        sums = self._series(first, ends, len(listeners), self._contracted())
        return None if sums is None else self._direct(roots, listeners) + sums[0] + sums[1]

    def _steps(self, nodes: Sequence[int]) -> tuple[IntArray, IntArray, FloatArray]:
        """The intra-connections between ``nodes`` and the contact nodes of their objects: number of
        the node, entry, gain."""
        own = np.array(nodes, dtype=np.int64)
        object_of = self._graph.node_object[self._entry]
        begin = object_of.searchsorted(self._graph.node_object[own], side="left")
        size = object_of.searchsorted(self._graph.node_object[own], side="right") - begin
        which = np.arange(len(own)).repeat(size)
        entry = ranges(begin, size)
        gain, _ = intra_gains(self._graph, own[which], self._entry[entry])
        return which, entry, gain

    def _direct(self, roots: Sequence[int], listeners: Sequence[int]) -> FloatArray:
        """Gains (l,) of the intra-connections from the roots to the listeners."""
        a = np.repeat(np.array(roots, dtype=np.int64), len(listeners))
        b = np.tile(np.array(listeners, dtype=np.int64), len(roots))
        inside = np.flatnonzero(self._graph.node_object[a] == self._graph.node_object[b])
        gains = np.zeros(len(a))
        gains[inside], _ = intra_gains(self._graph, a[inside], b[inside])
        return np.asarray(gains.reshape(len(roots), len(listeners)).sum(axis=0))

    def _series(
        self,
        term: FloatArray,
        ends: tuple[IntArray, IntArray, FloatArray],
        listeners: int,
        contracted: tuple[FloatArray, float],
    ) -> tuple[FloatArray, FloatArray] | None:
        """Sum the Neumann series that begins with ``term`` (e,), the gains of walks up to each
        entry.

        Args:
            term: the first term.
            ends: number of the listener, entry, and gain of each connection from an entry to a
                listener.
            listeners: their number.
            contracted: a vector and a ratio that bound the rest, see `_contracted`.

        Returns:
            The terms summed at each listener (l,), and a bound (l,) on all others; None if nothing
            bounds them.
        """
        node, entry, gain = ends
        vector, ratio = contracted

        def arriving(values: FloatArray) -> FloatArray:
            return np.asarray(
                np.bincount(node, weights=values[entry] * gain, minlength=listeners),
                dtype=np.float64,
            )

        bound = (self._crossing * vector)[self._other_side]
        total = np.zeros(listeners)
        rest = np.zeros(listeners)
        for _ in range(TERMS):
            total += arriving(term)
            term = (self._crossing * self._inside(term))[self._other_side]
            if not np.isfinite(term).all():
                return None
            if not term.any():
                return total, np.zeros(listeners)
            if ratio < 1:
                positive = term > 0
                rest = arriving(bound) * (
                    float(np.max(term[positive] / bound[positive])) / (1 - ratio) * (1 + 1e-9)
                )
                if np.all(rest <= NEGLIGIBLE * total):
                    break
        return (total, rest) if ratio < 1 else None


def _on_cycles(ends: IntArray) -> IntArray:
    """Numbers of the edges (e, 2) that are left when vertices of degree 1 are removed again and
    again."""
    left = np.arange(len(ends))
    for _ in range(ROUNDS):
        degree = np.bincount(ends[left].reshape(-1), minlength=1)
        inner = (degree[ends[left]] > 1).all(axis=1)
        if inner.all():
            return left
        left = left[inner]
    edges: dict[int, set[int]] = {}
    for edge, (a, b) in zip(left.tolist(), ends[left].tolist(), strict=True):
        edges.setdefault(a, set()).add(edge)
        edges.setdefault(b, set()).add(edge)
    queue = [vertex for vertex, here in edges.items() if len(here) == 1]
    while queue:
        vertex = queue.pop()
        for edge in edges.pop(vertex, ()):
            other = int(ends[edge].sum()) - vertex
            edges[other].discard(edge)
            if len(edges[other]) == 1:
                queue.append(other)
    return np.unique(np.array([edge for here in edges.values() for edge in here], dtype=np.int64))
