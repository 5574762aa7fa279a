"""Paths of many pairs of a source and a listener, as runs of one array of nodes, and what they add
up to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray, portions
from ..graph.haptic_graph import HapticGraph
from ..scene.bands import BAND_COUNT
from .connections import band_costs

Pair = tuple[int, int]

NODES_AT_ONCE = 1 << 15
"""Nodes of paths that are added up at a time, so that what is added stays in the cache."""


class Paths(Mapping[Pair, tuple[int, ...]]):
    """The nodes of a path by (source, listener).

    Args:
        pairs: (p, 2) source and listener.
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

    @classmethod
    def joined(cls, parts: Sequence[Paths]) -> Paths:
        """All paths of some ``parts``, in their order."""
        parts = [part for part in parts if len(part)]
        if len(parts) < 2:
            return parts[0] if parts else cls.none()
        before = np.cumsum([0, *(len(part.nodes) for part in parts[:-1])]).tolist()
        return cls(
            np.concatenate([part.pairs for part in parts]),
            np.concatenate([part.nodes for part in parts]),
            np.concatenate([part.ends + k for part, k in zip(parts, before, strict=True)]),
        )

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
        through = _through_contacts(graph, self.nodes[1::2])
        begins = np.concatenate([[0], self.ends[:-1]])[: len(self)]
        found = []
        for part in portions(self.ends, NODES_AT_ONCE):
            begin = begins[part].min(initial=len(self.nodes))
            nodes = self.nodes[begin : self.ends[part].max(initial=0)]
            a, b = nodes.reshape(-1, 2).T  # from the one to the other, then over its contact
            inside = _inside_objects(graph, a, b)
            found.append(
                [
                    None if outer is None else _added(inner, outer[b], begins[part] - begin)
                    for inner, outer in zip(inside, through, strict=True)
                ]
            )
        summed: list[Any] = [
            None if parts[0] is None else np.concatenate(parts)
            for parts in zip(*found, strict=True)
        ]
        cost, bands, delay = summed
        return cost, bands, delay


def _added(inner: FloatArray, outer: FloatArray, begins: IntArray) -> FloatArray:
    """Sums over the paths that begin at these nodes, of what each two nodes add (m, ...)."""
    values = np.stack([inner, outer], axis=1).reshape(-1, *inner.shape[1:])
    return np.add.reduceat(values, begins, axis=0)


def _inside_objects(graph: HapticGraph, a: IntArray, b: IntArray) -> tuple[FloatArray, ...]:
    """What connections between nodes of one object add, as `Paths.sums`."""
    index, distance = graph.node_object[a], graph.node_distances(a, b)
    constant, varying = graph.table.costs(index, distance, graph.ends(a, b))
    slowness = graph.table.slowness
    return (
        constant + varying,
        band_costs(graph, index, distance) if graph.uses_bands else varying,
        np.zeros(len(a)) if slowness is None else slowness[index] * distance,
    )


def _through_contacts(graph: HapticGraph, nodes: IntArray) -> list[FloatArray | None]:
    """What going over the contact of each node (n, ...) adds, as `Paths.sums`, for some of the
    ``nodes``; 0 without a contact."""
    is_used = np.zeros(graph.node_count, dtype=np.bool_)
    is_used[nodes] = True
    over = (is_used & (graph.contact >= 0)).nonzero()[0]
    contact, side = graph.contact[over], graph.side[over]
    gains, late = graph.contact_band_gains, graph.contact_delay
    cost, delay = np.zeros((2, graph.node_count))
    bands = np.zeros((graph.node_count, BAND_COUNT)) if graph.uses_bands else None
    cost[over] = graph.transmission_loss[contact, side]
    if gains is not None and bands is not None:
        with np.errstate(divide="ignore"):
            bands[over] = -np.log(gains[contact, side])
    if late is not None:
        delay[over] = late[contact]
    return [cost, bands, delay if graph.uses_delays else None]
