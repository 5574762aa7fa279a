"""Shortest paths of piles of bodies that conduct better than the ground under them, where most
entries of the ground are left out: against SciPy's Dijkstra on the explicit graph."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.graph.haptic_graph import HapticGraph, graph_of_scene
from haptic_tracing.core.propagation import shortest_paths
from haptic_tracing.core.scene.functions import Constant, Identity, Physical, Wave
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Source,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

FREE = 1e-300
"""Cost that stands for 0, which in a sparse matrix means no connection."""
GROUNDS = (
    Physical(wave=Wave.SURFACE, reference_distance=0.05, loss_factor=0.1, phase_speed=200.0),
    Physical(reference_distance=0.5, loss_factor=0.0),
    Physical(reference_distance=0.3, thickness=2.3, extent=2.3, loss_factor=0.05),
    Physical(
        wave=Wave.BOUNDED,
        reference_distance=0.1,
        thickness=0.4,
        extent=3.0,
        loss_factor=0.2,
    ),
)
BOXES = (
    Identity(),
    Constant(gain_value=0.98),
    Physical(wave=Wave.LIMB, loss_factor=0.01),
    Physical(wave=Wave.BOUNDED, reference_distance=0.2, thickness=0.3, extent=0.4),
)


def pile(seed: int, side: int) -> HapticScene:
    """Boxes in rows on a ground, most of them touching the next one, with sources and listeners on
    boxes and on the ground. Positions may be equal, contacts may pass nothing."""
    random = np.random.default_rng(seed)
    apart, jitter = random.choice([0.1, 0.6, 3.0]), random.choice([0.0, 0.1, 1.0])
    walls = random.random() < 0.2
    ground, alike = random.choice(len(GROUNDS)), random.choice(len(BOXES))
    objects = [HapticObject("ground", 0.1, 0.9, GROUNDS[ground])]
    contacts = []
    centres = {}
    for i in range(side):
        for j in range(side):
            centre = apart * (np.array([i, j, 0.0]) + jitter * random.uniform(-1, 1, 3))
            centres[i, j] = centre[[2, 0, 1]] if walls else centre
            kind = alike if random.random() < 0.9 else random.integers(len(BOXES))
            objects.append(HapticObject(f"box {i} {j}", 0.1, 0.9, BOXES[kind]))
    for (i, j), centre in centres.items():
        place = tuple((np.round(centre, 1) if random.random() < 0.1 else centre).tolist())
        touching = [("ground", 0.95)]
        touching += [(f"box {i} {j + 1}", 0.8)] * (j + 1 < side)
        touching += [(f"box {i + 1} {j}", 0.1)] * (i + 1 < side)
        for other, likely in touching:
            if random.random() < likely:
                contacts.append(
                    Contact(
                        (f"box {i} {j}", other),
                        (place, place),
                        Constant(gain_value=float(random.choice([0.0, 0.5, 0.9, 1.0, 1.0, 1.0]))),
                        area=float(random.choice([0.0, 0.01, 0.3])),
                        normal=(0, 0, 1),
                    )
                )
    on = ["ground", "ground", *(f"box {i} {j}" for i, j in centres)]

    def spot() -> tuple[str, tuple[float, ...]]:
        return on[random.integers(len(on))], tuple(random.uniform(0, apart * side, 3).tolist())

    sources = [Source(f"s{k}", *spot()) for k in range(3)]
    sources.append(Source("s3", sources[0].object, sources[1].position))
    radius = 0.3 if random.random() < 0.3 else 0.0
    listeners = [Listener(f"l{k}", *spot(), radius=radius) for k in range(4)]
    return HapticScene(tuple(objects), tuple(contacts), tuple(sources), tuple(listeners))


def by_scipy(graph: HapticGraph) -> np.ndarray:
    """Cost from each source to each listener; nothing passes through a listener."""
    ends = np.column_stack(np.triu_indices(graph.node_count, 1))
    a, b = ends[graph.node_object[ends[:, 0]] == graph.node_object[ends[:, 1]]].T
    inside = np.add(
        *graph.table.costs(graph.node_object[a], graph.node_distances(a, b), graph.ends(a, b))
    )
    one = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    other = graph.partner[one]
    over = graph.transmission_loss[graph.contact[one]].T
    cost = np.concatenate([inside, over[0], inside, over[1]])
    begin = np.concatenate([a, one, b, other])
    end = np.concatenate([b, other, a, one])
    used = np.flatnonzero((cost < math.inf) & ~np.isin(begin, graph.listener_nodes))
    matrix = coo_array(
        (np.maximum(cost[used], FREE), (begin[used], end[used])),
        shape=(graph.node_count, graph.node_count),
    ).tocsr()
    roots = [source.nodes[0] for source in graph.sources]
    return np.asarray(dijkstra(matrix, indices=roots)[:, graph.listener_nodes])


def check(seed: int, side: int, limit: float) -> None:
    """Sources of three bands; one tree of two roots; trees to the listeners, and complete ones."""
    graph = graph_of_scene(pile(seed, side))
    bands = [0, 3, 3, 5, 0]
    starts = [source.nodes for source in graph.sources]
    roots = [*starts, starts[0] + starts[1]]
    expected = np.array(
        [by_scipy(graph.in_band(band))[row] for row, band in enumerate(bands[:4])]
        + [by_scipy(graph.in_band(0))[:2].min(axis=0)]
    )
    expected[expected > limit] = math.inf
    sought = graph.listener_nodes
    for targets in (None, [sought] * len(roots)):
        trees = shortest_paths.shortest_paths(graph, roots, bands, targets, limit=limit)
        np.testing.assert_allclose(trees.cost[:, sought], expected, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("batch", [1, 400, 1 << 15])
def test_costs(batch):
    @settings(max_examples=60, deadline=None, derandomize=True)
    @given(
        st.integers(0, 10**6), st.sampled_from([4, 8]), st.sampled_from([1.0, 3.0, 1e300, math.inf])
    )
    def compare(seed, side, limit):
        check(seed, side, limit)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "BATCH", batch)
        compare()
