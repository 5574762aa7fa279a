"""The part of a haptic graph that a search over paths uses, as arrays, and bounds on what lies
ahead in it.

A partial path stands at an *entry*: a contact node through which an object has just been entered,
or a root. From an entry it steps, over one intra-connection and one inter-connection, to other
entries, or it ends, over one intra-connection, at a listener.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray, portions, ranges
from ...frozen import frozen
from ...graph.haptic_graph import HapticGraph
from ..connections import LARGEST, band_factors, intra_gains

CHUNK = 1 << 18
"""Pairs of nodes examined in one vectorised step, a bound on memory."""

TERMS, SETTLED = 400, 20
"""Most terms of the series of walks, and terms after which it is judged by the ratio of consecutive
ones."""

FEW = 8
"""Most contacts of the walks by whose sum states are ranked: over more of them the sum of all walks
may be too large to tell states apart."""

NEGLIGIBLE = 1e-4
"""Part of the sum below which the ratio of terms bounds the rest closely enough."""


@frozen
class Steps:
    """Steps in compressed rows: those of entry e are the ``size[e]`` from ``start[e]`` on.

    ``to`` (n,): the entry, or the number of the listener, that a step leads to. ``inside`` (n,):
    gain of its intra-connection. ``gain`` (n, lanes): that times the gain of its inter-connection;
    lane 0 the plain gain, the others those of the bands.
    """

    start: IntArray
    size: IntArray
    to: IntArray
    inside: FloatArray
    gain: FloatArray

    def expand(self, entry: IntArray) -> tuple[IntArray, IntArray]:
        """For states at ``entry``: which state and which step, for all steps of each."""
        count = self.size[entry]
        return np.arange(len(entry)).repeat(count), ranges(self.start[entry], count)

    def backwards(self, values: FloatArray) -> FloatArray:
        """Sums (e, l) over the steps of each entry: its gain times the value where it leads, of
        ``values`` (e, l)."""
        result = np.zeros((len(self.size), values.shape[1]))
        filled = self.size.nonzero()[0]
        if len(filled):
            with np.errstate(over="ignore"):
                result[filled] = np.add.reduceat(
                    self.gain[:, :1] * values[self.to], self.start[filled], axis=0
                )
        return np.minimum(result, LARGEST)


@frozen
class StepGraph:
    """``nodes`` (e,) of the haptic graph that are entries, the roots last; the ``contact`` (e,)
    that leads into each, numbered from 0, -1 for a root; ``steps`` to other entries and ``ends`` at
    listeners; number of ``listeners``."""

    nodes: IntArray
    contact: IntArray
    steps: Steps
    ends: Steps
    listeners: int


def build_step_graph(
    graph: HapticGraph,
    entries: IntArray,
    roots: Sequence[int],
    listeners: Sequence[int],
    within: tuple[FloatArray, FloatArray, float] | None = None,
) -> StepGraph:
    """The steps of paths through a scene.

    Args:
        graph: the scene.
        entries: contact nodes through which a path may enter an object.
        roots: nodes at which paths begin.
        listeners: nodes at which they end.
        within: (n,) least cost from a root to each node as an entry, (n,) least cost from it to a
            listener, and a limit: steps on no path within the limit are left out.
    """
    entries = np.sort(entries)
    nodes = np.concatenate([entries, np.array(roots, dtype=np.int64)])
    before, behind, limit = within or (
        np.zeros(graph.node_count),
        np.zeros(graph.node_count),
        np.inf,
    )

    def steps(targets: IntArray, numbered: Sequence[int] | IntArray, crossing: bool) -> Steps:
        """Steps through the contact nodes ``targets`` to the entries ``numbered``, or to the
        listeners that these are."""
        number = np.full(graph.node_count, -1, dtype=np.int64)
        number[numbered] = np.arange(len(numbered))
        index = graph.node_object[nodes]
        there = graph.node_object[targets]
        first = there.searchsorted(index, side="left")
        size = there.searchsorted(index, side="right") - first
        parts = []
        for chosen in portions(size, CHUNK):
            which = chosen.repeat(size[chosen])
            a = nodes[which]
            b = targets[ranges(first[chosen], size[chosen])]
            inside, distance = intra_gains(graph, a, b)
            to, gain = (
                (graph.partner[b], inside * graph.transmission[graph.contact[b]])
                if crossing
                else (b, inside)
            )
            with np.errstate(divide="ignore"):
                cost = before[a] - np.log(gain) + (behind[to] if crossing else 0.0)
            useful = ((a != b) & (gain > 0) & (cost <= limit)).nonzero()[0]
            lanes = np.minimum(gain[useful, None], 2 * LARGEST)
            if graph.uses_bands:
                bands = band_factors(graph, graph.node_object[a[useful]], distance[useful])
                if crossing and graph.contact_band_gains is not None:
                    bands *= graph.contact_band_gains[graph.contact[b[useful]]]
                lanes = np.concatenate([lanes, lanes * bands], axis=1)
            parts.append((which[useful], number[to[useful]], inside[useful], lanes))
        which, arrived, inside, lanes = (
            parts[0]
            if len(parts) == 1
            else (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        )
        size = np.bincount(which, minlength=len(nodes))
        return Steps(size.cumsum() - size, size, arrived, inside, lanes)

    contact = np.concatenate(
        [np.unique(graph.contact[entries], return_inverse=True)[1], np.full(len(roots), -1)]
    )
    over = steps(np.sort(graph.partner[entries]), nodes, True)
    ends = steps(np.sort(np.array(listeners, dtype=np.int64)), list(listeners), False)
    return StepGraph(nodes, contact, over, ends, len(listeners))


def walk_sums(paths: StepGraph, crossings: int) -> tuple[FloatArray, FloatArray]:
    """The sum (e, l) over all walks over at most ``crossings`` contacts from each entry to each
    listener, or an upper bound on it, `LARGEST` where nothing bounds it; and the sum over those
    over at most `FEW` contacts. A walk takes steps like a path but may cross a contact again
    (though not turn round at once).

    Where the next term of the series is at most q times the last one element by element with q < 1,
    the terms after it sum to at most ``q / (1 - q)`` times it (Collatz and Wielandt; R. S. Varga,
    *Matrix Iterative Analysis*, Springer 2000, theorem 2.2).
    """
    total = np.zeros((len(paths.nodes), paths.listeners))
    ends = paths.ends
    total[np.arange(len(total)).repeat(ends.size), ends.to] = np.minimum(ends.gain[:, 0], LARGEST)
    few = term = total
    for k in range(crossings):
        following = paths.steps.backwards(term)
        if not following.any():
            break
        if k >= SETTLED:
            times = np.divide(following, term, out=np.full(term.shape, np.inf), where=term > 0)
            ratio = float(np.max(times[following > 0])) * (1 + 1e-12)
            if ratio < 1 and np.all(following <= NEGLIGIBLE * total):
                return np.minimum(total + following / (1 - ratio), LARGEST), few
            if crossings > TERMS and (k >= TERMS or following.sum() > term.sum()):
                return np.full(term.shape, LARGEST), few
        total = np.minimum(total + following, LARGEST)
        term = following
        if k < FEW:
            few = total
    return total, few
