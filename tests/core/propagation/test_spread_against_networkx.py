"""`spread` against NetworkX on the explicit graph of states: inside an object (may leave it) and
just entered (may go through it)."""

from __future__ import annotations

import math

import networkx
import numpy as np
import pytest
from explicit_graph import explicit_graph
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation.spread import spread
from haptic_tracing.core.scene.functions import Constant, Exponential, HapticTracing, Linear
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st

FUNCTIONS = (HapticTracing(), Exponential(alpha=0.3), Linear(range=6.0), Constant(gain_value=0.7))


@st.composite
def graphs(draw: st.DrawFn) -> HapticGraph:
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(2, 9))
    objects = tuple(
        HapticObject(
            f"o{k}",
            float(random.uniform(0, 0.5)),
            float(random.uniform(0.5, 1)),
            FUNCTIONS[random.integers(len(FUNCTIONS))],
        )
        for k in range(count)
    )

    def place() -> tuple[float, float, float]:
        return tuple(random.uniform(-2, 2, 3).tolist())

    contacts = []
    for _ in range(draw(st.integers(0, 2 * count))):
        a, b = random.choice(count, 2, replace=False)
        contacts.append(
            Contact(
                (f"o{a}", f"o{b}"), (place(), place()), FUNCTIONS[random.integers(len(FUNCTIONS))]
            )
        )
    sources = tuple(
        Source(f"s{k}", f"o{random.integers(count)}", place(), float(random.uniform(0, 1)))
        for k in range(draw(st.integers(0, 3)))
    )
    listeners = tuple(
        Listener(f"l{k}", f"o{random.integers(count)}", place(), radius=0.0)
        for k in range(draw(st.integers(0, 3)))
    )
    return graph_of_scene(HapticScene(objects, tuple(contacts), sources, listeners))


def strongest_by_networkx(graph: HapticGraph) -> np.ndarray:
    """Largest product at every node: shortest paths over two states of each node, its object has
    been entered through it, or it has been arrived at inside."""
    states = networkx.DiGraph()
    for a, b, edge in explicit_graph(graph).edges(data=True):
        if edge["gain"] > 0:
            ends = ((a, 0), (b, 1)) if edge["connection"] == "intra" else ((a, 1), (b, 0))
            states.add_edge(*ends, cost=-math.log(edge["gain"]))
    best = np.zeros(graph.node_count)
    for source in graph.sources:
        for root in source.nodes:
            best[root] = max(best[root], source.amplitude)
            if (root, 0) not in states:
                continue
            for (node, _), cost in networkx.single_source_dijkstra_path_length(
                states, (root, 0), weight="cost"
            ).items():
                if math.exp(-cost) >= 1e-6:
                    best[node] = max(best[node], source.amplitude * math.exp(-cost))
    return best


@pytest.mark.slow
@settings(deadline=None, derandomize=True, max_examples=300)
@given(graphs())
def test_gain_is_the_largest_product(graph: HapticGraph) -> None:
    assert spread(graph).amplitude == pytest.approx(strongest_by_networkx(graph), rel=1e-9)


@settings(deadline=None, derandomize=True, max_examples=120)
@given(graphs())
def test_predecessors_make_trees_that_carry_the_gain(graph: HapticGraph) -> None:
    found = spread(graph)
    explicit = explicit_graph(graph)
    roots = {node for source in graph.sources for node in source.nodes}
    for node in np.flatnonzero(found.amplitude > 0).tolist():
        visited = [node]
        while found.predecessor[visited[-1]] >= 0:
            visited.append(int(found.predecessor[visited[-1]]))
            assert explicit.has_edge(*visited[-2:])
            assert len(visited) <= graph.node_count
            assert found.amplitude[visited[-1]] >= found.amplitude[visited[-2]] * (1 - 1e-12)
        assert visited[-1] in roots
    assert not (found.predecessor[found.amplitude == 0] >= 0).any()


@settings(deadline=None, derandomize=True, max_examples=40)
@given(graphs())
def test_chosen_sources_alone(graph: HapticGraph) -> None:
    together = spread(graph).amplitude
    alone = [spread(graph, {source.name}).amplitude for source in graph.sources]
    assert np.array_equal(together, np.max([np.zeros(graph.node_count), *alone], axis=0))
