"""Which strategy computes what, and the result of all sources put together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..graph.distance_only import distance_only
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Message
from ..scene.bands import BAND_COUNT
from ..scene.values import Mode, Settings, SourceKind, Strategy
from .best_path import BestPaths, best_paths, crossings_of, gain_and_error
from .connections import ROUNDING, amplifying, path_bands, path_delay
from .delay_taps import delay_taps
from .energy_balance import energy_gains
from .exact.walk_bounds import LARGEST
from .modes import direct_gains, localised, nearest_listener
from .path_sums import PathSums, limited_sums, threshold_costs, unlimited_sums
from .result import Propagation

BUDGET = 1_000_000
"""Default work per source (partial paths, states and transitions looked at): about a second where all of it is needed."""


def strategy_of(kind: SourceKind, settings: Settings) -> Strategy:
    """The strategy of a source of this kind: the best path in mode SD; else the chosen one, with the two automatic ones resolved."""
    if settings.mode is Mode.SD or settings.strategy is Strategy.AUTO:
        return Strategy.BEST_PATH
    if settings.strategy is Strategy.AS_IN_THE_PAPER:
        return Strategy.ALL_PATHS if kind is SourceKind.PERSISTENT else Strategy.BEST_PATH
    return settings.strategy


def most_connections(settings: Settings) -> int | None:
    """The limit of connections on a path; `Strategy.AUTO` has none."""
    return None if settings.strategy is Strategy.AUTO else settings.max_connections


def propagate(graph: HapticGraph, settings: Settings, budget: int = BUDGET, sounding_only: bool = False) -> Propagation:
    """Gains from every source to every listener of the graph.

    ``budget`` bounds the work where an exact result is out of reach, by count and not by time: the result is the same on every machine.
    ``sounding_only``: no path is searched for sources whose amplitude is 0; their gains are 0.
    Raises ValueError that names the argument for a negative budget, and the object where an expression gives no gain.
    """
    if budget < 0:
        raise ValueError(f"budget: must be 0 or more, got {budget!r}")
    strategies = tuple(strategy_of(source.kind, settings) for source in graph.sources)
    if settings.mode in (Mode.MD, Mode.MN):
        return _direct(graph, settings, strategies)
    wanted = np.ones((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
    if sounding_only:
        wanted[[source.amplitude == 0 for source in graph.sources]] = False
    if settings.mode is Mode.SD:
        graph, wanted = distance_only(graph), wanted & nearest_listener(graph)
    elif settings.localise > 0:
        nearest = nearest_listener(graph)
        wanted = wanted & nearest if settings.localise == 1 else wanted
        return localised(_Run(graph, settings, strategies, wanted, budget).result(), nearest, settings.localise)
    return _Run(graph, settings, strategies, wanted, budget).result()


@dataclass(frozen=True, slots=True)
class _Run:
    graph: HapticGraph
    settings: Settings
    strategies: tuple[Strategy, ...]
    wanted: BoolArray
    budget: int

    def result(self) -> Propagation:
        graph, settings = self.graph, self.settings
        rows = [row for row, strategy in enumerate(self.strategies) if strategy is Strategy.ALL_PATHS and self.wanted[row].any()]
        amplified = amplifying(graph)
        known = None
        if rows and settings.threshold > 0 and not amplified:
            known = threshold_costs(graph, [graph.sources[row].nodes for row in rows], settings.threshold)
        best = best_paths(
            graph,
            [(int(row), int(column)) for row, column in np.argwhere(self.wanted)],
            most_connections(settings),
            settings.threshold,
            self.budget,
            amplified,
            {} if known is None else {row: (known.forward, number) for number, row in enumerate(rows)},
        )
        gain, error = np.zeros(self.wanted.shape), np.zeros(self.wanted.shape)
        paths = np.zeros(self.wanted.shape, dtype=np.int64)
        bands = np.zeros((*self.wanted.shape, BAND_COUNT)) if graph.uses_bands else None
        for pair in best.nodes.keys() | best.bound.keys():
            if self.strategies[pair[0]] is Strategy.BEST_PATH:
                gain[pair], error[pair] = gain_and_error(best.cost.get(pair), best.bound.get(pair))
                paths[pair] = pair in best.nodes
                if bands is not None and pair in best.nodes:
                    bands[pair] = gain[pair] * path_bands(graph, best.nodes[pair])
        work = 0
        crossings = crossings_of(most_connections(settings))
        for number, row in enumerate(rows if crossings >= 0 else ()):
            columns = np.flatnonzero(self.wanted[row])
            ends = graph.sources[row].nodes, graph.listener_nodes[columns].tolist()
            sums: PathSums
            with np.errstate(over="ignore"):  # gains above 1 may multiply to more than a number can say: such a sum has no bound
                if settings.threshold > 0:
                    sums = limited_sums(graph, *ends, crossings, settings.threshold, self.budget, known, number)
                else:
                    sums = unlimited_sums(graph, *ends, crossings, settings.tolerance, self.budget)
            gain[row, columns], error[row, columns], paths[row, columns] = sums.gain[:, 0], sums.error, sums.paths
            if bands is not None:
                bands[row, columns] = sums.gain[:, 1:]
            work += sums.work
        energies = energy_gains(graph) if Strategy.ENERGY_BALANCE in self.strategies else None
        for row, strategy in enumerate(self.strategies):
            if energies is not None and strategy is Strategy.ENERGY_BALANCE:
                columns = np.flatnonzero(self.wanted[row])
                gain[row, columns], error[row, columns] = energies.gain[row, columns], energies.error[row, columns]
                paths[row, columns] = -1
                if bands is not None and energies.bands is not None:
                    bands[row, columns] = energies.bands[row, columns]
        return Propagation(
            gain=gain,
            error_bound=error,
            paths=paths,
            best_path=best.nodes,
            strategy=tuple(str(s) for s in self.strategies),
            band_gain=bands,
            delay=_delays(graph, self.wanted.shape, best),
            taps=self._taps(best, gain, amplified) if graph.uses_delays else {},
            warnings=self._warnings(amplified, best, gain, error),
            statistics={
                **statistics_of(graph),
                "nodes_visited": best.visited,
                "connections_relaxed": best.relaxed,
                "paths_searched": best.searched,
                "states": work,
            },
        )

    def _warnings(self, amplified: bool, best: BestPaths, gain: FloatArray, error: FloatArray) -> tuple[Message, ...]:
        warnings = []
        if amplified:
            warnings.append(Message.of(Cause.AMPLIFICATION))
        if best.bound:
            warnings.append(Message.of(Cause.PATH_BUDGET))
        if not error.any() and not np.any(gain >= LARGEST):
            return tuple(warnings)
        summed = [row for row, strategy in enumerate(self.strategies) if strategy is Strategy.ALL_PATHS]
        uncertain = error[summed] > self.settings.tolerance * gain[summed] * (1 + ROUNDING)
        if np.any(error[summed] >= LARGEST):
            warnings.append(Message.of(Cause.SUM_DIVERGES))
        elif np.any(uncertain & (error[summed] > 1e-6)):
            warnings.append(Message.of(Cause.SUM_BUDGET))
        if np.any(gain >= LARGEST):
            warnings.append(Message.of(Cause.GAIN_OVERFLOW))
        return tuple(warnings)

    def _taps(self, best: BestPaths, gain: FloatArray, amplified: bool) -> dict[tuple[int, int], tuple[tuple[float, float], ...]]:
        """Of a sum over paths its strongest ones, else the best path with all of the gain."""
        taps = {}
        crossings = crossings_of(most_connections(self.settings))
        for pair, nodes in best.nodes.items():
            if self.strategies[pair[0]] is Strategy.ALL_PATHS:
                taps[pair] = delay_taps(self.graph, *pair, crossings, self.settings.threshold, amplified)
            else:
                taps[pair] = ((path_delay(self.graph, nodes), float(gain[pair])),)
        return taps


def _delays(graph: HapticGraph, shape: tuple[int, ...], best: BestPaths) -> FloatArray | None:
    if not graph.uses_delays:
        return None
    delay = np.zeros(shape)
    for pair, nodes in best.nodes.items():
        delay[pair] = path_delay(graph, nodes)
    return delay


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
