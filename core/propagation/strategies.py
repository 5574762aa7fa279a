"""Which strategy computes what, and the result of all sources put together."""

from __future__ import annotations

import math

import numpy as np

from ..graph import HapticGraph
from ..scene import Mode, Settings, SourceKind, Strategy
from .all_paths import enumerate_paths
from .best_path import ROUNDING, path_gain, path_tree
from .energy_balance import energy_gains
from .modes import cost_limit, direct_gains, distance_only, nearest_listener
from .result import Propagation


def strategy_of(kind: SourceKind, settings: Settings) -> Strategy:
    """`AUTO` is all paths for persistent sources and the best path for temporary ones, as in the paper."""
    if settings.strategy is not Strategy.AUTO:
        return settings.strategy
    return Strategy.ALL_PATHS if kind is SourceKind.PERSISTENT else Strategy.BEST_PATH


def propagate(graph: HapticGraph, settings: Settings) -> Propagation:
    """Gains from every source to every listener of the graph."""
    shape = len(graph.sources), len(graph.listeners)
    gain = np.zeros(shape)
    paths = np.zeros(shape, dtype=np.int64)
    best: dict[tuple[int, int], tuple[int, ...]] = {}
    strategies = tuple(strategy_of(source.kind, settings) for source in graph.sources)
    least = settings.threshold * (1 - ROUNDING)
    if settings.mode in (Mode.MD, Mode.MN):
        direct = direct_gains(graph, settings.mode is Mode.MD)
        kept = (direct >= least) & (settings.max_connections is None or settings.max_connections >= 1)
        gain, paths = np.where(kept, direct, 0.0), kept.astype(np.int64)
        best = {
            (int(row), int(column)): (graph.sources[row].nodes[0], int(graph.listener_nodes[column])) for row, column in np.argwhere(kept)
        }
    else:
        wanted = np.ones(shape, dtype=np.bool_)
        if settings.mode is Mode.SD:
            graph, wanted = distance_only(graph), nearest_listener(graph)
        balance = energy_gains(graph) if Strategy.ENERGY_BALANCE in strategies else None
        for row, source in enumerate(graph.sources):
            columns = np.flatnonzero(wanted[row]).tolist()
            trees = [path_tree(graph, node, cost_limit(settings.threshold) + 1e-9) for node in source.nodes]
            for column in columns:
                listener = int(graph.listener_nodes[column])
                candidates = [nodes for tree in trees if (nodes := tree.path(graph, listener))]
                limit = math.inf if settings.max_connections is None else settings.max_connections
                ranked = sorted((-path_gain(graph, nodes), nodes) for nodes in candidates if len(nodes) - 1 <= limit)
                if ranked and -ranked[0][0] >= least:
                    best[row, column] = ranked[0][1]
                    if strategies[row] is Strategy.BEST_PATH:
                        gain[row, column], paths[row, column] = -ranked[0][0], 1
            if strategies[row] is Strategy.ALL_PATHS:
                targets = [int(graph.listener_nodes[column]) for column in columns]
                gain[row, columns], paths[row, columns] = enumerate_paths(
                    graph, source.nodes, targets, settings.max_connections, settings.threshold
                )
            elif balance is not None:
                gain[row, columns], paths[row, columns] = balance[row, columns], -1
    return Propagation(gain, np.zeros(shape), paths, best, tuple(str(s) for s in strategies), statistics=statistics_of(graph))


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
