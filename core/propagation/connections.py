"""Costs, band gains and delays of connections and of paths, and whether some gain exceeds 1."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, connected
from ..graph.haptic_graph import HapticGraph
from ..scene.bands import BAND_COUNT

ROUNDING = 1e-12
"""Relative slack of comparisons with the threshold: a gain equal to the threshold meets it despite
rounding of the product."""

SLACK = 1e-9
"""Costs along a tree are rounded sums, so trees extend this far beyond a limit; the exactly rounded
cost of the path decides."""

LARGEST = 1e300
"""Largest gain and sum; larger ones are clamped, as lower bounds."""

HOPS = 64
"""Most contacts on hop-constrained walks if gains exceed 1 and connections are not limited."""

STEPS = 8
"""Contacts around a source within which listeners are looked for before the connected components of
the whole scene are computed."""

PAIRS_EVALUATED = 1 << 18
"""Most intra-connections of one object that are evaluated to find gains above 1."""


def bounded_exp(x: float) -> float:
    """``exp(x)``, at most `LARGEST`."""
    return math.exp(x) if x < math.log(LARGEST) else LARGEST


def cost_limit(threshold: float) -> float:
    """Largest cost that meets the threshold, with slack for rounding."""
    return math.inf if threshold == 0 else -math.log(threshold) + ROUNDING


def intra_costs(graph: HapticGraph, a: IntArray, b: IntArray) -> FloatArray:
    """Costs of the intra-connections between nodes ``a[i]`` and ``b[i]`` of one object each."""
    constant, varying = graph.table.costs(
        graph.node_object[a], graph.node_distances(a, b), graph.ends(a, b)
    )
    constant += varying
    return constant


def intra_gains(graph: HapticGraph, a: IntArray, b: IntArray) -> tuple[FloatArray, FloatArray]:
    """Gains of the intra-connections between nodes ``a[i]`` and ``b[i]``, and distances in
    metres."""
    distance = graph.node_distances(a, b)
    return graph.table.gains(graph.node_object[a], distance, graph.ends(a, b)), distance


def lanes_of(graph: HapticGraph) -> int:
    """Number of gains per pair: 1, or 1 and one per band where bands are used."""
    return 1 + BAND_COUNT if graph.uses_bands else 1


def intra_lanes(graph: HapticGraph, a: IntArray, b: IntArray) -> FloatArray:
    """Gains (n, lanes) of the intra-connections between nodes ``a[i]`` and ``b[i]``: the plain
    gain, then that of each band."""
    gains, distance = intra_gains(graph, a, b)
    if not graph.uses_bands:
        return gains[:, None]
    return np.concatenate(
        [gains[:, None], gains[:, None] * band_factors(graph, graph.node_object[a], distance)],
        axis=1,
    )


def band_factors(graph: HapticGraph, index: IntArray, distance: FloatArray) -> FloatArray:
    """Gain in each band (n, bands), relative to the plain one, of intra-connections in objects
    ``index``."""
    gains = graph.table.band_gains
    factors = np.ones((len(index), BAND_COUNT)) if gains is None else gains.take(index, axis=0)
    if graph.table.band_decays is not None:
        factors *= np.exp(-graph.table.band_decays[index] * distance[:, None])
    return factors


class PathConnections:
    """The connections of several paths, concatenated, from which costs and band gains are
    computed."""

    def __init__(self, graph: HapticGraph, paths: Collection[tuple[int, ...]]) -> None:
        self._graph = graph
        nodes = np.fromiter(itertools.chain.from_iterable(paths), dtype=np.int64)
        a = nodes[:-1]
        b = nodes[1:]
        ends = np.fromiter(itertools.accumulate(map(len, paths)), dtype=np.int64)
        self._begins = np.concatenate([[0], ends[:-1]])[: len(ends)]
        self._ends = ends
        across = graph.partner[a] == b
        inside = ~across
        joints = self._begins[1:] - 1  # from the last node of a path to the first of the next
        across[joints] = inside[joints] = False
        self._count = len(a)
        self._inside = inside.nonzero()[0]
        self._across = across.nonzero()[0]
        a, b = a[self._inside], b[self._inside]
        self._object = graph.node_object[a]
        self._distance = graph.node_distances(a, b)
        self._patches = graph.ends(a, b)
        self._contact = graph.contact[nodes[self._across]]

    def costs(self) -> list[float]:
        """The cost ``-log(gain)`` of each path: the exactly rounded sum of the costs of its
        connections."""
        terms = np.zeros((self._count, 2))
        constant, varying = self._graph.table.costs(self._object, self._distance, self._patches)
        terms[self._inside, 0], terms[self._inside, 1] = constant, varying
        terms[self._across, 0] = self._graph.transmission_loss[self._contact]
        flat = terms.reshape(-1).tolist()
        return [
            _exact_sum(flat[2 * first : 2 * end - 2])
            for first, end in zip(self._begins.tolist(), self._ends.tolist(), strict=True)
        ]

    def bands(self) -> FloatArray:
        """Gain of each path in each band (p, bands), relative to its plain gain."""
        factors = np.ones((self._count, BAND_COUNT))
        factors[self._inside] = band_factors(self._graph, self._object, self._distance)
        if self._graph.contact_band_gains is not None:
            factors[self._across] = self._graph.contact_band_gains[self._contact]
        return np.multiply.reduceat(factors, self._begins, axis=0)


def _exact_sum(terms: Sequence[float]) -> float:
    """The exactly rounded sum, infinite if it overflows."""
    try:
        return math.fsum(terms)
    except OverflowError:
        return math.inf


def path_delay(graph: HapticGraph, path: tuple[int, ...]) -> float:
    """Delay of a path [s]: distance over wave speed inside the objects, plus the delays of the
    contacts."""
    delays = []
    for a, b in itertools.pairwise(path):
        if graph.partner[a] == b:
            if graph.contact_delay is not None:
                delays.append(float(graph.contact_delay[graph.contact[a]]))
        elif graph.table.slowness is not None:
            distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
            delays.append(float(graph.table.slowness[graph.node_object[a]]) * distance)
    return math.fsum(delays)


def joined(graph: HapticGraph, pairs: IntArray) -> BoolArray:
    """(p,) whether a chain of contacts, or one object, joins the source and the listener of each of
    ``pairs`` (p, 2)."""
    if len(pairs) == 0:
        return np.zeros(0, dtype=np.bool_)
    ends = graph.node_object[[(source.nodes[0], source.nodes[-1]) for source in graph.sources]].T[
        :, pairs[:, 0]
    ]
    listeners = graph.node_object[graph.listener_nodes[pairs[:, 1]]]
    crossed = (graph.partner > np.arange(graph.node_count)).nonzero()[0]
    one = graph.node_object[crossed]
    other = graph.node_object[graph.partner[crossed]]
    # Most scenes are one heap, so what lies a few contacts around a source mostly decides.
    reached = np.zeros(len(graph.start) - 1, dtype=np.bool_)
    reached[ends[:, 0]] = True
    for _ in range(STEPS):
        crossing = (reached[one] != reached[other]).nonzero()[0]
        if reached[ends].all() and (len(crossing) == 0 or reached[listeners].all()):
            return reached[listeners]
        reached[one[crossing]] = reached[other[crossing]] = True
    cluster = connected(np.column_stack([one, other]), len(reached))
    return np.asarray((cluster[ends] == cluster[listeners]).any(axis=0))


def amplifying(graph: HapticGraph) -> bool:
    """Whether some connection of the graph has a gain above 1. A formula is evaluated for all
    connections of its object; with very many, it counts as amplifying."""
    if (graph.transmission > 1).any() or (graph.table.loss < 0).any():
        return True
    for index in sorted(graph.table.special):
        if not graph.table.objects[index].propagation.may_amplify:
            continue
        nodes = graph.nodes_of(index)
        count = nodes.stop - nodes.start
        if count * (count - 1) // 2 > PAIRS_EVALUATED:
            return True
        first, second = np.triu_indices(count, 1)
        if np.any(
            graph.table.gain(index, graph.node_distances(nodes.start + first, nodes.start + second))
            > 1
        ):
            return True
    return False
