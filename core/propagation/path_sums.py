"""`all_paths`: the sum of the products of gains over all paths from a source to its listeners.

With a threshold, whether a path counts depends on its own gain, so paths are searched one by one, as arrays, with everything left out that
can't meet the threshold (`path_search`). Without one, the sum is taken apart at the bridges (`pieces`), and inside a component it is found
without enumeration (`piece_sums`). What is found is exact, or an interval: a lower bound that was summed, and a bound of the rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..graph.contact_patches import contact_patches
from ..graph.haptic_graph import HapticGraph, distances
from ..scene.bands import BAND_COUNT
from .best_path import bounded_exp
from .connections import cost_limit, path_bands, path_costs
from .exact.bridge_decomposition import Component, decompose, is_forest
from .exact.component_sums import ROUNDING, ComponentSum
from .exact.path_search import ArcRanking, Limits, search
from .exact.search_graph import band_factors, build_search_graph
from .exact.walk_bounds import LARGEST, WalkBounds
from .hop_constrained import hop_constrained_paths
from .shortest_paths import ShortestPaths, shortest_paths

SLACK = 1e-9
"""ShortestPaths are rounded, so what they leave out is a little beyond the limit; the search then judges exactly."""

HOPS = 64
"""Contacts up to which walks are examined where gains exceed 1, to leave out what no path reaches above the threshold; and the length from
which on a limit of contacts does not matter to a forest."""


@dataclass(slots=True)
class PathSums:
    """``gain`` (l, lanes) of each listener: the plain gain, then that of each band where bands are used; the true plain gain lies in
    ``[gain, gain + error]``. ``paths`` (l,) how many were summed, -1 where they were not counted. ``work`` states looked at."""

    gain: FloatArray
    error: FloatArray
    paths: IntArray
    work: int


@dataclass(frozen=True, slots=True)
class ThresholdCosts:
    """What meets a threshold: ``forward`` labels of each source (a row), ``behind`` (n,) cost from entering at a node to a listener."""

    forward: ShortestPaths
    behind: FloatArray


def threshold_costs(graph: HapticGraph, sources: Sequence[Sequence[int]], threshold: float) -> ThresholdCosts:
    """ShortestPaths of the nodes of each source and of all listeners together, up to the threshold. No gain may exceed 1."""
    limit = cost_limit(threshold) + SLACK
    trees = shortest_paths(graph, [*sources, graph.listener_nodes.tolist()], np.full(len(sources) + 1, limit), complete=True)
    return ThresholdCosts(ShortestPaths(trees.cost[:-1], trees.entry[:-1], trees.relaxed), trees.cost[-1])


def limited_sums(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    crossings: float,
    threshold: float,
    budget: int,
    known: ThresholdCosts | None,
    row: int,
) -> PathSums:
    """Sum over the paths from the nodes ``roots`` of a source to each of the nodes ``listeners`` whose gain stays at the threshold or
    above, over at most ``crossings`` contacts: exact unless there are more than the budget allows. ``known`` and its row of this source;
    None where some gain exceeds 1, so that all that can be said is whether the threshold is met so far."""
    limit = cost_limit(threshold) + SLACK
    if known is None:
        most = int(min(crossings, graph.contact_count))
        reached = hop_constrained_paths(graph, roots, limit, min(most, HOPS), complete=True)
        certain = reached.complete or most <= HOPS
        arrival = reached.costs(graph.node_count)[-1] if certain else np.zeros(graph.node_count)
        behind = np.zeros(graph.node_count)
    else:
        arrival, behind = known.forward.cost[row], known.behind
    crossing = np.append(graph.transmission_loss, math.inf)[graph.contact]
    before = arrival[graph.partner] + crossing
    before[list(roots)] = 0.0
    entries = np.flatnonzero((graph.partner >= 0) & (before + behind <= limit))
    patch = contact_patches(graph)
    single = known is not None and len(roots) == 1 and bool(np.all(graph.share == 1))
    if known is not None and single and crossings > HOPS and is_forest(graph, entries, patch):
        return _only_paths(graph, listeners, known.forward, row, limit)
    search_graph = build_search_graph(graph, entries, roots, listeners, patch, (before, behind, limit))
    ahead = np.full(len(search_graph.nodes), math.inf) if known is None else np.exp(-behind[search_graph.nodes])
    limits = Limits(crossings, threshold, ahead, 0.0, np.zeros(len(listeners)), max(1, budget // 4), budget)
    starts = np.ones((len(roots), search_graph.lanes))
    found = search(search_graph, starts, limits, WalkBounds(search_graph, crossings), False, ArcRanking.of(search_graph, ahead))
    sums = np.minimum(found.sums.sum(axis=0), LARGEST)
    return PathSums(sums, np.minimum(found.missing * (1 + ROUNDING), LARGEST), found.paths, found.work)


def _only_paths(graph: HapticGraph, listeners: Sequence[int], forward: ShortestPaths, row: int, limit: float) -> PathSums:
    """Without a cycle, and without patches of several points, there is one path to each listener, the best one."""
    sums = PathSums(np.zeros((len(listeners), lanes_of(graph))), np.zeros(len(listeners)), np.zeros(len(listeners), dtype=np.int64), 0)
    paths = {number: path for number, node in enumerate(listeners) if (path := forward.path(graph, row, node))}
    for (number, path), cost in zip(paths.items(), path_costs(graph, list(paths.values())), strict=True):
        if cost <= limit - SLACK:
            sums.gain[number] = math.exp(-cost)
            sums.paths[number] = 1
            if graph.uses_bands:
                sums.gain[number, 1:] *= path_bands(graph, path)
    return sums


def unlimited_sums(
    graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int], crossings: float, tolerance: float, budget: int
) -> PathSums:
    """Sum over all paths from the nodes ``roots`` of a source to each of the nodes ``listeners``, over at most ``crossings`` contacts,
    exact or to the ``tolerance`` unless that takes more than the budget allows."""
    sums = PathSums(np.zeros((len(listeners), lanes_of(graph))), np.zeros(len(listeners)), np.full(len(listeners), -1), 0)
    for root in roots:
        _Unlimited(graph, root, listeners, crossings, tolerance, budget, sums).run()
    sums.error[sums.gain[:, 0] >= LARGEST] = LARGEST
    np.minimum(sums.gain, LARGEST, out=sums.gain)
    return sums


def lanes_of(graph: HapticGraph) -> int:
    """1, or 1 and one per band where bands are used."""
    return 1 + BAND_COUNT if graph.uses_bands else 1


@dataclass(slots=True)
class _Amplitude:
    """What arrives at a node: ``value`` (k, lanes) by the number of contacts crossed, times ``exp(-cost)``; ``cost`` in two parts that
    add up to it (a long chain would lose digits in one); ``excess`` bounds how much more it may be, relative to exp(-cost), infinite where
    nothing bounds it."""

    value: FloatArray
    cost: float
    rest: float
    excess: float

    def further(self, cost: float) -> _Amplitude:
        total = self.cost + cost
        back = total - self.cost
        return _Amplitude(self.value, total, self.rest + ((self.cost - (total - back)) + (cost - back)), self.excess)

    def within_range(self) -> _Amplitude:
        """As it is, or where it is above all numbers at the largest, with an unbounded excess."""
        if np.all(self.value <= LARGEST):
            return self
        return _Amplitude(np.minimum(self.value, LARGEST), self.cost, self.rest, math.inf)


class _Unlimited:
    """The sum from one root without a threshold: from component to component, over the bridges."""

    def __init__(
        self, graph: HapticGraph, root: int, listeners: Sequence[int], crossings: float, tolerance: float, budget: int, sums: PathSums
    ) -> None:
        self.graph = graph
        self.root = root
        self.listeners = listeners
        self.budget = budget
        self.sums = sums
        self.patch = contact_patches(graph)
        self.crossings = min(crossings, graph.contact_count)
        self.limited = crossings < graph.contact_count
        self.steps = int(crossings) + 1 if self.limited else 1
        self.lanes = sums.gain.shape[1]
        self.tolerance = tolerance

    def run(self) -> None:
        component = decompose(self.graph, self.root, self.listeners)
        if component is None:
            return
        columns: dict[int, list[int]] = {}
        for column, node in enumerate(self.listeners):
            columns.setdefault(node, []).append(column)
        deepest = _chain(component)
        if deepest > 1:
            self.tolerance = math.expm1(math.log1p(self.tolerance) / deepest)
        value = np.zeros((self.steps, self.lanes))
        value[0] = 1.0
        stack: list[tuple[Component, dict[int, _Amplitude]]] = [(component, {self.root: _Amplitude(value, 0.0, 0.0, 0.0)})]
        while stack:
            component, entrances = stack.pop()
            exits = list(dict.fromkeys([*component.listeners, *(node for nodes, _ in component.bridges for node, _ in nodes)]))
            arrived = self._through(component, entrances, exits)
            for node in component.listeners:
                if node in arrived:
                    self._hear(arrived[node], columns[node])
            for nodes, behind in component.bridges:
                onwards = {there: self._cross(arrived[here], here) for here, there in nodes if here in arrived}
                onwards = {node: amplitude for node, amplitude in onwards.items() if amplitude.value.any() or amplitude.excess}
                if onwards:
                    stack.append((behind, onwards))

    def _hear(self, amplitude: _Amplitude, columns: Sequence[int]) -> None:
        scale = bounded_exp(-(amplitude.cost + amplitude.rest))
        excess = min(scale * amplitude.excess, LARGEST) if amplitude.excess < math.inf else LARGEST
        for column in columns:
            self.sums.gain[column] += scale * amplitude.value.sum(axis=0)
            self.sums.error[column] = min(self.sums.error[column] + excess, LARGEST)

    def _cross(self, amplitude: _Amplitude, node: int) -> _Amplitude:
        """Over the contact of a bridge, from its node ``node`` on."""
        contact = int(self.graph.contact[node])
        value = amplitude.value * self.graph.share[contact]
        if self.lanes > 1 and self.graph.contact_band_gains is not None:
            value[:, 1:] *= self.graph.contact_band_gains[contact]
        if self.limited:
            value = np.concatenate([np.zeros((1, self.lanes)), value[:-1]])
        crossed = _Amplitude(value, amplitude.cost, amplitude.rest, amplitude.excess * float(self.graph.share[contact]))
        return crossed.further(float(self.graph.transmission_loss[contact]))

    def _through(self, component: Component, entrances: dict[int, _Amplitude], exits: Sequence[int]) -> dict[int, _Amplitude]:
        """What arrives at the exits of a component from what has entered it."""
        if not component.patches and len(entrances) == 1:
            ((node, amplitude),) = entrances.items()
            return {other: on for other in exits if other != node and (on := self._inside(node, other, amplitude)) is not None}
        arrived: dict[int, _Amplitude] = {}
        for node, amplitude in entrances.items():
            factors, missing = self._solve(component, node, exits)
            for number, other in enumerate(exits):
                factor, error = factors[number], float(missing[number])
                if not factor.any() and error == 0:
                    continue
                value = _convolve(amplitude.value, factor)
                entered, through = float(amplitude.value[:, 0].sum()), float(factor[:, 0].sum())
                error = math.inf if error >= LARGEST else error
                excess = (entered * error if entered else 0.0) + (amplitude.excess * (through + error) if amplitude.excess else 0.0)
                on = _Amplitude(value, amplitude.cost, amplitude.rest, excess).within_range()
                arrived[other] = _add(arrived[other], on) if other in arrived else on
        return arrived

    def _solve(self, component: Component, entrance: int, exits: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        """Sums (exits, k, lanes) over all paths inside a component from entrance to exits, and bounds (exits,) on what is missing."""
        others = [node for node in exits if node != entrance]
        problem = ComponentSum(self.graph, component, entrance, others, self.crossings if self.limited else math.inf, self.patch)
        found, left, work = problem.solve(self.tolerance, self.budget)
        self.sums.work += work
        places = [number for number, node in enumerate(exits) if node != entrance]
        sums, missing = np.zeros((len(exits), self.steps, self.lanes)), np.zeros(len(exits))
        sums[places], missing[places] = found, left
        return sums, missing

    def _inside(self, node: int, other: int, amplitude: _Amplitude) -> _Amplitude | None:
        """One intra-connection."""
        table = self.graph.table
        index = int(self.graph.node_object[node])
        distance = distances(self.graph.node_position[node], self.graph.node_position[other])
        if index in table.special:
            gain = float(table.gain(index, distance[None])[0])
            cost = -math.log(gain) if gain > 0 else math.inf
        else:
            cost = float(table.loss[index] + table.decay[index] * float(distance))
        if cost == math.inf:
            return None
        if self.lanes > 1:
            bands = band_factors(self.graph, np.array([index]), distance[None])[0]
            value = amplitude.value * np.concatenate([[1.0], bands])
            amplitude = _Amplitude(value, amplitude.cost, amplitude.rest, amplitude.excess)
        return amplitude.further(cost)


def _add(a: _Amplitude, b: _Amplitude) -> _Amplitude:
    """Both amplitudes together, on the scale of the stronger one: the other way round its factor might be above all numbers."""
    if a.cost + a.rest > b.cost + b.rest:
        a, b = b, a
    scale = math.exp((a.cost - b.cost) + (a.rest - b.rest))
    excess = a.excess + (scale * b.excess if b.excess < math.inf else math.inf)
    return _Amplitude(a.value + scale * b.value, a.cost, a.rest, excess).within_range()


def _convolve(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of values by number of contacts: (k, lanes), contacts add up, what exceeds k is dropped."""
    if len(a) == 1:
        return a * b
    result = np.zeros_like(a)
    for k in np.flatnonzero(a.any(axis=1)).tolist():
        result[k:] += a[k] * b[: len(a) - k]
    return result


def _chain(root: Component) -> int:
    """The largest number of pieces with patches inside on one way from the root."""
    most = 0
    stack = [(root, 0)]
    while stack:
        component, before = stack.pop()
        here = before + bool(component.patches)
        most = max(most, here)
        stack += [(behind, here) for _, behind in component.bridges]
    return most
