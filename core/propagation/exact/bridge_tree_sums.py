"""Sums over all paths, factorised over the bridge tree of the contacts: from component to component, over the bridges between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray
from ...graph.haptic_graph import HapticGraph
from ..connections import LARGEST, band_factors, bounded_exp, lanes_of
from .bridge_decomposition import Component, decompose
from .component_sums import ComponentSum


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Limits of the paths, and required accuracy of the sum.

    Attributes:
        crossings: most contacts on a path.
        threshold: least gain of a path.
        tolerance: relative error requested if the exact sum exceeds the budget.
        budget: most work: partial paths, states and transitions.
    """

    crossings: float
    threshold: float
    tolerance: float
    budget: int


@dataclass(slots=True)
class PathSums:
    """Sums of one source.

    Attributes:
        gain: (l, lanes) of each listener: the plain gain, then that of each band if bands are used.
        error: (l,) the true plain gain lies in ``[gain, gain + error]``; `LARGEST` without a bound.
        paths: (l,) number of paths summed, -1 if they were not counted.
        work: work done.
        recrossings: last entries (nodes) and gains of the walks that were not continued because they cross a contact twice; None if not
        requested or unknown.
    """

    gain: FloatArray
    error: FloatArray
    paths: IntArray
    work: int
    recrossings: tuple[IntArray, FloatArray] | None = None


def bridge_tree_sums(graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int], limits: PathLimits) -> PathSums:
    """Sum over all paths from the nodes ``roots`` of a source to each of the nodes ``listeners``, over at most ``limits.crossings``
    contacts: exact, or to the tolerance, unless that takes more than the budget."""
    sums = PathSums(np.zeros((len(listeners), lanes_of(graph))), np.zeros(len(listeners)), np.full(len(listeners), -1), 0)
    for root in roots:
        _BridgeTreeSum(graph, root, listeners, limits, sums).run()
    sums.error[sums.gain[:, 0] >= LARGEST] = LARGEST
    np.minimum(sums.gain, LARGEST, out=sums.gain)
    return sums


@dataclass(slots=True)
class _Amplitude:
    """The amplitude at a node, as a factor times ``exp(-(cost + rest))``.

    Attributes:
        value: (k, lanes) factor by the number of contacts crossed.
        cost, rest: the exponent in two parts, to avoid the loss of digits in a long chain.
        excess: bound on the missing part of the factor; infinite if there is none.
    """

    value: FloatArray
    cost: float
    rest: float
    excess: float

    def further(self, cost: float) -> _Amplitude:
        total = self.cost + cost
        back = total - self.cost
        return _Amplitude(self.value, total, self.rest + ((self.cost - (total - back)) + (cost - back)), self.excess)

    def within_range(self) -> _Amplitude:
        """The amplitude, clamped to `LARGEST` with an infinite excess if it overflows."""
        if np.all(self.value <= LARGEST):
            return self
        return _Amplitude(np.minimum(self.value, LARGEST), self.cost, self.rest, math.inf)


class _BridgeTreeSum:
    """The sum from one root, which `run` adds to ``sums``."""

    def __init__(self, graph: HapticGraph, root: int, listeners: Sequence[int], limits: PathLimits, sums: PathSums) -> None:
        self.graph = graph
        self.root = root
        self.listeners = listeners
        self.budget = limits.budget
        self.sums = sums
        self.crossings = min(limits.crossings, graph.contact_count)
        self.limited = limits.crossings < graph.contact_count
        self.steps = int(limits.crossings) + 1 if self.limited else 1
        self.lanes = sums.gain.shape[1]
        self.tolerance = limits.tolerance

    def run(self) -> None:
        component = decompose(self.graph, self.root, self.listeners)
        if component is None:
            return
        columns: dict[int, list[int]] = {}
        for column, node in enumerate(self.listeners):
            columns.setdefault(node, []).append(column)
        deepest = _longest_chain(component)
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
                    self._add_at_listener(arrived[node], columns[node])
            for nodes, beyond in component.bridges:
                onwards = {there: self._cross(arrived[here], here) for here, there in nodes if here in arrived}
                onwards = {node: amplitude for node, amplitude in onwards.items() if amplitude.value.any() or amplitude.excess}
                if onwards:
                    stack.append((beyond, onwards))

    def _add_at_listener(self, amplitude: _Amplitude, columns: Sequence[int]) -> None:
        scale = bounded_exp(-(amplitude.cost + amplitude.rest))
        excess = min(scale * amplitude.excess, LARGEST) if amplitude.excess < math.inf else LARGEST
        for column in columns:
            self.sums.gain[column] += scale * amplitude.value.sum(axis=0)
            self.sums.error[column] = min(self.sums.error[column] + excess, LARGEST)

    def _cross(self, amplitude: _Amplitude, node: int) -> _Amplitude:
        """The amplitude beyond the contact of a bridge, from its node ``node``."""
        contact = int(self.graph.contact[node])
        value = amplitude.value.copy()
        if self.lanes > 1 and self.graph.contact_band_gains is not None:
            value[:, 1:] *= self.graph.contact_band_gains[contact]
        if self.limited:
            value = np.concatenate([np.zeros((1, self.lanes)), value[:-1]])
        crossed = _Amplitude(value, amplitude.cost, amplitude.rest, amplitude.excess)
        return crossed.further(float(self.graph.transmission_loss[contact]))

    def _through(self, component: Component, entrances: dict[int, _Amplitude], exits: Sequence[int]) -> dict[int, _Amplitude]:
        """The amplitudes at the exits of a component from those at its entrances."""
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
        """Sums (exits, k, lanes) over all paths inside a component from entrance to exits, and bounds (exits,) on the missing part."""
        others = [node for node in exits if node != entrance]
        problem = ComponentSum(self.graph, component, entrance, others, self.crossings if self.limited else math.inf)
        found, left, work = problem.solve(self.tolerance, self.budget)
        self.sums.work += work
        places = [number for number, node in enumerate(exits) if node != entrance]
        sums, missing = np.zeros((len(exits), self.steps, self.lanes)), np.zeros(len(exits))
        sums[places], missing[places] = found, left
        return sums, missing

    def _inside(self, node: int, other: int, amplitude: _Amplitude) -> _Amplitude | None:
        """The amplitude at ``other`` over one intra-connection; None if its gain is 0."""
        table = self.graph.table
        index = int(self.graph.node_object[node])
        distance = self.graph.node_distances(np.array([node]), np.array([other]))
        constant, varying = table.costs(np.array([index]), distance)
        cost = float(constant[0] + varying[0])
        if cost == math.inf:
            return None
        if self.lanes > 1:
            bands = band_factors(self.graph, np.array([index]), distance)[0]
            value = amplitude.value * np.concatenate([[1.0], bands])
            amplitude = _Amplitude(value, amplitude.cost, amplitude.rest, amplitude.excess)
        return amplitude.further(cost)


def _add(a: _Amplitude, b: _Amplitude) -> _Amplitude:
    """The sum of two amplitudes on the scale of the stronger one, so that no factor overflows."""
    if a.cost + a.rest > b.cost + b.rest:
        a, b = b, a
    scale = math.exp((a.cost - b.cost) + (a.rest - b.rest))
    excess = a.excess + (scale * b.excess if b.excess < math.inf else math.inf)
    return _Amplitude(a.value + scale * b.value, a.cost, a.rest, excess).within_range()


def _convolve(a: FloatArray, b: FloatArray) -> FloatArray:
    """Convolution over the number of contacts (k, lanes); more than k contacts are dropped."""
    if len(a) == 1:
        return a * b
    result = np.zeros_like(a)
    for k in np.flatnonzero(a.any(axis=1)).tolist():
        result[k:] += a[k] * b[: len(a) - k]
    return result


def _longest_chain(root: Component) -> int:
    """The largest number of components with patches inside on one path of the bridge tree from the root."""
    most = 0
    stack = [(root, 0)]
    while stack:
        component, before = stack.pop()
        here = before + bool(component.patches)
        most = max(most, here)
        stack += [(beyond, here) for _, beyond in component.bridges]
    return most
