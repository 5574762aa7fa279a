"""Best paths that are kept while bodies move are, bit by bit, those of a search from the
beginning."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import ObjectTable, build_graph
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.propagation.best_path import best_paths
from haptic_tracing.core.propagation.kept_paths import KeptPaths
from haptic_tracing.core.scene.functions import (
    Exponential,
    HapticTracing,
    Identity,
    Impedance,
    Linear,
)
from haptic_tracing.core.scene.functions.physical import Physical, Wave
from haptic_tracing.core.scene.values import Contact, HapticObject, Listener, Settings, Source
from hypothesis import given, settings
from hypothesis import strategies as st

COUNT = 30
FUNCTIONS = {
    "plain": (HapticTracing(), Exponential(alpha=0.4)),
    "measured": (
        Physical(wave=Wave.SURFACE, density=1700.0, phase_speed=200.0, reference_distance=0.5),
        Physical(density=7850.0, phase_speed=5100.0, thickness=0.05, extent=0.4),
        Physical(density=700.0, phase_speed=3000.0, thickness=0.02, reference_distance=0.02),
    ),
    "special": (HapticTracing(), Linear(range=9.0)),
}


class Heap:
    """Boxes on a ground that touch their neighbours."""

    def __init__(self, seed: int, kind: str) -> None:
        self.random = np.random.default_rng(seed)
        functions = FUNCTIONS[kind]
        self.spots = self.random.uniform(0, 4, (COUNT, 3))
        names = [f"box {k:02d}" for k in range(COUNT)]
        self.table = ObjectTable.of(
            [
                HapticObject(name, 0.1, 0.9, functions[k % len(functions)])
                for k, name in enumerate(["ground", *names])
            ],
            0.1,
        )
        away = np.linalg.norm(self.spots[:, None] - self.spots, axis=2)
        pairs = [(a, b) for b in range(COUNT) for a in range(b) if away[a, b] < 1.2]
        self.joined = np.array([(k, COUNT) for k in range(COUNT)] + pairs)
        link = Impedance() if kind == "measured" else Identity()
        self.contacts = ContactSet.from_contacts(
            [
                Contact((names[a], "ground" if b == COUNT else names[b]), ((0, 0, 0),) * 2, link)
                for a, b in self.joined.tolist()
            ],
            self.table.index(),
        )
        self.place(np.ones(len(self.joined), dtype=np.bool_))
        ends = [(names[k], tuple(self.spots[k].tolist())) for k in range(8)]
        self.sources = tuple(Source(f"s{k}", *ends[k]) for k in range(2))
        self.listeners = tuple(
            Listener(f"l{k}", *ends[k], radius=0.05 * (k % 2)) for k in range(2, 8)
        )

    def place(self, rows: np.ndarray) -> None:
        """Put contacts between their two bodies."""
        far = np.vstack([self.spots, [2.0, 2.0, -1.0]])
        positions = self.contacts.positions.copy()
        middle = far[self.joined].mean(axis=1) + self.random.normal(0, 0.02, (len(self.joined), 3))
        positions[rows] = middle[rows, None]
        self.contacts = dataclasses.replace(self.contacts, positions=positions)

    def move(self, bodies: list[int], far: float) -> None:
        self.spots[bodies] += self.random.normal(0, far, (len(bodies), 3))
        self.place(np.isin(self.joined, bodies).any(axis=1))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.integers(0, 10**6),
    st.sampled_from(sorted(FUNCTIONS)),
    st.lists(
        st.tuples(
            st.lists(st.integers(0, COUNT - 1), max_size=4, unique=True),
            st.sampled_from([0.001, 0.1, 3.0]),
        ),
        min_size=1,
        max_size=6,
    ),
)
def test_kept_paths_are_the_best_ones(seed, kind, moves):
    """Whether bodies stay, creep or jump, those with sources and listeners included."""
    heap = Heap(seed, kind)
    search, graph = KeptPaths(least=0), None
    for bodies, far in moves:
        heap.move(bodies, far)
        ends = heap.table, heap.contacts, heap.sources, heap.listeners
        graph = build_graph(*ends, before=graph)
        found = propagate(graph, Settings(), search=search)
        expected = propagate(build_graph(*ends), Settings())
        assert found.gain.tobytes() == expected.gain.tobytes()
        assert dict(found.best_path) == dict(expected.best_path)


@pytest.mark.parametrize("kind", ["plain", "measured"])
def test_paths_beside_what_moves_are_kept(kind):
    """Of bodies that no path crosses, as they are large or far away, most motions keep the paths,
    but none that makes one of them a short cut."""
    wanted = np.ones((2, 6), dtype=np.bool_)
    kept = opened = 0
    for seed in range(60):
        heap = Heap(seed, kind)
        mover = [8 + seed % (COUNT - 8)]
        here = heap.spots[mover].copy()
        heap.spots[mover] += 9.0
        heap.place(np.isin(heap.joined, mover).any(axis=1))
        graph = build_graph(heap.table, heap.contacts, heap.sources, heap.listeners)
        search = KeptPaths(least=0)
        before = search(graph, wanted)
        if seed % 3:
            heap.spots[mover] = here
        heap.move(mover, 0.01)
        graph = build_graph(heap.table, heap.contacts, heap.sources, heap.listeners, before=graph)
        stays = dict(best_paths(graph, wanted).paths) == dict(before.paths)
        found = search(graph, wanted)
        assert stays or found is not before
        kept += found is before
        opened += not stays
    assert kept > 15
    assert opened > 2
