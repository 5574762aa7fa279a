"""Causes of silence on a path: too much attenuation, gain 0, or too many connections."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

from ..graph.distance_only import DISTANCE_ONLY
from ..graph.haptic_graph import HapticGraph
from ..message import Cause, Chain, Decibels, Message, Metres
from ..propagation import objects_on
from ..propagation.best_path import best_paths
from ..propagation.connections import intra_costs
from ..propagation.modes import straight_distances
from ..propagation.shortest_paths import LIMIT
from ..propagation.strategies import strategy_of
from ..render.frame_result import FrameResult
from ..scene.choices import Strategy
from ..scene.coefficients import transfer_coefficient
from ..scene.values import Mode, Settings

NEPER = 20 / math.log(10)
"""Decibels per neper."""
_BARRIER = 40.0
"""Cost [Np] given to an object that transmits nothing, to find the path with the fewest such
objects."""


def straight_line_message(
    result: FrameResult, settings: Settings, row: int, listener: int
) -> Message:
    """Why nothing arrives in the modes MD and MN, which ignore objects."""
    source = result.sources[row].name
    distance = float(straight_distances(result.graph)[row, listener])
    loss = DISTANCE_ONLY.alpha * distance * NEPER if settings.mode is Mode.MD else 0.0
    return Message.of(
        Cause.TOO_FAR,
        source,
        source=source,
        distance=Metres(distance),
        gain=Decibels(-loss),
        threshold=Decibels(-NEPER * LIMIT),
    )


def loss_message(graph: HapticGraph, settings: Settings, row: int, column: int) -> Message | None:
    """The losses on the best chain of contacts from source ``row`` to listener ``column``; None
    without a chain."""
    path = _best_path(graph, row, column)
    if path:
        kind = graph.sources[row].kind
        is_sum = strategy_of(kind, settings) is Strategy.AS_IN_THE_PAPER
        return _weak_path_message(graph, settings if is_sum else None, path)
    path = _best_path(_with_barriers(graph), row, column)
    return _barrier_message(graph, path) if path else None


def _weak_path_message(
    graph: HapticGraph, limits: Settings | None, path: tuple[int, ...]
) -> Message:
    """Message that a path is too weak or too long; ``limits``: those of a sum over paths."""
    losses = object_losses(graph, path)
    total = sum(loss for _, loss, _ in losses)
    chain = Chain(objects_on(graph, path))
    count = len(path) - 1
    least = LIMIT if limits is None else -math.log(max(limits.threshold, 1e-300))
    most = None if limits is None else limits.max_connections
    if total <= NEPER * least and most is not None and count > most:
        return Message.of(Cause.TOO_LONG, path=chain, count=count, most=most)
    worst, loss, distance = max(losses, key=lambda item: item[1])
    return Message.of(
        Cause.BELOW_THRESHOLD,
        worst,
        path=chain,
        gain=Decibels(-total),
        threshold=Decibels(-NEPER * least),
        object=worst,
        loss=Decibels(loss),
        distance=Metres(distance),
    )


def _barrier_message(graph: HapticGraph, path: tuple[int, ...]) -> Message:
    """Message that an object or contact on the chain transmits nothing."""
    for a, b in itertools.pairwise(path):
        if graph.partner[a] == b and graph.contact[a] >= 0:
            if not math.isfinite(graph.transmission_loss[graph.contact[a], graph.side[a]]):
                first, second = (graph.table.names[graph.node_object[node]] for node in (a, b))
                return Message.of(Cause.CONTACT_ZERO, first, first=first, second=second)
        elif not math.isfinite(float(intra_costs(graph, np.array([a]), np.array([b]))[0])):
            return _object_message(graph, a, b)
    return Message.of(
        Cause.NO_SIMPLE_PATH,
        graph.table.names[graph.node_object[path[0]]],
        path=Chain(objects_on(graph, path)),
    )


def _object_message(graph: HapticGraph, a: int, b: int) -> Message:
    """Message that the object with the nodes ``a`` and ``b`` transmits nothing between them."""
    item = graph.table.objects[graph.node_object[a]]
    if (
        item.propagation.name == "haptic_tracing"
        and transfer_coefficient(item.kappa, item.rho) == 0
    ):
        return Message.of(
            Cause.KAPPA_ONE if item.kappa == 1 else Cause.RHO_ZERO, item.name, object=item.name
        )
    distance = Metres(graph.node_distances(np.array([a]), np.array([b]))[0])
    function = item.propagation.name.replace("_", " ")
    return Message.of(
        Cause.FUNCTION_ZERO, item.name, object=item.name, distance=distance, function=function
    )


def object_losses(graph: HapticGraph, path: tuple[int, ...]) -> list[tuple[str, float, float]]:
    """Per object on a path, with its contact to the next one: name, loss [dB], distance [m]."""
    result: dict[str, tuple[float, float]] = {}
    for a, b in itertools.pairwise(path):
        name = graph.table.names[graph.node_object[a]]
        if graph.partner[a] == b and graph.contact[a] >= 0:
            cost = float(graph.transmission_loss[graph.contact[a], graph.side[a]])
            length = 0.0
        else:
            ends = np.array([a]), np.array([b])
            cost = float(intra_costs(graph, *ends)[0])
            length = float(graph.node_distances(*ends)[0])
        loss, distance = result.get(name, (0.0, 0.0))
        result[name] = loss + NEPER * cost, distance + length
    return [(name, loss, distance) for name, (loss, distance) in result.items()]


def _best_path(graph: HapticGraph, row: int, column: int) -> tuple[int, ...]:
    """Nodes of the best path, however weak, () if there is none."""
    wanted = np.zeros((len(graph.sources), len(graph.listeners)), dtype=np.bool_)
    wanted[row, column] = True
    return best_paths(graph, wanted, math.inf).paths.get((row, column), ())


def _with_barriers(graph: HapticGraph) -> HapticGraph:
    """The graph with a finite cost for each connection of gain 0, and nearly 0 elsewhere."""
    barriers = np.where(graph.table.loss >= _BARRIER, _BARRIER, 1e-3)
    barriers[sorted(graph.table.special)] = _BARRIER / 4
    decay = np.full(len(barriers), 1e-3)
    table = replace(
        graph.table, factor=np.exp(-barriers), decay=decay, loss=barriers, special=frozenset()
    )
    loss = np.minimum(graph.transmission_loss, _BARRIER)
    return replace(graph, table=table, transmission_loss=loss)
