"""The best path against NetworkX: the largest product over its simple paths, and its Dijkstra for
functions that are metrics."""

from __future__ import annotations

import math
from random import Random

import networkx
import pytest
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Identity, Linear, Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from level_properties import check_shown
from path_reference import (
    AMPLIFYING,
    METRIC,
    OTHER,
    REFERENCES,
    connected_scene,
    meets,
    networkx_paths,
    recursive_paths,
    scenes,
)

LIMITS = st.tuples(
    st.sampled_from([None, 0, 1, 2, 3, 5, 7]), st.sampled_from([0.0, 1e-3, 0.1, 0.6, 1.0])
)


def check(
    scene: HapticScene, max_connections: int | None, threshold: float, reference: str = "networkx"
) -> None:
    graph = graph_of_scene(scene)
    result = propagate(
        graph,
        Settings(strategy=Strategy.BEST_PATH, max_connections=max_connections, threshold=threshold),
    )
    for column in range(len(graph.listeners)):
        paths = list(REFERENCES[reference](graph, 0, column))
        kept = {
            path: math.prod(gains)
            for path, gains in paths
            if meets(gains, max_connections, threshold) and math.prod(gains) > 0
        }
        best = max(kept.values(), default=0.0)
        assert result.gain[0, column] == pytest.approx(best, rel=1e-9, abs=0)
        without_limits = max((math.prod(gains) for _, gains in paths), default=0.0)
        assert abs(without_limits - best) <= result.error_bound[0, column] + 1e-9 * without_limits
        assert result.limited[0, column] == (result.error_bound[0, column] > 0)
        if without_limits >= threshold and max_connections is None:
            assert result.error_bound[0, column] in (0, math.inf)
        assert result.paths[0, column] == bool(kept)
        found = result.best_path.get((0, column), ())
        assert bool(found) == bool(kept)
        if found:
            assert kept[found] == pytest.approx(best, rel=1e-9)


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=4), LIMITS)
def test_largest_product_over_all_simple_paths(scene, limits):
    check(scene, *limits)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=3))
def test_recursion_finds_the_simple_paths_of_networkx(scene):
    graph = graph_of_scene(scene)
    for column in range(len(graph.listeners)):
        assert sorted(recursive_paths(graph, 0, column)) == sorted(networkx_paths(graph, 0, column))


SEEDS = st.integers(0, 10**6)


@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_longer_paths(seed, limits):
    check(connected_scene(seed), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=250, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_functions_that_are_no_metric(seed, limits):
    check(connected_scene(seed, (*METRIC, *OTHER, *OTHER), size=3.0), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=250, deadline=None, derandomize=True)
@given(SEEDS, LIMITS)
def test_gains_above_1(seed, limits):
    check(connected_scene(seed, (*METRIC[:3], *AMPLIFYING, *OTHER)), *limits, "recursion")


@pytest.mark.slow
@settings(max_examples=120, deadline=None, derandomize=True)
@given(scenes(METRIC, most_contacts=12, listeners=4))
def test_equals_dijkstra_on_the_explicit_graph(scene):
    graph = graph_of_scene(scene)
    explicit = graph.to_networkx()
    for edge in explicit.edges.values():
        edge["cost"] = -math.log(edge["gain"]) if edge["gain"] > 0 else math.inf
    explicit.remove_edges_from(
        [ends for ends, edge in explicit.edges.items() if edge["cost"] == math.inf]
    )
    result = propagate(
        graph, Settings(strategy=Strategy.BEST_PATH, max_connections=None, threshold=0)
    )
    for column, target in enumerate(graph.listener_nodes.tolist()):
        costs = [
            networkx.dijkstra_path_length(explicit, root, target, "cost")
            for root in graph.sources[0].nodes
            if networkx.has_path(explicit, root, target)
        ]
        expected = math.exp(-min(costs)) if costs else 0.0
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
        tuple(Listener(f"l{k}", f"{k:02d} 07", (3.0 * k, 21.0, 0.0)) for k in range(side)),
    )
    graph = graph_of_scene(scene)
    check_shown(graph, propagate(graph, Settings()), Settings().threshold)


def test_way_back_through_an_entry_of_another_path():
    check(
        connected_scene(961, (OTHER[0], Identity()), most_objects=8, extra=5, size=2.5),
        None,
        0.0,
        "recursion",
    )


@pytest.mark.parametrize("way_back", [False, True])
def test_cheapest_walk_that_crosses_a_contact_twice_is_no_path(way_back):
    """The linear function passes 3 m of the plank only in two halves, by way of the box on it and
    the loop on top of that."""
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
        objects, tuple(contacts), (Source("s", "plank"),), (Listener("l", "plank", (3.0, 0, 0)),)
    )
    check(scene, None, 0.0)
    check(scene, 9, 0.0)
