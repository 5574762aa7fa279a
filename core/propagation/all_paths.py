"""`all_paths`: the sum of the products of gains over all paths from a source to its listeners.

With a threshold, whether a path counts depends on its own gain, so paths are searched one by one, as arrays, with everything left out that
can't meet the threshold. Without one, the sum is taken apart at the bridges (`pieces`), and inside a piece it is found without enumeration:
by dynamic programming over a frontier where the piece is narrow (`frontier`), by a search that merges partial paths where it is not
(`path_search`), each tried with little work first, then with more. What is found is exact, or an interval: a lower bound that was summed,
and a bound of the rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..bands import BAND_COUNT
from ..graph import HapticGraph, distances
from . import frontier
from .arena import Arena, band_factors, build_arena, intra_gains
from .connections import cost_limit
from .labels import Labels, label
from .layered import layers
from .path_search import Found, Limits, search
from .pieces import Piece, patches_of, pieces
from .walk_sums import LARGEST, walk_sums

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

STAGES = (1 / 256, 1 / 16, 1.0)
"""Parts of the budget that each method is given in turn, until one of them succeeds."""

SLACK = 1e-9
"""Labels are rounded, so what they leave out is a little beyond the limit; the search then judges exactly."""

LAYERS = 64
"""Layers computed where gains exceed 1, to leave out what is never reached above the threshold; and contacts for which bounds of what is
left are kept one by one."""

EXPECTED = 60
"""The frontier takes from 1 to 170 times as many transitions as its order lets expect, measured on the benchmark's families: where so many
times are within the budget, it is tried before the search."""

ROUNDING = 1e-11
"""Relative allowance for rounding in the bound of a sum that is not exact."""


@dataclass(slots=True)
class PathSums:
    """``gain`` (l, lanes) of each listener: the plain gain, then that of each band where bands are used; the true plain gain lies in
    ``[gain, gain + error]``. ``paths`` (l,) how many were summed, -1 where they were not counted. ``work`` states looked at."""

    gain: FloatArray
    error: FloatArray
    paths: IntArray
    work: int


@dataclass(frozen=True, slots=True)
class Reach:
    """What meets a threshold: ``forward`` labels of each source (a row), ``behind`` (n,) cost from entering at a node to a listener."""

    forward: Labels
    behind: FloatArray


def reach(graph: HapticGraph, sources: Sequence[Sequence[int]], threshold: float) -> Reach:
    """Labels of the nodes of each source and of all listeners together, up to the threshold. No gain may exceed 1."""
    limit = cost_limit(threshold) + SLACK
    forward = label(graph, sources, np.full(len(sources), limit), complete=True)
    behind = label(graph, [graph.listener_nodes.tolist()], np.array([limit]), complete=True)
    return Reach(forward, behind.arrival[0])


def limited_sums(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    crossings: float,
    threshold: float,
    budget: int,
    known: Reach | None,
    row: int,
) -> PathSums:
    """Sum over the paths from the nodes ``roots`` of a source to each of the nodes ``listeners`` whose gain stays at the threshold or
    above, over at most ``crossings`` contacts: exact unless there are more than the budget allows. ``known`` and its row of this source;
    None where some gain exceeds 1, so that all that can be said is whether the threshold is met so far."""
    limit = cost_limit(threshold) + SLACK
    if known is None:
        most = int(min(crossings, graph.contact_count))
        reached = layers(graph, roots, limit, min(most, LAYERS), complete=True)
        certain = reached.complete or most <= LAYERS
        arrival = reached.costs(graph.node_count)[-1] if certain else np.zeros(graph.node_count)
        behind = np.zeros(graph.node_count)
    else:
        arrival, behind = known.forward.arrival[row], known.behind
    crossing = np.append(graph.transmission_loss, math.inf)[graph.contact]
    before = arrival[graph.partner] + crossing
    before[list(roots)] = 0.0
    entries = np.flatnonzero((graph.partner >= 0) & (before + behind <= limit))
    arena = build_arena(graph, entries, roots, listeners, patches_of(graph), (before, behind, limit))
    ahead = np.full(len(arena.nodes), math.inf) if known is None else np.exp(-behind[arena.nodes])
    limits = Limits(crossings, threshold, ahead, 0.0, np.zeros(len(listeners)), max(1, budget // 4), budget)
    found = search(arena, np.ones((len(roots), arena.lanes)), limits, _bounds_of(arena, crossings), merge=False)
    return PathSums(found.sums.sum(axis=0), found.missing * (1 + ROUNDING), found.paths, found.work)


def unlimited_sums(
    graph: HapticGraph, roots: Sequence[int], listeners: Sequence[int], crossings: float, tolerance: float, budget: int
) -> PathSums:
    """Sum over all paths from the nodes ``roots`` of a source to each of the nodes ``listeners``, over at most ``crossings`` contacts,
    exact or to the ``tolerance`` unless that takes more than the budget allows."""
    sums = PathSums(np.zeros((len(listeners), lanes_of(graph))), np.zeros(len(listeners)), np.full(len(listeners), -1), 0)
    for root in roots:
        _Unlimited(graph, root, listeners, crossings, tolerance, budget, sums).run()
    return sums


def lanes_of(graph: HapticGraph) -> int:
    """1, or 1 and one per band where bands are used."""
    return 1 + BAND_COUNT if graph.uses_bands else 1


def _bounds_of(arena: Arena, crossings: float) -> Callable[[], FloatArray]:
    """The walk sums of the arena, computed when they are first asked for."""
    known: list[FloatArray] = []

    def bounds() -> FloatArray:
        if not known:
            known.append(walk_sums(arena, crossings))
        return known[0]

    return bounds


@dataclass(slots=True)
class _Amplitude:
    """What arrives at a node: ``value`` (k, lanes) by the number of contacts crossed, times ``exp(-cost)``; ``cost`` in two parts that
    add up to it (a long chain would lose digits in one); ``excess`` bounds how much more it may be, relative to exp(-cost)."""

    value: FloatArray
    cost: float
    rest: float
    excess: float

    def further(self, cost: float) -> _Amplitude:
        total = self.cost + cost
        back = total - self.cost
        return _Amplitude(self.value, total, self.rest + ((self.cost - (total - back)) + (cost - back)), self.excess)


class _Unlimited:
    """The sum from one root without a threshold: from piece to piece, over the bridges."""

    def __init__(
        self, graph: HapticGraph, root: int, listeners: Sequence[int], crossings: float, tolerance: float, budget: int, sums: PathSums
    ) -> None:
        self.graph = graph
        self.root = root
        self.listeners = listeners
        self.budget = budget
        self.sums = sums
        self.patch = patches_of(graph)
        self.crossings = min(crossings, graph.contact_count)
        self.limited = crossings < graph.contact_count
        self.steps = int(crossings) + 1 if self.limited else 1
        self.lanes = sums.gain.shape[1]
        self.tolerance = tolerance

    def run(self) -> None:
        piece = pieces(self.graph, self.root, self.listeners)
        if piece is None:
            return
        columns: dict[int, list[int]] = {}
        for column, node in enumerate(self.listeners):
            columns.setdefault(node, []).append(column)
        deepest = _chain(piece)
        if deepest > 1:
            self.tolerance = math.expm1(math.log1p(self.tolerance) / deepest)
        value = np.zeros((self.steps, self.lanes))
        value[0] = 1.0
        stack: list[tuple[Piece, dict[int, _Amplitude]]] = [(piece, {self.root: _Amplitude(value, 0.0, 0.0, 0.0)})]
        while stack:
            piece, entrances = stack.pop()
            exits = list(dict.fromkeys([*piece.listeners, *(node for nodes, _ in piece.bridges for node, _ in nodes)]))
            arrived = self._through(piece, entrances, exits)
            for node in piece.listeners:
                if node in arrived:
                    self._hear(arrived[node], columns[node])
            for nodes, behind in piece.bridges:
                onwards = {there: self._cross(arrived[here], here) for here, there in nodes if here in arrived}
                onwards = {node: amplitude for node, amplitude in onwards.items() if amplitude.value.any() or amplitude.excess}
                if onwards:
                    stack.append((behind, onwards))

    def _hear(self, amplitude: _Amplitude, columns: Sequence[int]) -> None:
        scale = math.exp(-(amplitude.cost + amplitude.rest))
        for column in columns:
            self.sums.gain[column] += scale * amplitude.value.sum(axis=0)
            self.sums.error[column] = min(self.sums.error[column] + scale * amplitude.excess, LARGEST)

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

    def _through(self, piece: Piece, entrances: dict[int, _Amplitude], exits: Sequence[int]) -> dict[int, _Amplitude]:
        """What arrives at the exits of a piece from what has entered it."""
        if not piece.patches and len(entrances) == 1:
            ((node, amplitude),) = entrances.items()
            return {other: on for other in exits if other != node and (on := self._inside(node, other, amplitude)) is not None}
        arrived: dict[int, _Amplitude] = {}
        for node, amplitude in entrances.items():
            factors, missing = _solve(self, piece, node, exits)
            for number, other in enumerate(exits):
                factor, error = factors[number], float(missing[number])
                if not factor.any() and error == 0:
                    continue
                value = _convolve(amplitude.value, factor)
                excess = float(amplitude.value[:, 0].sum()) * error + amplitude.excess * (float(factor[:, 0].sum()) + error)
                on = _Amplitude(value, amplitude.cost, amplitude.rest, min(excess, LARGEST))
                arrived[other] = _add(arrived[other], on) if other in arrived else on
        return arrived

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
    """Both amplitudes together, on the scale of the first."""
    scale = math.exp((a.cost - b.cost) + (a.rest - b.rest))
    return _Amplitude(a.value + scale * b.value, a.cost, a.rest, min(a.excess + scale * b.excess, LARGEST))


def _convolve(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of values by number of contacts: (k, lanes), contacts add up, what exceeds k is dropped."""
    if len(a) == 1:
        return a * b
    result = np.zeros_like(a)
    for k in np.flatnonzero(a.any(axis=1)).tolist():
        result[k:] += a[k] * b[: len(a) - k]
    return result


def _chain(root: Piece) -> int:
    """The largest number of pieces with patches inside on one way from the root."""
    most = 0
    stack = [(root, 0)]
    while stack:
        piece, before = stack.pop()
        here = before + bool(piece.patches)
        most = max(most, here)
        stack += [(behind, here) for _, behind in piece.bridges]
    return most


def _solve(run: _Unlimited, piece: Piece, entrance: int, exits: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Sums (exits, k, lanes) over all paths inside a piece from its entrance to its exits, and bounds (exits,) of what is missing."""
    graph = run.graph
    others = [node for node in exits if node != entrance]
    places = np.array([number for number, node in enumerate(exits) if node != entrance], dtype=np.int64)
    sums = np.zeros((len(exits), run.steps, run.lanes))
    missing = np.zeros(len(exits))
    nodes = np.array([node for patch in piece.patches for pair in patch for node in pair], dtype=np.int64)
    arena = build_arena(graph, nodes, [entrance], others, run.patch)
    crossings = run.crossings if run.limited else math.inf
    bounds = _bounds_of(arena, crossings)
    known, unknown = np.zeros(len(others)), np.full(len(arena.nodes), math.inf)
    best: Found | None = None
    program = _Frontier(run, piece, entrance, others)
    for part in STAGES:
        share = int(run.budget * part)
        for method in ("sum", "search") if part == STAGES[0] or program.width * EXPECTED <= share else ("search", "sum"):
            if method == "sum":
                exact, work = program.sum(share)
                run.sums.work += work
                if exact is not None:
                    sums[places] = exact
                    return sums, missing
                continue
            limits = Limits(crossings, 0.0, unknown, run.tolerance, known, max(1, share // 4), share)
            found = search(arena, np.ones((1, arena.lanes)), limits, bounds, merge=True)
            run.sums.work += found.work
            total = found.sums.sum(axis=0)[:, 0]
            known = np.maximum(known, total)
            if best is None or (found.missing.sum(), -total.sum()) < (best.missing.sum(), -best.sums[..., 0].sum()):
                best = found
            if np.all(best.missing <= run.tolerance * best.sums.sum(axis=0)[:, 0]):
                break
        else:
            continue
        break
    assert best is not None
    by_count = best.sums.transpose(1, 0, 2)
    if run.limited:
        count = min(run.steps, by_count.shape[1])
        sums[places, :count] = by_count[:, :count]
    else:
        sums[places, 0] = by_count.sum(axis=1)
    missing[places] = best.missing * (1 + ROUNDING)
    return sums, missing


class _Frontier:
    """The frontier dynamic programme of a piece, prepared once for several attempts."""

    def __init__(self, run: _Unlimited, piece: Piece, entrance: int, exits: Sequence[int]) -> None:
        self.run = run
        self.entrance = entrance
        self.exits = np.array(exits, dtype=np.int64)
        objects, position = run.graph.node_object, run.graph.node_position
        edges = [(int(objects[patch[0][0]]), int(objects[patch[0][1]])) for patch in piece.patches]
        places = {index: position[a].tolist() for patch in piece.patches for a, b in patch for index in (int(objects[a]), int(objects[b]))}
        start = int(objects[entrance])
        order, self.expected = frontier.order_patches(edges, places, start)
        ordered = [[(int(objects[a]), a, int(objects[b]), b) for a, b in piece.patches[number]] for number in order]
        self.width = self.expected[-1] if self.expected else 0.0
        try:
            self.crossings = frontier.plan(ordered, (start, entrance))
        except frontier.TooWide:
            self.crossings, self.width = [], math.inf
        self.weights: list[frontier.Weights] | None = None

    def _factors(self, a: IntArray, b: IntArray) -> FloatArray:
        """Factors (n, lanes) of intra-connections."""
        gains, distance = intra_gains(self.run.graph, a, b)
        if self.run.lanes == 1:
            return gains[:, None]
        bands = band_factors(self.run.graph, self.run.graph.node_object[a], distance)
        return np.concatenate([gains[:, None], gains[:, None] * bands], axis=1)

    def _ends(self, nodes: IntArray) -> list[FloatArray | None]:
        """Of each node: the factors (exits, lanes) of ending at the exits, or None where there are none in its object."""
        objects = self.run.graph.node_object
        inside = (objects[nodes][:, None] == objects[self.exits]) & (nodes[:, None] != self.exits)
        which, number = np.nonzero(inside)
        table = np.zeros((*inside.shape, self.run.lanes))
        table[which, number] = self._factors(nodes[which], self.exits[number])
        return [row if some else None for row, some in zip(table, inside.any(axis=1).tolist(), strict=True)]

    def _weigh(self) -> list[frontier.Weights]:
        """The factors of all crossings, computed together."""
        graph = self.run.graph
        sides = [(node, waiting) for crossing in self.crossings for node, waiting in zip(crossing.nodes, crossing.waiting, strict=True)]
        sizes = [len(waiting) for _, waiting in sides]
        nodes = np.array([node for node, _ in sides], dtype=np.int64)
        others = np.array([node for _, waiting in sides for node, _ in waiting], dtype=np.int64)
        joins = self._factors(np.repeat(nodes, sizes), others)
        ends = self._ends(nodes)
        contact = graph.contact[nodes[::2]]
        through = np.repeat((graph.transmission * graph.share)[contact][:, None], self.run.lanes, axis=1)
        if graph.contact_band_gains is not None:
            through[:, 1:] *= graph.contact_band_gains[contact]
        alone = np.ones((1, self.run.lanes))
        weights = []
        place = 0
        for number in range(len(self.crossings)):
            size_a, size_b = sizes[2 * number : 2 * number + 2]
            by_a = np.concatenate([joins[place : place + size_a], alone]) * through[number]
            by_b = np.concatenate([joins[place + size_a : place + size_a + size_b], alone])
            place += size_a + size_b
            weights.append(
                frontier.Weights(by_a[:, None] * by_b, (by_a, by_b * through[number]), (ends[2 * number], ends[2 * number + 1]))
            )
        return weights

    def sum(self, allowed: int) -> tuple[FloatArray | None, int]:
        """(exits, k, lanes), or None where ``allowed`` is not enough; and the work done."""
        run = self.run
        if self.width > allowed:
            return None, 0
        if self.weights is None:
            self.weights = self._weigh()
        start = np.zeros((run.steps, run.lanes))
        start[0] = 1.0
        (ends,) = self._ends(np.array([self.entrance]))
        at_start = np.zeros((len(self.exits), run.lanes)) if ends is None else ends
        try:
            total, work = frontier.sum_over_paths(self.crossings, self.weights, start, at_start, run.limited, self.expected, allowed)
        except frontier.TooWide:
            return None, allowed
        return total, int(work)
