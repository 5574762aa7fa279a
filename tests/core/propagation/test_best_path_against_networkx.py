"""The best path against NetworkX: the largest product over its simple paths, and its Dijkstra for
functions that are metrics."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import networkx
import numpy as np
import pytest
from explicit_graph import explicit_graph
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import propagate, shortest_paths
from haptic_tracing.core.scene.functions import Identity, Linear, Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from level_properties import check_shown
from path_reference import (
    METRIC,
    OTHER,
    REFERENCES,
    connected_scene,
    least_cost,
    networkx_paths,
    recursive_paths,
    scenes,
)

LEAST = 1e-6
"""Gain at which the search ends."""
SEEDS = st.integers(0, 10**6)


def check(scene: HapticScene, reference: str = "networkx") -> None:
    graph = graph_of_scene(scene)
    result = propagate(graph, Settings())
    for column in range(len(graph.listeners)):
        paths = {
            path: gain
            for path, gains in REFERENCES[reference](graph, 0, column)
            if (gain := math.prod(gains)) >= LEAST
        }
        best = max(paths.values(), default=0.0)
        assert result.gain[0, column] == pytest.approx(best, rel=1e-9, abs=0)
        assert not result.limited[0, column]
        assert result.paths[0, column] == bool(paths)
        found = result.best_path.get((0, column), ())
        assert bool(found) == bool(paths)
        if found:
            assert paths[found] == pytest.approx(best, rel=1e-9)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=4))
def test_largest_product_over_all_simple_paths(scene):
    check(scene)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=3))
def test_recursion_finds_the_simple_paths_of_networkx(scene):
    graph = graph_of_scene(scene)
    for column in range(len(graph.listeners)):
        assert sorted(recursive_paths(graph, 0, column)) == sorted(networkx_paths(graph, 0, column))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS)
def test_longer_paths(seed):
    check(connected_scene(seed), "recursion")


def check_walks(graph: HapticGraph) -> None:
    result = propagate(graph, Settings())
    for row in range(len(graph.sources)):
        for column in range(len(graph.listeners)):
            cost = least_cost(graph, row, column)
            expected = math.exp(-cost) if cost <= math.log(1 / LEAST) else 0.0
            assert result.gain[row, column] == pytest.approx(expected, rel=1e-9, abs=0)


@settings(max_examples=250, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([1, 1 << 15]))
def test_functions_that_are_no_metric(seed, batch):
    """The walk of least cost, which may go back over a contact; also with a step for each entry."""
    scene = connected_scene(seed, (*METRIC, *OTHER, *OTHER), size=3.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "BATCH", batch)
        check_walks(graph_of_scene(scene))


@settings(max_examples=250, deadline=None, derandomize=True)
@given(SEEDS, st.integers(1, 4), st.sampled_from([1, 1 << 15]))
def test_contacts_that_differ_by_direction(seed, sources, batch):
    """Two costs for each contact, drawn at random; trees grow from the sources or, where these are
    more, from the listeners."""
    scene = connected_scene(seed, METRIC, extra=5, listeners=3)
    scene = replace(
        scene,
        sources=tuple(replace(scene.sources[0], name=f"s{k}") for k in range(sources)),
    )
    graph = graph_of_scene(scene)
    costs = np.random.default_rng(seed).uniform(0.0, 3.0, (graph.contact_count, 2))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "BATCH", batch)
        check_walks(replace(graph, transmission_loss=costs))


@pytest.mark.slow
@settings(max_examples=120, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=12, listeners=4))
def test_equals_dijkstra_on_the_explicit_graph(scene):
    graph = graph_of_scene(scene)
    explicit = explicit_graph(graph)
    # A listener's ball shortens the way to it, not that past it.
    explicit.remove_edges_from([*explicit.out_edges(graph.listener_nodes.tolist())])
    for edge in explicit.edges.values():
        edge["cost"] = -math.log(edge["gain"]) if edge["gain"] > 0 else math.inf
    explicit.remove_edges_from(
        [ends for ends, edge in explicit.edges.items() if edge["cost"] == math.inf]
    )
    result = propagate(graph, Settings())
    for column, target in enumerate(graph.listener_nodes.tolist()):
        costs = [
            networkx.dijkstra_path_length(explicit, root, target, "cost")
            for root in graph.sources[0].nodes
            if networkx.has_path(explicit, root, target)
        ]
        expected = math.exp(-min(costs)) if costs else 0.0
        expected = expected if expected >= LEAST else 0.0
        assert result.gain[0, column] == pytest.approx(expected, rel=1e-9, abs=0)


def test_a_wide_floor_of_slabs():
    """Joined over parts of their edges; too many contacts for single connections."""
    side, random = 14, Random(5)
    slab = Physical(wave=Wave.BOUNDED, thickness=0.2, extent=3.0)
    objects = {
        (i, j): HapticObject(f"{i:02d} {j:02d}", 0.1, 0.9, slab, Box((3, 3, 0.2)))
        for i in range(side)
        for j in range(side)
    }
    contacts = []
    for (i, j), item in objects.items():
        for di, dj in ((1, 0), (0, 1)):
            other = objects.get((i + di, j + dj))
            at = (3 * i + 1.5 * di, 3 * j + 1.5 * dj, 0.0)
            if other is not None and random.random() < 0.8:
                area = 0.6 * random.choice([0.0, 0.3, 0.7, 1.0])
                pair = item.name, other.name
                contacts.append(Contact(pair, (at, at), area=area, normal=(di, dj, 0)))
    scene = HapticScene(
        tuple(objects.values()),
        tuple(contacts),
        (Source("s", "03 04", (8.0, 12.5, 0.0)),),
        tuple(
            Listener(f"l{k}", f"{k:02d} 07", (3.0 * k, 21.0, 0.0), radius=0.0) for k in range(side)
        ),
    )
    graph = graph_of_scene(scene)
    check_shown(graph, propagate(graph, Settings()), LEAST)


@pytest.mark.parametrize("way_back", [False, True])
def test_cheapest_walk_goes_back_over_a_contact(way_back):
    """The linear function passes 3 m of the plank only in two parts: by way of the box on it and
    the loop on top of that, and back over the same contact, or over another one."""
    objects = (
        HapticObject("plank", 0.0, 1.0, Linear(range=2.0)),
        HapticObject("box", 0.0, 1.0, Identity()),
        HapticObject("loop", 0.0, 1.0, Identity()),
    )
    contacts = [
        Contact(("plank", "box"), ((1.5, 0, 0), (1.5, 0, 0))),
        Contact(("box", "loop"), ((1.5, 0, 1), (1.5, 0, 1))),
        Contact(("loop", "box"), ((1.5, 0, 2), (1.5, 0, 2))),
    ]
    if way_back:
        contacts.append(Contact(("box", "plank"), ((1.75, 0, 0), (1.75, 0, 0))))
    scene = HapticScene(
        objects,
        tuple(contacts),
        (Source("s", "plank"),),
        (Listener("l", "plank", (3.0, 0, 0), radius=0.0),),
    )
    check_walks(graph_of_scene(scene))
    expected = 0.25 * 0.375 if way_back else 0.25 * 0.25
    assert propagate(graph_of_scene(scene), Settings()).gain[0, 0] == pytest.approx(expected)
