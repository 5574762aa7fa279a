"""Paths of many pairs of a source and a listener, as runs of one array of nodes, and what they add
up to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from ..scene.bands import BAND_COUNT
from .connections import band_costs, intra_costs

Pair = tuple[int, int]


class Paths(Mapping[Pair, tuple[int, ...]]):
    """The nodes of a path by (source, listener).

    Args:
        pairs: (p, 2) source and listener, sorted.
        nodes: (m,) those of all paths, one path after the other.
        ends: (p,) where in ``nodes`` each path ends.
    """

    def __init__(self, pairs: IntArray, nodes: IntArray, ends: IntArray) -> None:
        self.pairs, self.nodes, self.ends = pairs, nodes, ends
        self._number: dict[Pair, int] | None = None

    @classmethod
    def none(cls) -> Paths:
        nothing = np.zeros(0, dtype=np.int64)
        return cls(nothing.reshape(0, 2), nothing, nothing)

    def __getitem__(self, pair: Pair) -> tuple[int, ...]:
        if self._number is None:
            self._number = {key: number for number, key in enumerate(self)}
        number = self._number[pair]
        begin = self.ends[number - 1] if number else 0
        return tuple(self.nodes[begin : self.ends[number]].tolist())

    def __iter__(self) -> Iterator[Pair]:
        return map(tuple, self.pairs.tolist())

    def __len__(self) -> int:
        return len(self.pairs)

    def sums(self, graph: HapticGraph) -> tuple[FloatArray, FloatArray | None, FloatArray | None]:
        """The cost (p,) of each path, that in each band beyond it (p, bands), None without bands,
        and the delay (p,) [s], None without delays."""
        a, b = self.nodes[:-1], self.nodes[1:]
        across = graph.partner[a] == b
        inside = ~across
        across[self.ends[:-1] - 1] = inside[self.ends[:-1] - 1] = False  # from path to path
        begins = np.concatenate([[0], self.ends[:-1]])[: len(self.ends)]
        within, over = inside.nonzero()[0], across.nonzero()[0]
        a, b = a[within], b[within]
        index, distance = graph.node_object[a], graph.node_distances(a, b)
        contact, side = graph.contact[self.nodes[over]], graph.side[self.nodes[over]]

        def added(inner: FloatArray, outer: FloatArray) -> FloatArray:
            values = np.zeros((len(across), *inner.shape[1:]))
            values[within], values[over] = inner, outer
            return np.asarray(np.add.reduceat(values, begins, axis=0))

        bands = delay = None
        if graph.uses_bands:
            gains = graph.contact_band_gains
            outer = np.zeros((len(over), BAND_COUNT))
            if gains is not None:
                with np.errstate(divide="ignore"):
                    outer = -np.log(gains[contact, side])
            bands = added(band_costs(graph, index, distance), outer)
        if graph.uses_delays:
            slowness, late = graph.table.slowness, graph.contact_delay
            delay = added(
                np.zeros(len(index)) if slowness is None else slowness[index] * distance,
                np.zeros(len(over)) if late is None else late[contact],
            )
        cost = added(intra_costs(graph, a, b), graph.transmission_loss[contact, side])
        return cost, bands, delay
