"""Which strategy computes what, and the result of all sources put together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..bands import BAND_COUNT
from ..graph import HapticGraph
from ..scene import Mode, Settings, SourceKind, Strategy
from .all_paths import path_sums
from .best_path import BestPaths, best_paths, crossings_of, gain_and_error
from .connections import ROUNDING, path_bands, path_delay
from .energy_balance import energy_gains
from .modes import direct_gains, distance_only, nearest_listener
from .result import Propagation

FloatArray = NDArray[np.float64]

BUDGET = 1_000_000
"""Default work per source (partial paths and states looked at): about a second on a slow machine where all of it is needed."""


def strategy_of(kind: SourceKind, settings: Settings) -> Strategy:
    """`AUTO` is all paths for persistent sources and the best path for temporary ones, as in the paper."""
    if settings.strategy is not Strategy.AUTO:
        return settings.strategy
    return Strategy.ALL_PATHS if kind is SourceKind.PERSISTENT else Strategy.BEST_PATH


def propagate(graph: HapticGraph, settings: Settings, budget: int = BUDGET) -> Propagation:
    """Gains from every source to every listener of the graph.

    ``budget`` bounds the work where an exact result is out of reach, by count and not by time: the result is the same on every machine.
    Raises ValueError that names the argument for a negative budget, and the object where an expression gives no gain.
    """
    if budget < 0:
        raise ValueError(f"budget: must be 0 or more, got {budget!r}")
    strategies = tuple(strategy_of(source.kind, settings) for source in graph.sources)
    if settings.mode in (Mode.MD, Mode.MN):
        return _direct(graph, settings, strategies)
    if settings.mode is Mode.SD:
        graph = distance_only(graph)
        wanted = nearest_listener(graph)
    else:
        wanted = np.ones((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
    pairs = [(int(row), int(column)) for row, column in np.argwhere(wanted)]
    best = best_paths(graph, pairs, settings.max_connections, settings.threshold, budget)
    return _gather(graph, settings, strategies, wanted, best, budget)


def _gather(
    graph: HapticGraph, settings: Settings, strategies: tuple[Strategy, ...], wanted: NDArray[np.bool_], best: BestPaths, budget: int
) -> Propagation:
    gain, error = np.zeros(wanted.shape), np.zeros(wanted.shape)
    paths = np.zeros(wanted.shape, dtype=np.int64)
    bands = np.zeros((*wanted.shape, BAND_COUNT)) if graph.uses_bands else None
    work = 0
    for pair in best.nodes.keys() | best.bound.keys():
        if strategies[pair[0]] is Strategy.BEST_PATH:
            gain[pair], error[pair] = gain_and_error(best.cost.get(pair), best.bound.get(pair))
            paths[pair] = pair in best.nodes
            if bands is not None and pair in best.nodes:
                bands[pair] = gain[pair] * path_bands(graph, best.nodes[pair])
    balance = energy_gains(graph) if Strategy.ENERGY_BALANCE in strategies else np.zeros(wanted.shape)
    for row, strategy in enumerate(strategies):
        columns = np.flatnonzero(wanted[row])
        if strategy is Strategy.ALL_PATHS:
            targets = graph.listener_nodes[columns].tolist()
            crossings = crossings_of(settings.max_connections)
            sums = path_sums(graph, graph.sources[row].nodes, targets, crossings, settings.threshold, settings.tolerance, budget)
            gain[row, columns], error[row, columns], paths[row, columns] = sums.gain[:, 0], sums.error, sums.paths
            work += sums.work
            if bands is not None:
                bands[row, columns] = sums.gain[:, 1:]
        elif strategy is Strategy.ENERGY_BALANCE:
            gain[row, columns], paths[row, columns] = balance[row, columns], -1
    return Propagation(
        gain=gain,
        error_bound=error,
        paths=paths,
        best_path=best.nodes,
        strategy=tuple(str(s) for s in strategies),
        band_gain=bands,
        delay=_delays(graph, wanted.shape, best),
        warnings=_warnings(best),
        statistics={**statistics_of(graph), "connections_relaxed": best.relaxed, "paths_searched": best.searched, "states": work},
    )


def _delays(graph: HapticGraph, shape: tuple[int, ...], best: BestPaths) -> FloatArray | None:
    if not graph.uses_delays:
        return None
    delay = np.zeros(shape)
    for pair, nodes in best.nodes.items():
        delay[pair] = path_delay(graph, nodes)
    return delay


def _warnings(best: BestPaths) -> tuple[str, ...]:
    warnings = []
    if best.amplified:
        warnings.append("some gains are above 1: paths were searched by their number of connections")
    if best.bound:
        warnings.append("the budget was spent before it was certain that the best paths are the best: see error_bound")
    return tuple(warnings)


def _direct(graph: HapticGraph, settings: Settings, strategies: tuple[Strategy, ...]) -> Propagation:
    """One straight connection per pair."""
    gain = direct_gains(graph, settings.mode is Mode.MD)
    kept = (gain >= settings.threshold * (1 - ROUNDING)) & (settings.max_connections is None or settings.max_connections >= 1)
    return Propagation(
        gain=np.where(kept, gain, 0.0),
        error_bound=np.zeros(gain.shape),
        paths=kept.astype(np.int64),
        best_path={
            (int(row), int(column)): (graph.sources[row].nodes[0], int(graph.listener_nodes[column])) for row, column in np.argwhere(kept)
        },
        strategy=tuple(str(s) for s in strategies),
        statistics=statistics_of(graph),
    )


def statistics_of(graph: HapticGraph) -> dict[str, int | float]:
    """Counts of what there is."""
    return {
        "objects": len(graph.table.names),
        "contacts": graph.contact_count,
        "nodes": graph.node_count,
        "intra_connections": graph.intra_connection_count(),
        "sources": len(graph.sources),
        "listeners": len(graph.listeners),
    }
