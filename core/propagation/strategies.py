"""Dispatch of sources to strategies, and the combined result."""

from __future__ import annotations

import numpy as np

from ..graph.distance_only import distance_only
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Message
from ..scene.bands import BAND_COUNT
from ..scene.choices import Mode, SourceKind, Strategy
from ..scene.values import Settings
from .best_path import Kept, best_paths
from .breadth_first import PathSums, sums_over_paths
from .modes import direct_gains, nearest_listener
from .paths import Paths
from .result import Propagation


def strategy_of(kind: SourceKind, settings: Settings) -> Strategy:
    """The strategy of a source of this kind: a sum over paths for persistent ones if all is to be
    as in the paper, except in mode SD; else the best path."""
    if (
        settings.strategy is Strategy.AS_IN_THE_PAPER
        and settings.mode is Mode.HT
        and kind is SourceKind.PERSISTENT
    ):
        return Strategy.AS_IN_THE_PAPER
    return Strategy.BEST_PATH


def propagate(
    graph: HapticGraph, settings: Settings, sounding_only: bool = False, kept: Kept | None = None
) -> Propagation:
    """Gains from every source to every listener of the graph.

    Args:
        graph: the haptic graph.
        settings: mode, strategy and limits.
        sounding_only: leave out sources of amplitude 0; their gains are 0.
        kept: the trees of an earlier graph, in whose place those of this one are put.

    Raises:
        ValueError: if an expression gives no valid gain, with the name of the object.
    """
    if settings.mode in (Mode.MD, Mode.MN):
        return _direct(graph, settings)
    shape = len(graph.sources), len(graph.listeners)
    wanted = np.ones(shape, dtype=np.bool_)
    if sounding_only:
        wanted[[source.amplitude == 0 for source in graph.sources]] = False
    if settings.mode is Mode.SD:
        graph, wanted = distance_only(graph), wanted & nearest_listener(graph)
    strategies = tuple(strategy_of(source.kind, settings) for source in graph.sources)
    sums = {
        row: sums_over_paths(
            graph, graph.sources[row].nodes, settings.max_connections, settings.threshold
        )
        for row, strategy in enumerate(strategies)
        if strategy is Strategy.AS_IN_THE_PAPER and wanted[row].any()
    }
    led = wanted.copy()
    for row, found in sums.items():
        led[row] &= found.paths > 0
    best = best_paths(graph, led, kept=kept)
    places = tuple(best.paths.pairs.T)
    cost, band_cost, late = best.paths.sums(graph)
    gain = np.zeros(shape)
    gain[places] = np.exp(-cost)
    paths = np.zeros(shape, dtype=np.int64)
    paths[places] = 1
    limited = np.zeros(shape, dtype=np.bool_)
    bands = delay = None
    if band_cost is not None:
        bands = np.zeros((*shape, BAND_COUNT))
        band_cost += cost[:, None]
        bands[places] = np.exp(np.negative(band_cost, out=band_cost), out=band_cost)
    if late is not None:
        delay = np.zeros(shape)
        delay[places] = late
    for row, found in sums.items():
        gain[row], paths[row], limited[row] = found.gain[:, 0], found.paths, found.limited
        if bands is not None:
            bands[row] = found.gain[:, 1:]
    return Propagation(
        gain=gain,
        paths=paths,
        limited=limited,
        silenced=~wanted,
        best_path=best.paths,
        strategy=tuple(map(str, strategies)),
        band_gain=bands,
        delay=delay,
        warnings=(*_ended(graph, sums), *_unknown_force(graph)),
        statistics={
            **statistics_of(graph),
            "nodes_visited": best.visited,
            "connections_examined": best.examined,
        },
    )


def _ended(graph: HapticGraph, sums: dict[int, PathSums]) -> list[Message]:
    """Warning about the first source whose sum the budget has ended."""
    names = [graph.sources[row].name for row, found in sums.items() if found.ended]
    return [Message.of(Cause.SUM_BUDGET, name, source=name) for name in names[:1]]


def _unknown_force(graph: HapticGraph) -> list[Message]:
    """Warning about the first contact whose function uses a force that is unknown."""
    unknown = [] if graph.forces is None else np.flatnonzero(np.isnan(graph.forces)).tolist()
    if not unknown:
        return []
    first, second = (
        graph.table.names[int(graph.node_object[node])]
        for node in np.flatnonzero(graph.contact == unknown[0])[:2]
    )
    return [Message.of(Cause.FORCE_UNKNOWN, first, first=first, second=second, count=len(unknown))]


def _direct(graph: HapticGraph, settings: Settings) -> Propagation:
    """One straight connection per pair."""
    gain = direct_gains(graph, settings.mode is Mode.MD)
    pairs = np.argwhere(gain > 0)
    row, column = pairs.T
    first = np.array([source.nodes[0] for source in graph.sources], dtype=np.int64)
    nodes = np.column_stack([first[row], graph.listener_nodes[column]]).reshape(-1)
    return Propagation(
        gain=gain,
        paths=(gain > 0).astype(np.int64),
        limited=np.zeros(gain.shape, dtype=np.bool_),
        silenced=np.zeros(gain.shape, dtype=np.bool_),
        best_path=Paths(pairs, nodes, 2 * np.arange(1, len(pairs) + 1)),
        strategy=(str(Strategy.BEST_PATH),) * len(graph.sources),
        statistics=statistics_of(graph),
    )


def statistics_of(graph: HapticGraph) -> dict[str, int | float]:
    """Counts of the graph."""
    return {
        "objects": len(graph.table.names),
        "contacts": graph.contact_count,
        "nodes": graph.node_count,
        "intra_connections": graph.intra_connection_count(),
        "sources": len(graph.sources),
        "listeners": len(graph.listeners),
    }
