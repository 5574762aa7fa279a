"""The walk operator against its dense matrix: spectral radius by LAPACK, sums over walks by a
linear solve."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import (
    HapticGraph,
    ObjectTable,
    build_graph,
    graph_of_scene,
)
from haptic_tracing.core.message import Cause
from haptic_tracing.core.propagation import propagate, walk_radius
from haptic_tracing.core.propagation.walk_radius import WalkOperator, WalkRadius
from haptic_tracing.core.scene.functions import Constant, Exponential, Identity
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Settings,
    Source,
    Strategy,
)
from hypothesis import example, given, settings
from hypothesis import strategies as st
from path_reference import METRIC, OTHER, connected_scene, recursive_paths

SEEDS = st.integers(0, 10**6)
ORIGIN = (0.0, 0.0, 0.0)
ALL = Settings(strategy=Strategy.ALL_PATHS)


def dense_operator(graph: HapticGraph) -> tuple[np.ndarray, np.ndarray]:
    """The walk operator by its definition, entry by entry from the explicit graph; and the nodes of
    its rows."""
    explicit = graph.to_networkx()
    nodes = np.flatnonzero(graph.partner >= 0)
    number = {node: k for k, node in enumerate(nodes.tolist())}

    matrix = np.zeros((len(nodes), len(nodes)))
    for a in nodes.tolist():
        for b, edge in explicit.adj[a].items():
            if edge["connection"] == "intra" and graph.partner[b] >= 0 and a != b:
                crossing = explicit.edges[b, int(graph.partner[b])]
                matrix[number[a], number[int(graph.partner[b])]] = edge["gain"] * crossing["gain"]
    return matrix, nodes


def radius(matrix: np.ndarray) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))


@pytest.mark.slow
@settings(max_examples=150, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0, 2, 6]), st.sampled_from([1, 3, 24]))
@example(949, 6, 1)  # a ring that lets nothing through
def test_radius_of_random_scenes(seed, extra, dense):
    """The bounds enclose the largest eigenvalue; a forest has 0. Also with the operator partly as
    dense matrices."""
    graph = graph_of_scene(connected_scene(seed, (*METRIC, *OTHER), extra=extra, refined=True))
    matrix, _ = dense_operator(graph)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(walk_radius, "DENSE", dense)
        found = WalkOperator(graph).radius
    exact = radius(matrix)
    # LAPACK finds the eigenvalues of a nilpotent matrix only to about this.
    assert found.low <= exact + 1e-7
    assert exact <= found.high * (1 + 1e-9) + 1e-4 * (found.high == 0)
    if extra == 0:
        assert found.high == 0
    assert found.well_posed == (found.high < 1)
    assert propagate(graph, ALL).statistics["walk_radius"] == pytest.approx(found.value, rel=1e-9)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0.3, 0.6, 0.9]))
def test_radius_of_a_part_of_the_contacts_is_a_lower_bound(seed, gain):
    """All contacts are examined unless it is 1 or more."""
    graph = graph_of_scene(
        connected_scene(
            seed, (Constant(gain_value=gain), Exponential(alpha=1.0)), extra=6, refined=True
        )
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(walk_radius, "EXCERPTS", (3, 5))
        found = WalkOperator(graph).radius
    exact = radius(dense_operator(graph)[0])
    assert found.low <= exact + 1e-7
    assert found.low >= 1 or exact <= found.high * (1 + 1e-9) + 1e-4 * (found.high == 0)
    assert not (found.well_posed and exact >= 1)


@pytest.mark.parametrize("alpha", [1.0, 4.0])
def test_pile_on_a_large_ground(alpha):
    """Decided as by all eigenvalues, with a lower bound that is not far from the radius."""
    generator = np.random.default_rng(3)
    places = generator.uniform(0, 8, (160, 3)) * [1, 1, 0]
    names = [f"box {k:03d}" for k in range(160)]
    objects = tuple(
        HapticObject(name, 0, 1, Exponential(alpha=alpha)) for name in (*names, "ground")
    )
    pairs = [(name, "ground") for name in names] + list(itertools.pairwise(names))
    where = [*places, *((places[1:] + places[:-1]) / 2)]
    contacts = tuple(
        Contact(pair, (tuple(place), tuple(place)))
        for pair, place in zip(pairs, where, strict=True)
    )
    graph = graph_of_scene(HapticScene(objects, contacts))
    nodes = np.flatnonzero(graph.partner >= 0)
    apart = np.linalg.norm(graph.node_position[nodes, None] - graph.node_position[nodes], axis=2)
    inside = (graph.node_object[nodes, None] == graph.node_object[nodes]) & ~np.eye(
        len(nodes), dtype=bool
    )
    matrix = np.where(inside, np.exp(-alpha * apart), 0.0)[
        :, np.searchsorted(nodes, graph.partner[nodes])
    ]
    found, exact = WalkOperator(graph).radius, radius(matrix)
    assert 0.7 * exact <= found.low <= exact <= found.high
    assert found.well_posed == (exact < 1)


def lattice(rows: int, columns: int, gain: float, share: float = 1.0) -> HapticScene:
    objects = tuple(
        HapticObject(f"{i:02d} {j:02d}", 0, 1, Constant(gain_value=gain))
        for i in range(rows)
        for j in range(columns)
    )
    pairs = [
        (f"{i:02d} {j:02d}", f"{i + 1:02d} {j:02d}")
        for i in range(rows - 1)
        for j in range(columns)
    ]
    pairs += [
        (f"{i:02d} {j:02d}", f"{i:02d} {j + 1:02d}")
        for i in range(rows)
        for j in range(columns - 1)
    ]
    contacts = tuple(Contact(pair, (ORIGIN, ORIGIN)) for pair in pairs)
    ends = objects[0].name, objects[-1].name
    return HapticScene(objects, contacts, (Source("s", ends[0]),), (Listener("l", ends[1]),))


@pytest.mark.parametrize("gain", [0.2, 0.36, 0.38, 0.6])
def test_radius_of_grids_is_precise(gain):
    graph = graph_of_scene(lattice(8, 8, gain))
    found = WalkOperator(graph).radius
    exact = radius(dense_operator(graph)[0])
    assert found.low <= exact <= found.high
    assert found.high - found.low <= 0.02 * exact
    assert found.well_posed == (exact < 1)


def test_several_parts_and_long_chains():
    """The largest radius of any part; chains that hang on it add nothing."""
    rings = []
    for name, gain in (("weak", 0.3), ("strong", 0.9)):
        names = [f"{name} {k}" for k in range(5)]
        rings.append((names, gain, [(names[k], names[k - 1]) for k in range(5)]))
    tail = [f"tail {k:03d}" for k in range(100)]
    objects = tuple(
        HapticObject(n, 0, 1, Constant(gain_value=g))
        for names, g, _ in (*rings, (tail, 1.0, []))
        for n in names
    )
    pairs = [pair for _, _, ring in rings for pair in ring]
    pairs += [(tail[k], tail[k + 1]) for k in range(99)] + [(tail[0], "strong 0")]
    graph = graph_of_scene(
        HapticScene(objects, tuple(Contact(pair, (ORIGIN, ORIGIN)) for pair in pairs))
    )
    found = WalkOperator(graph).radius
    assert found.low <= 0.9 <= found.high
    assert found.high - found.low < 0.01


def test_hub_too_large_to_examine():
    """A sum then counts as limited, without a bound."""
    count = 60
    names = [f"p{k:02d}" for k in range(count)]
    objects = (
        HapticObject("ground", 0, 1, Constant(gain_value=0.1)),
        *(HapticObject(n, 0, 1, Constant(gain_value=0.1)) for n in names),
    )
    contacts = tuple(
        Contact(("ground", n), ((0, 0, k), (0, 0, k))) for n in names for k in range(2)
    )
    graph = graph_of_scene(
        HapticScene(objects, contacts, (Source("s", names[0]),), (Listener("l", names[1]),))
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(walk_radius, "PAIRS", 1000)
        result = propagate(graph, ALL)
    assert result.statistics["walk_radius"] == math.inf
    assert result.limited[0, 0]
    assert result.error_bound[0, 0] == math.inf


@settings(max_examples=100, deadline=None, derandomize=True)
@given(SEEDS, st.booleans())
@example(377980, False)  # a radius of 0.988
def test_sums_over_walks(seed, refined):
    """Never less than the Neumann series' closed form, and not much more where a thousand terms
    leave nothing that counts."""
    graph = graph_of_scene(
        connected_scene(
            seed,
            (Constant(gain_value=0.3), Exponential(alpha=3.0)),
            extra=4,
            listeners=3,
            refined=refined,
        )
    )
    operator = WalkOperator(graph)
    matrix, nodes = dense_operator(graph)
    explicit = graph.to_networkx()
    totals = operator.totals(graph.sources[0].nodes, graph.listener_nodes.tolist())
    if totals is None:
        assert not operator.radius.well_posed
        return
    for listener, total in zip(graph.listener_nodes.tolist(), totals.tolist(), strict=True):

        def inside(a: int, b: int) -> float:
            edge = explicit.adj[a].get(b, {})
            return edge.get("gain", 0.0) if edge.get("connection") == "intra" else 0.0

        last = np.array([inside(node, listener) for node in nodes.tolist()])
        onwards = np.linalg.solve(np.eye(len(nodes)) - matrix, last)
        expected = 0.0
        for root in graph.sources[0].nodes:
            expected += inside(root, listener)
            for number, node in enumerate(nodes.tolist()):
                crossing = explicit.edges[node, int(graph.partner[node])]
                expected += (
                    inside(root, int(graph.partner[node])) * crossing["gain"] * onwards[number]
                )
        assert expected * (1 - 1e-9) <= total < math.inf
        # 0.95**1000 is 5e-23.
        assert total <= expected * (1 + 1e-6) + 1e-300 or operator.radius.high > 0.95


def ring_of_three(gain: float) -> HapticGraph:
    objects = tuple(HapticObject(name, 0, 1, Constant(gain_value=gain)) for name in "abc")
    contacts = tuple(
        Contact(pair, (ORIGIN, ORIGIN)) for pair in (("a", "b"), ("b", "c"), ("c", "a"))
    )
    return graph_of_scene(
        HapticScene(objects, contacts, (Source("s", "a"),), (Listener("l", "b"),))
    )


def test_ring_that_lets_nothing_through():
    assert WalkOperator(ring_of_three(0.0)).radius == WalkRadius(0.0, 0.0)


@pytest.mark.parametrize("gain", [0.5, 0.97, 0.99, 0.999, 0.9999])
def test_radius_just_below_1(gain):
    """Also a series of more than a thousand terms has a bound. What the terms left out add is
    bounded as if they arrived by every contact in every step; they do in every third."""
    graph = ring_of_three(gain)
    exact = (gain**2 + gain**3) / (1 - gain**3)
    (total,) = (
        WalkOperator(graph).totals(graph.sources[0].nodes, graph.listener_nodes.tolist()).tolist()
    )
    assert exact * (1 - 1e-9) <= total <= exact * (1 + 2 * gain**walk_radius.TERMS + 1e-8)
    assert math.isfinite(propagate(graph, ALL).error_bound[0, 0])


@pytest.mark.parametrize("threshold", [1e-3, 0.05, 0.3])
def test_in_a_forest_the_bound_is_what_the_threshold_leaves_out(threshold):
    """One path leads to each listener: it is summed, or it is the bound."""
    gains = (0.9, 0.5, 0.2, 0.1, 0.6, 0.3)
    objects = tuple(
        HapticObject(f"o{k}", 0, 1, Constant(gain_value=gain)) for k, gain in enumerate(gains)
    )
    contacts = tuple(Contact((f"o{k}", f"o{k + 1}"), (ORIGIN, ORIGIN)) for k in range(5))
    scene = HapticScene(
        objects,
        contacts,
        (Source("s", "o0"),),
        tuple(Listener(f"l{k}", f"o{k}", (0, 0, 1)) for k in range(6)),
    )
    result = propagate(
        graph_of_scene(scene), Settings(strategy=Strategy.ALL_PATHS, threshold=threshold)
    )
    assert result.statistics["walk_radius"] == 0
    for k in range(6):
        gain = math.prod(gains[: k + 1])
        found, error, limited = result.gain[0, k], result.error_bound[0, k], result.limited[0, k]
        assert (found, error, limited) == (
            (pytest.approx(gain), 0, False) if gain >= threshold else (0, pytest.approx(gain), True)
        )
    causes = {warning.cause for warning in result.warnings}
    assert causes == ({Cause.SUM_TRUNCATED} if result.limited.any() else set())


@pytest.mark.slow
@settings(max_examples=80, deadline=None, derandomize=True)
@given(SEEDS, st.sampled_from([0.0, 1e-3, 0.03]), st.sampled_from([None, 5]))
def test_bound_of_a_well_posed_sum_is_finite_and_kept(seed, threshold, most):
    """The sum over all paths lies within it, and what is not limited is known to the tolerance."""
    graph = graph_of_scene(
        connected_scene(
            seed, (Constant(gain_value=0.2), Exponential(alpha=3.0)), extra=4, listeners=3
        )
    )
    chosen = Settings(strategy=Strategy.ALL_PATHS, threshold=threshold, max_connections=most)
    result = propagate(graph, chosen)
    if result.statistics["walk_radius"] >= 1:
        return
    for column in range(len(graph.listeners)):
        true = math.fsum(math.prod(gains) for _, gains in recursive_paths(graph, 0, column))
        gain, error = result.gain[0, column], result.error_bound[0, column]
        assert gain * (1 - 1e-12) <= true <= (gain + error) * (1 + 1e-9)
        assert math.isfinite(error)
        if not result.limited[0, column]:
            assert true <= gain * (1 + chosen.tolerance) * (1 + 1e-9)


@pytest.mark.parametrize("size", [10, 14])
def test_a_known_path_is_a_floor(size):
    """Grids of gain 0.4, without limits: too many paths to sum, but the best one counts."""
    graph = graph_of_scene(lattice(size, size, 0.4))
    result = propagate(
        graph, Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0), 20_000
    )
    best = 0.4 ** (2 * size - 1)
    assert result.gain[0, 0] >= best * (1 - 1e-12)


def test_sum_without_limits_says_its_radius_too():
    scene = HapticScene(
        tuple(HapticObject(name, 0, 1, Identity()) for name in "abc"),
        tuple(Contact(pair, (ORIGIN, ORIGIN)) for pair in (("a", "b"), ("b", "c"), ("c", "a"))),
        (Source("s", "a"),),
        (Listener("l", "b"),),
    )
    result = propagate(
        graph_of_scene(scene),
        Settings(strategy=Strategy.ALL_PATHS, max_connections=None, threshold=0.0),
    )
    assert (result.gain[0, 0], result.error_bound[0, 0], result.limited[0, 0]) == (
        pytest.approx(2),
        0,
        False,
    )
    assert result.statistics["walk_radius"] == pytest.approx(1, rel=1e-6)


def test_an_empty_scene_has_no_walks():
    table = ObjectTable.of((HapticObject("a", 0, 1),), 0.1)
    assert WalkOperator(build_graph(table, ContactSet.empty(), (), ())).radius.high == 0
