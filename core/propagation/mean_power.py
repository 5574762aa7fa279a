"""Listeners that feel the mean power over their volume: gains are computed for each of its sample
points, as if it were a listener, and averaged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.haptic_graph import HapticGraph
from ..graph.listener_volumes import WEIGHTS
from .result import Propagation


def over_volumes(
    graph: HapticGraph, propagated: Callable[[HapticGraph, IntArray], Propagation]
) -> Propagation:
    """The gains of a graph whose listeners may have volumes.

    The gain of a volume is the root of the mean of its points' squared gains; the root of the mean
    of their squared errors bounds its error. Path, delay and taps are those of its middle, or of
    the first point that has a path.

    Args:
        graph: the graph.
        propagated: computes gains of a graph in which each sample point is a listener; its second
            argument (p,) is the number of the listener that each point belongs to.
    """
    if graph.points is None:
        return propagated(graph, np.arange(len(graph.listeners)))
    size = np.array([len(points) for points in graph.points])
    number = np.arange(len(size)).repeat(size)
    begin = size.cumsum() - size
    nodes = np.array([node for points in graph.points for node in points], dtype=np.int64)
    names = tuple(graph.listeners[k] for k in number.tolist())
    result = propagated(replace(graph, listeners=names, listener_nodes=nodes, points=None), number)
    weight = np.concatenate([np.ones(1) if count == 1 else WEIGHTS for count in size.tolist()])

    def mean(values: FloatArray) -> FloatArray:
        """The root mean square (s, l, ...) over the points of each listener of values (s, points,
        ...); unchanged, not rounded, for a single point."""
        shape = (-1, *[1] * (values.ndim - 2))
        roots = np.sqrt(np.add.reduceat(weight.reshape(shape) * values**2, begin, axis=1))
        return np.where(size.reshape(shape) == 1, values[:, begin], roots)

    gain = mean(result.gain)
    point: dict[tuple[int, int], tuple[int, int]] = {}
    for row, column in sorted(result.best_path):
        point.setdefault((row, int(number[column])), (row, column))
    delay = None if result.delay is None else result.delay[:, begin]
    taps = {}
    for pair, other in point.items():
        if delay is not None and result.delay is not None:
            delay[pair] = result.delay[other]
            part = float(gain[pair] / result.gain[other]) if result.gain[other] > 0 else 0.0
            taps[pair] = tuple((late, part * tap) for late, tap in result.taps[other])
    return replace(
        result,
        gain=gain,
        error_bound=mean(result.error_bound),
        paths=np.maximum.reduceat(result.paths, begin, axis=1),
        limited=np.logical_or.reduceat(result.limited, begin, axis=1),
        silenced=result.silenced[:, begin],
        best_path={pair: result.best_path[other] for pair, other in point.items()},
        band_gain=None if result.band_gain is None else mean(result.band_gain),
        delay=delay,
        taps=taps,
        statistics={**result.statistics, "listeners": len(graph.listeners)},
    )
