"""The connections of best paths, each once, with the amplitude that passes along it."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..graph.distance_only import distance_only
from ..graph.haptic_graph import HapticGraph
from ..propagation.connections import intra_costs
from ..render.frame_result import FrameResult
from ..scene.values import Mode


class Connections(NamedTuple):
    """Connections from the weakest to the strongest: their nodes (m, 2), the amplitude (m, 2) and
    the metres from the source (m, 2) at either end, and the source and listener (m, 2) of their
    strongest use."""

    nodes: IntArray
    amplitude: FloatArray
    along: FloatArray
    pair: IntArray

    def ends(self, graph: HapticGraph) -> FloatArray:
        """The places of both ends, (m, 6) [m]."""
        return graph.node_position[self.nodes].reshape(-1, 6)

    def rows(self, graph: HapticGraph) -> FloatArray:
        """All that is drawn, (m, 10): `ends`, ``amplitude`` and ``along``."""
        return np.column_stack([self.ends(graph), self.amplitude, self.along])


def connections(result: FrameResult, mode: Mode, pairs: BoolArray | None = None) -> Connections:
    """The connections of the best paths between sounding sources and listeners, of some ``pairs``
    (s, l) or all."""
    graph = distance_only(result.graph) if mode is Mode.SD else result.graph
    paths = {
        pair: nodes
        for pair, nodes in result.propagation.best_path.items()
        if (pairs is None or pairs[pair]) and result.sources[pair[0]].amplitude > 0
    }
    steps, amplitude, along = path_steps(result, graph, mode, paths)
    counts = [len(nodes) - 1 for nodes in paths.values()]
    pair = np.repeat(np.array(list(paths), dtype=np.int64).reshape(-1, 2), counts, axis=0)
    strongest = np.argsort(-amplitude[:, 1], kind="stable")
    same = np.sort(steps[strongest], axis=1) @ (graph.node_count, 1)
    _, first = np.unique(same, return_index=True)
    kept = strongest[np.sort(first)[::-1]]
    return Connections(steps[kept], amplitude[kept], along[kept], pair[kept])


_LEAST = 1e-300
"""Smallest gain, used instead of 0 so that its logarithm is finite."""


def path_steps(
    result: FrameResult,
    graph: HapticGraph,
    mode: Mode,
    paths: Mapping[tuple[int, int], Sequence[int]],
) -> tuple[IntArray, FloatArray, FloatArray]:
    """The connections of paths: their nodes (m, 2), the amplitude at either end (m, 2) in the
    source's leading band, and the metres from the source at either end (m, 2)."""
    steps = np.array(
        [step for nodes in paths.values() for step in itertools.pairwise(nodes)], dtype=np.int64
    ).reshape(-1, 2)
    counts = np.array([len(nodes) - 1 for nodes in paths.values()], dtype=np.int64)
    length = graph.node_distances(*steps.T)
    if mode in (Mode.MD, Mode.MN):
        factor = np.array([result.propagation.gain[pair] for pair in paths], dtype=np.float64)
    else:
        bands = np.repeat(np.array([graph.sources[source].band for source, _ in paths]), counts)
        factor = np.empty(len(steps))
        for band in set(bands.tolist()):
            factor[bands == band] = _connection_gains(graph.in_band(band), steps[bands == band])
    own = np.array([result.sources[source].amplitude for source, _ in paths])
    cost = -np.log(np.maximum(factor, _LEAST))
    after = _running_sums(cost, counts)
    before = np.concatenate([[0.0], after])[:-1]
    before[_starts(counts)] = 0.0
    amplitude = np.repeat(own, counts)[:, None] * np.exp(-np.stack([before, after], axis=1))
    end = _running_sums(length, counts)
    return steps, amplitude, np.stack([end - length, end], axis=1)


def _connection_gains(graph: HapticGraph, steps: IntArray) -> FloatArray:
    """Gain of each connection (m,) between nodes (m, 2)."""
    inter = (graph.partner[steps[:, 0]] == steps[:, 1]) & (graph.contact[steps[:, 0]] >= 0)
    gain = np.empty(len(steps))
    gain[inter] = -graph.crossing_costs()[steps[inter, 0]]
    gain[~inter] = -intra_costs(graph, *steps[~inter].T)
    return np.exp(gain)


def _starts(counts: IntArray) -> IntArray:
    return np.cumsum(counts) - counts


def _running_sums(values: FloatArray, counts: IntArray) -> FloatArray:
    """Cumulative sums of finite values that restart with every run of ``counts``."""
    sums = np.cumsum(values)
    return sums - np.repeat((sums - values)[_starts(counts)], counts)
