"""The part of a haptic graph that a search over paths uses, as arrays.

A partial path stands at an *entry*: a contact node through which an object has just been entered, or a root. From an entry it steps, over
one intra-connection and one inter-connection, to other entries, or it ends, over one intra-connection, at a listener.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray, portions, ranges
from ...graph.haptic_graph import HapticGraph
from ..connections import band_factors, intra_gains

OVERFLOWN = 2e300
"""Products are clamped to this value, which is above `LARGEST` and finite."""

CHUNK = 1 << 18
"""Pairs of nodes examined in one vectorised step, a bound on memory."""


@dataclass(frozen=True, slots=True)
class Arcs:
    """Steps in compressed rows: those of entry e are the ``size[e]`` from ``start[e]`` on.

    Attributes:
        to: the entry or the number of the listener that a step leads to.
        inside: gain of its intra-connection.
        gain: that times the gain of its inter-connection.
        weight: (n, lanes) gain in lanes; lane 0 the plain gain, the others those of the bands.
    """

    start: IntArray
    size: IntArray
    to: IntArray
    inside: FloatArray
    gain: FloatArray
    weight: FloatArray

    def expand(self, entry: IntArray, count: IntArray | None = None) -> tuple[IntArray, IntArray]:
        """For states at ``entry``: which state and which step, for all steps of each state or its first ``count``."""
        first = self.start[entry]
        size = self.size[entry] if count is None else count
        return np.arange(len(entry)).repeat(size), ranges(first, size)


@dataclass(frozen=True, slots=True)
class SearchGraph:
    """Entries and steps.

    Attributes:
        nodes: (e,) nodes of the haptic graph that are entries, the roots last.
        contact: (e,) number of the contact that leads into the entry, -1 for a root.
        steps: steps to other entries.
        ends: steps to listeners.
        listeners: number of listeners.
    """

    nodes: IntArray
    contact: IntArray
    steps: Arcs
    ends: Arcs
    listeners: int

    @property
    def lanes(self) -> int:
        """1, or 1 and one per band."""
        return int(self.steps.weight.shape[1])


def build_search_graph(
    graph: HapticGraph,
    entries: IntArray,
    roots: Sequence[int],
    listeners: Sequence[int],
    within: tuple[FloatArray, FloatArray, float] | None = None,
) -> SearchGraph:
    """The search graph from ``roots`` over ``entries`` (contact nodes) to ``listeners``.

    ``within``: (n,) least cost from a root to each node as an entry, (n,) least cost from it to a
    listener, and a limit: steps on no path within the limit are left out.
    """
    entries = np.sort(entries)
    nodes = np.concatenate([entries, np.array(roots, dtype=np.int64)])
    local = np.full(graph.node_count, -1, dtype=np.int64)
    local[nodes] = np.arange(len(nodes))
    exits = np.array(listeners, dtype=np.int64)
    number = np.argsort(graph.node_object[exits], kind="stable")
    steps = _rows(graph, nodes, np.sort(graph.partner[entries]), None, local, within)
    ends = _rows(graph, nodes, exits[number], number, local, within)
    entered = np.full(len(nodes), -1, dtype=np.int64)
    entered[: len(entries)] = graph.contact[entries]
    return SearchGraph(nodes, entered, steps, ends, len(exits))


def _rows(
    graph: HapticGraph,
    nodes: IntArray,
    targets: IntArray,
    number: IntArray | None,
    local: IntArray,
    within: tuple[FloatArray, FloatArray, float] | None,
) -> Arcs:
    """Steps from entries through the contact nodes ``targets``, or to the listeners ``targets`` with their ``number``; sorted by object."""
    index, there = graph.node_object[nodes], graph.node_object[targets]
    first = there.searchsorted(index, side="left")
    size = there.searchsorted(index, side="right") - first
    before, behind, limit = (np.zeros(graph.node_count), np.zeros(graph.node_count), np.inf) if within is None else within
    parts = []
    for chosen in portions(size, CHUNK):
        which = chosen.repeat(size[chosen])
        place = ranges(first[chosen], size[chosen])
        a, b = nodes[which], targets[place]
        kept = (a != b).nonzero()[0]
        which, place, a, b = which[kept], place[kept], a[kept], b[kept]
        inside, distance = intra_gains(graph, a, b)
        gain = inside
        if number is None:
            to, contact = graph.partner[b], graph.contact[b]
            gain = np.minimum(inside * graph.transmission[contact], OVERFLOWN)
            onwards = behind[to]
        else:
            to = number[place]
            onwards = np.zeros(len(b))
        with np.errstate(divide="ignore"):
            useful = ((gain > 0) & (before[a] - np.log(gain) + onwards <= limit)).nonzero()[0]
        lanes = gain[useful, None]
        if graph.uses_bands:
            bands = band_factors(graph, graph.node_object[a[useful]], distance[useful])
            if number is None and graph.contact_band_gains is not None:
                bands *= graph.contact_band_gains[contact[useful]]
            lanes = np.concatenate([lanes, lanes * bands], axis=1)
        to = to[useful]
        parts.append((which[useful], local[to] if number is None else to, inside[useful], gain[useful], lanes))
    which, to, inside, gain, lanes = parts[0] if len(parts) == 1 else (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    size = np.bincount(which, minlength=len(nodes))
    return Arcs(np.concatenate([[0], size.cumsum()]), size, to, inside, gain, lanes)
