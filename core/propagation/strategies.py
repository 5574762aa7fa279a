"""Dispatch of sources to strategies, and the combined result."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..graph.distance_only import distance_only
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Message
from ..scene.bands import BAND_COUNT
from ..scene.choices import Mode, SourceKind, Strategy
from ..scene.values import Settings
from .best_path import BestPaths, best_paths, crossings_of, gain_and_error, most_connections
from .connections import (
    LARGEST,
    ROUNDING,
    SLACK,
    amplifying,
    bounded_exp,
    cost_limit,
    joined,
    lanes_of,
    path_delay,
)
from .energy_balance import energy_gains
from .exact import PathLimits, bounded_sums
from .mean_power import over_volumes
from .modes import direct_gains, localised, nearest_listener
from .result import Propagation
from .shortest_paths import ShortestPaths, shortest_paths
from .strongest_paths import delay_taps
from .walk_radius import WalkOperator, WalkRadius

BUDGET = 1_000_000
"""Default work per source (partial paths, states and transitions): about a second if used up."""


def strategy_of(kind: SourceKind, settings: Settings) -> Strategy:
    """The strategy of a source of this kind: the best path in mode SD; otherwise the chosen one,
    with the two automatic ones resolved."""
    if settings.mode is Mode.SD or settings.strategy is Strategy.AUTO:
        return Strategy.BEST_PATH
    if settings.strategy is Strategy.AS_IN_THE_PAPER:
        return Strategy.ALL_PATHS if kind is SourceKind.PERSISTENT else Strategy.BEST_PATH
    return settings.strategy


def propagate(
    graph: HapticGraph, settings: Settings, budget: int = BUDGET, sounding_only: bool = False
) -> Propagation:
    """Gains from every source to every listener of the graph.

    Args:
        graph: the haptic graph.
        settings: mode, strategy and limits.
        budget: bound on the work if an exact result is infeasible; counted in operations, so that
            the result is the same on every machine.
        sounding_only: leave out sources of amplitude 0; their gains are 0.

    Raises:
        ValueError: for a negative budget, or if an expression gives no valid gain, with the name of
            the object.
    """
    if budget < 0:
        raise ValueError(f"budget: must be 0 or more, got {budget!r}")
    strategies = tuple(strategy_of(source.kind, settings) for source in graph.sources)
    if settings.mode in (Mode.MD, Mode.MN):
        return over_volumes(graph, lambda points, _: _direct(points, settings, strategies))
    wanted = np.ones((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
    if sounding_only:
        wanted[[source.amplitude == 0 for source in graph.sources]] = False
    if settings.mode is Mode.SD:
        graph, wanted = distance_only(graph), wanted & nearest_listener(graph)
    elif settings.localise == 1:
        wanted &= nearest_listener(graph)
    result = over_volumes(
        graph,
        lambda points, number: _Propagator(
            points, settings, strategies, wanted[:, number], budget
        ).result(),
    )
    if settings.mode is Mode.HT and 0 < settings.localise < 1:
        return localised(result, nearest_listener(graph), settings.localise)
    return result


@dataclass(slots=True)
class _Sums:
    """Further results of sums over paths. ``uncertain``: whether the budget was insufficient for
    some sum."""

    radius: WalkRadius | None = None
    uncertain: bool = False
    diverges: bool = False
    work: int = 0


class _Propagator:
    """Computes the gains of one graph. Its arrays are those of the `Propagation`, filled strategy
    by strategy.

    Args:
        graph: the graph.
        settings: limits, threshold and tolerance.
        strategies: of each source.
        wanted: pairs to be computed (s, l).
        budget: as of `propagate`.
    """

    def __init__(
        self,
        graph: HapticGraph,
        settings: Settings,
        strategies: tuple[Strategy, ...],
        wanted: BoolArray,
        budget: int,
    ) -> None:
        self.graph, self.settings, self.strategies = graph, settings, strategies
        self.wanted, self.budget, shape = wanted, budget, wanted.shape
        self.gain, self.error = np.zeros((2, *shape))
        self.best_gain = np.zeros((*shape, lanes_of(graph)))  # plain gain, and those of the bands
        self.paths = np.zeros(shape, dtype=np.int64)
        self.limited = np.zeros(shape, dtype=np.bool_)
        self.bands = np.zeros((*shape, BAND_COUNT)) if graph.uses_bands else None

    def result(self) -> Propagation:
        graph = self.graph
        amplified = amplifying(graph)
        rows = [
            row
            for row, strategy in enumerate(self.strategies)
            if strategy is Strategy.ALL_PATHS and self.wanted[row].any()
        ]
        trees: dict[int, tuple[ShortestPaths, int]] = {}
        costs: dict[int, tuple[FloatArray, FloatArray]] = {}
        if rows and self.settings.threshold > 0 and not amplified:
            # From each source, and from all listeners together.
            ends = [*(graph.sources[row].nodes for row in rows), graph.listener_nodes.tolist()]
            limit = np.full(len(ends), cost_limit(self.settings.threshold) + SLACK)
            found = shortest_paths(graph, ends, limit, complete=True)
            forward = ShortestPaths(found.cost[:-1], found.entry[:-1], found.relaxed)
            trees = {row: (forward, number) for number, row in enumerate(rows)}
            costs = {row: (forward.cost[number], found.cost[-1]) for number, row in enumerate(rows)}
        best = self._best_paths(amplified, trees)
        sums = self._sum_over_paths(costs, rows)
        self._balance_energy()
        delays = graph.uses_delays
        return Propagation(
            gain=self.gain,
            error_bound=np.where((self.error >= LARGEST) | ~self.wanted, math.inf, self.error),
            paths=self.paths,
            limited=self.limited,
            silenced=~self.wanted,
            best_path=best.nodes,
            strategy=tuple(str(strategy) for strategy in self.strategies),
            band_gain=self.bands,
            delay=_delays(graph, self.wanted.shape, best) if delays else None,
            taps=self._taps(best, amplified) if delays else {},
            warnings=self._warnings(amplified, best, sums, rows),
            statistics={
                **statistics_of(graph),
                "nodes_visited": best.visited,
                "connections_relaxed": best.relaxed,
                "paths_searched": best.searched,
                "states": sums.work,
                **({} if sums.radius is None else {"walk_radius": sums.radius.value}),
            },
        )

    def _best_paths(
        self, amplified: bool, trees: dict[int, tuple[ShortestPaths, int]]
    ) -> BestPaths:
        """Best paths of all wanted pairs; sets the gains of sources with that strategy. ``trees``:
        shortest paths that are known, and the row in them, by row of the source."""
        graph = self.graph
        by_band = graph.uses_bands and not amplified
        best = best_paths(
            graph,
            np.array(self.wanted.nonzero()).T,
            most_connections(self.settings),
            self.settings.threshold,
            self.budget,
            amplified,
            trees,
            {
                row: graph.sources[row].band
                for row, s in enumerate(self.strategies)
                if by_band and s is Strategy.BEST_PATH
            },
        )
        chosen = np.array(
            [strategy is Strategy.BEST_PATH for strategy in self.strategies], dtype=np.bool_
        )
        pairs = np.array(list(best.nodes), dtype=np.int64).reshape(-1, 2)
        mine = chosen[pairs[:, 0]]
        gains = np.array([bounded_exp(-cost) for cost in best.cost.values()]).reshape(-1, 1)
        if best.bands is not None:
            gains = np.concatenate([gains, gains * best.bands], axis=1)
        self.best_gain[tuple(pairs.T)] = gains
        places = tuple(pairs[mine].T)
        self.gain[places] = gains[mine, 0]
        self.paths[places] = 1
        self.error[self.gain >= LARGEST] = LARGEST
        if self.bands is not None and best.bands is not None:
            self.bands[places] = gains[mine, 1:]
        for pair, bound in best.bound.items():
            if chosen[pair[0]]:
                self.gain[pair], self.error[pair] = gain_and_error(best.cost.get(pair), bound)
        if best.cut:
            cut = np.array(list(best.cut))
            mine = chosen[cut[:, 0]]
            places = tuple(cut[mine].T)
            self.error[places] = np.maximum(
                self.error[places], np.array(list(best.cut.values()))[mine]
            )
            self.limited[places] = True
        return best

    def _sum_over_paths(
        self, costs: dict[int, tuple[FloatArray, FloatArray]], rows: list[int]
    ) -> _Sums:
        """Set the gains of the sources in ``rows``, whose strategy is all paths. ``costs``: least
        ones up to the threshold, as in `bounded_sums`, by row of the source."""
        graph, settings = self.graph, self.settings
        sums = _Sums()
        crossings = crossings_of(most_connections(settings))
        if not rows:
            return sums
        pairs = np.argwhere(self.wanted)
        pairs = pairs[joined(graph, pairs)]
        if crossings < 0:  # no connection is allowed
            cut = tuple(pairs[np.isin(pairs[:, 0], rows)].T)
            self.limited[cut], self.error[cut] = True, math.inf
            return sums
        limits = PathLimits(crossings, settings.threshold, settings.tolerance, self.budget)
        # Products may overflow or underflow; then the sum has no bound.
        with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
            operator = WalkOperator(graph)
            sums.radius = operator.radius
            for row in rows:
                columns = pairs[pairs[:, 0] == row, 1]
                if len(columns) == 0:
                    continue
                found = bounded_sums(
                    graph,
                    operator,
                    graph.sources[row].nodes,
                    graph.listener_nodes[columns].tolist(),
                    limits,
                    costs.get(row),
                    self.best_gain[row, columns],
                )
                self.gain[row, columns] = found.gain[:, 0]
                self.error[row, columns] = found.error
                self.paths[row, columns], self.limited[row, columns] = found.paths, found.limited
                if self.bands is not None:
                    self.bands[row, columns] = found.gain[:, 1:]
                sums.uncertain |= bool(found.uncertain.any())
                sums.diverges |= bool(np.any(np.isinf(found.error) & ~found.limited))
                sums.work += found.work
        return sums

    def _balance_energy(self) -> None:
        """Set the gains of sources whose strategy is the energy balance."""
        if Strategy.ENERGY_BALANCE not in self.strategies:
            return
        balanced = (
            self.wanted
            & np.array([strategy is Strategy.ENERGY_BALANCE for strategy in self.strategies])[
                :, None
            ]
        )
        energies = energy_gains(self.graph, balanced)
        self.gain[balanced] = energies.gain[balanced]
        self.error[balanced] = energies.error[balanced]
        self.paths[balanced] = -1
        if self.bands is not None and energies.bands is not None:
            self.bands[balanced] = energies.bands[balanced]

    def _warnings(
        self, amplified: bool, best: BestPaths, sums: _Sums, rows: list[int]
    ) -> tuple[Message, ...]:
        warnings = []
        if amplified:
            warnings.append(Message.of(Cause.AMPLIFICATION))
        if best.bound:
            warnings.append(Message.of(Cause.PATH_BUDGET))
        limited = [row for row in rows if self.limited[row].any()]
        if limited and sums.radius is not None:
            warnings.append(self._limited_message(limited[0], sums.radius))
        if sums.diverges:
            warnings.append(Message.of(Cause.SUM_DIVERGES))
        elif sums.uncertain:
            warnings.append(Message.of(Cause.SUM_BUDGET))
        if (self.gain >= LARGEST).any():
            warnings.append(Message.of(Cause.GAIN_OVERFLOW))
        warnings += _unknown_force(self.graph)
        return tuple(warnings)

    def _limited_message(self, row: int, radius: WalkRadius) -> Message:
        """Message that the limits determine a sum from source number ``row``."""
        source = self.graph.sources[row].name
        if not radius.well_posed:
            cause = (
                Cause.SUM_SET_BY_THRESHOLD
                if self.settings.threshold > 0
                else Cause.SUM_SET_BY_CONNECTIONS
            )
            return Message.of(cause, source=source, radius=f"{radius.low:.2f}")
        return Message.of(Cause.SUM_TRUNCATED, source=source)

    def _taps(
        self, best: BestPaths, amplified: bool
    ) -> dict[tuple[int, int], tuple[tuple[float, float], ...]]:
        """The strongest paths of a sum over paths; otherwise the best path with the whole gain."""
        taps = {}
        crossings = crossings_of(most_connections(self.settings))
        for pair, nodes in best.nodes.items():
            if self.strategies[pair[0]] is Strategy.ALL_PATHS:
                taps[pair] = delay_taps(
                    self.graph, *pair, crossings, self.settings.threshold, amplified
                )
            else:
                taps[pair] = ((path_delay(self.graph, nodes), float(self.gain[pair])),)
        return taps


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


def _delays(graph: HapticGraph, shape: tuple[int, ...], best: BestPaths) -> FloatArray:
    delay = np.zeros(shape)
    for pair, nodes in best.nodes.items():
        delay[pair] = path_delay(graph, nodes)
    return delay


def _direct(
    graph: HapticGraph, settings: Settings, strategies: tuple[Strategy, ...]
) -> Propagation:
    """One straight connection per pair."""
    gain = direct_gains(graph, settings.mode is Mode.MD)
    kept = (gain >= settings.threshold * (1 - ROUNDING)) & (
        settings.max_connections is None or settings.max_connections >= 1
    )
    return Propagation(
        gain=np.where(kept, gain, 0.0),
        error_bound=np.where(kept, 0.0, gain),
        paths=kept.astype(np.int64),
        limited=~kept,
        silenced=np.zeros(gain.shape, dtype=np.bool_),
        best_path={
            (int(row), int(column)): (
                graph.sources[row].nodes[0],
                int(graph.listener_nodes[column]),
            )
            for row, column in np.argwhere(kept)
        },
        strategy=tuple(str(strategy) for strategy in strategies),
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
