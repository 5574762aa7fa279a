"""Gains and levels of a sample by an independent way: NetworkX's shortest path over the explicit
graph of what touches, closed forms from the properties of Blender's objects for its edges, and a
mix that goes in straight lines from frame to frame.

Shared with the product are where things touch, and the waves of signals; both have references of
their own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any

import bpy
import networkx
import numpy as np


def owner(name: str) -> str:
    """The name of the object of Blender that a haptic object of this name is; an instance is called
    by its instancer, what it shows and a number."""
    _, colon, shown = name.rpartition(": ")
    return shown.rpartition(" ")[0] if colon else name


def loss(obj: Any, distance: float, epsilon: float) -> float:
    """What an object of Blender takes over a distance in metres, in neper."""
    haptics = obj.haptics
    if haptics.function == "exponential":
        return haptics.alpha * distance
    if haptics.function == "physical":
        assert (haptics.wave, haptics.loss_factor, haptics.absorption) == ("bounded", 0, 0)
        assert haptics.plate_thickness - haptics.reference_distance > distance
        return math.log(1 + distance / haptics.reference_distance)
    assert haptics.function == "haptic_tracing"
    factor = (1 - haptics.kappa) * haptics.rho
    return max(factor, epsilon) * distance - math.log(factor)


def explicit_graph(scene: Any, result: Any) -> tuple[networkx.DiGraph, list[list[Any]], list[Any]]:
    """Edges carry ``loss`` [neper] and ``delay`` [s]; beside it the nodes of each source and of
    each listener."""
    places: dict[int, list[tuple[Any, np.ndarray]]] = {}
    graph = networkx.Graph()
    contacts = result.contacts
    for row, (pair, ends, weight) in enumerate(
        zip(contacts.pairs.tolist(), contacts.positions, contacts.weight.tolist(), strict=True)
    ):
        for side in (0, 1):
            places.setdefault(pair[side], []).append((("contact", row, side), ends[side]))
        if weight > 0:
            graph.add_edge(
                ("contact", row, 0), ("contact", row, 1), loss=-math.log(weight), delay=0.0
            )
    number = {name: k for k, name in enumerate(result.objects)}
    roots: list[list[Any]] = []
    for row, source in enumerate(result.sources):
        sides = [(source.object, source.position), (source.second_object, source.second_position)]
        roots.append(
            [("source", row, side) for side, (name, _) in enumerate(sides) if name is not None]
        )
        for node, (name, position) in zip(roots[-1], sides, strict=False):
            places.setdefault(number[name], []).append((node, np.array(position)))
    targets = [("listener", column) for column in range(len(result.listeners))]
    for node, item in zip(targets, result.listeners, strict=True):
        places.setdefault(number[item.object], []).append((node, np.array(item.position)))
    reach = {node: item.radius for node, item in zip(targets, result.listeners, strict=True)}
    for index, nodes in places.items():
        obj = bpy.data.objects[owner(result.objects[index])]
        speed = obj.haptics.wave_speed
        for (a, here), (b, there) in itertools.combinations(nodes, 2):
            distance = float(np.linalg.norm(here - there))
            # From the nearest point of a listener's volume.
            distance = max(0.0, distance - reach.get(a, 0.0) - reach.get(b, 0.0))
            graph.add_edge(
                a,
                b,
                loss=loss(obj, distance, EPSILON),
                delay=distance / speed if speed else 0.0,
            )
    graph.add_nodes_from([*itertools.chain(*roots), *targets])
    ways = graph.to_directed()
    ways.remove_edges_from([*ways.out_edges(targets)])  # a volume shortens no way past it
    return ways, roots, targets


EPSILON = 0.1
"""The paper's least attenuation [1/m]."""


def gains(scene: Any, result: Any) -> tuple[np.ndarray, np.ndarray]:
    """Gain without amplitude, and delay, of every source at every listener (s, l), by the best
    path; 0 below -120 dB."""
    graph, roots, targets = explicit_graph(scene, result)
    gain, delay = np.zeros((2, len(roots), len(targets)))
    for row, nodes in enumerate(roots):
        losses, paths = networkx.multi_source_dijkstra(graph, set(nodes), weight="loss")
        for column, target in enumerate(targets):
            if target in losses and math.exp(-losses[target]) > 1e-6:
                gain[row, column] = math.exp(-losses[target])
                delay[row, column] = sum(
                    graph.edges[step]["delay"] for step in itertools.pairwise(paths[target])
                )
    return gain, delay


def levels(
    results: Iterable[Any], found: Mapping[int, tuple[np.ndarray, np.ndarray]], rate: float = 8000.0
) -> np.ndarray:
    """RMS (l,) of what the listeners feel over consecutive frames with these gains and delays. A
    persistent source fades in over its first frame; one that begins within a frame is at full gain
    at once."""
    squares, count = 0.0, 0
    # By name and onset: what slides begins anew under its name.
    last: dict[tuple[str, float], tuple[np.ndarray, np.ndarray]] = {}
    before = None
    for result in results:
        now = {
            (s.name, s.onset): (s.amplitude * g, d)
            for s, g, d in zip(result.sources, *found[result.number], strict=True)
        }
        if before is not None:
            numbers = np.arange(
                math.ceil(before * rate - 1e-6), math.ceil(result.time * rate - 1e-6)
            )
            times, part = (
                numbers / rate,
                ((numbers / rate - before) / (result.time - before))[:, None],
            )
            mix = np.zeros((len(numbers), len(result.listeners)))
            for source in result.sources:
                gain, delay = now[source.name, source.onset]
                begins = source.onset >= before
                start, early = last.get(
                    (source.name, source.onset), (gain if begins else 0 * gain, delay)
                )
                wave = [
                    source.signal.at(times - source.onset - late, 1 / rate)
                    for late in (early + (delay - early) * part).T
                ]
                mix += np.transpose(wave) * (start + (gain - start) * part)
            mix *= [item.gain for item in result.listeners]
            squares, count = (
                squares + (np.clip(mix, -1.0, 1.0) ** 2).sum(axis=0),
                count + len(numbers),
            )
        last, before = now, result.time
    return np.sqrt(squares / count)
