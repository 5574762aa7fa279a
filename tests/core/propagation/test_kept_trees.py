"""Trees that are kept while bodies move lead to the paths, bit by bit, of a search in the new graph
alone."""

from __future__ import annotations

import dataclasses
from itertools import product

import numpy as np
import pytest
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from haptic_tracing.core.propagation import propagate, shortest_paths
from haptic_tracing.core.scene.functions import (
    Constant,
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

SIDE = 6
COUNT = SIDE * SIDE
FUNCTIONS = {
    "plain": (HapticTracing(), Exponential(alpha=0.4)),
    "measured": (
        Physical(wave=Wave.SURFACE, density=1700.0, phase_speed=200.0, reference_distance=0.5),
        Physical(density=7850.0, phase_speed=5100.0, thickness=0.05, extent=0.4),
        Physical(density=700.0, phase_speed=3000.0, thickness=0.02, reference_distance=0.02),
    ),
    "free": (Constant(gain_value=1.0), Constant(gain_value=0.5), Constant(gain_value=0.25)),
    "special": (HapticTracing(), Linear(range=9.0)),
}


class Heap:
    """Boxes on a ground that touch their neighbours: in rows, where many paths cost the same, or
    anywhere."""

    def __init__(self, seed: int, kind: str, regular: bool) -> None:
        self.random = np.random.default_rng(seed)
        functions = FUNCTIONS[kind]
        self.home = np.array([(x, y, 0.5) for x, y in product(range(SIDE), repeat=2)], dtype=float)
        if not regular:
            self.home = self.random.uniform(0, SIDE, (COUNT, 3))
        self.spots = self.home.copy()
        names = [f"box {k:02d}" for k in range(COUNT)]
        self.table = ObjectTable.of(
            [
                HapticObject(
                    name,
                    0.1,
                    0.9,
                    functions[int(name == "ground") if regular else k % len(functions)],
                )
                for k, name in enumerate([*names, "ground"], start=1)
            ],
            0.1,
        )
        away = np.linalg.norm(self.home[:, None] - self.home, axis=2)
        pairs = [(a, b) for b in range(COUNT) for a in range(b) if away[a, b] < 1.3]
        self.joined = np.array([(k, COUNT) for k in range(COUNT)] + pairs)
        link = Impedance() if kind == "measured" else Identity()
        self.contacts = ContactSet.from_contacts(
            [
                Contact((names[a], "ground" if b == COUNT else names[b]), ((0, 0, 0),) * 2, link)
                for a, b in self.joined.tolist()
            ],
            self.table.index(),
        )
        self.move(list(range(COUNT)), 0.0)
        ends = [(names[k], tuple(self.spots[k].tolist())) for k in range(0, COUNT, 5)]
        self.sources = tuple(Source(f"s{k}", *ends[k]) for k in range(2))
        self.listeners = tuple(
            Listener(f"l{k}", *ends[k], radius=0.05 * (k % 2)) for k in range(2, len(ends))
        )

    def move(self, bodies: list[int], far: float) -> None:
        """Move bodies about their homes, and their contacts, which lie halfway between two."""
        away = self.random.normal(0, 1, (len(bodies), 3)) * far
        self.spots[bodies] = self.home[bodies] + away
        middle = np.vstack([self.spots, np.zeros(3)])[self.joined].mean(axis=1)
        on_ground = self.joined[:, 1] == COUNT
        middle[on_ground] = self.spots[self.joined[on_ground, 0]] * (1, 1, 0)
        self.contacts = dataclasses.replace(
            self.contacts, positions=np.stack([middle, middle], axis=1)
        )

    def graph(self, before: HapticGraph | None = None) -> HapticGraph:
        return build_graph(self.table, self.contacts, self.sources, self.listeners, before=before)


@pytest.mark.parametrize("batch", [1, 20, 300])
@pytest.mark.parametrize("kind", FUNCTIONS)
@pytest.mark.parametrize("regular", [True, False], ids=["rows", "anywhere"])
def test_kept_trees_hold_the_best_paths(kind, regular, batch):
    """Whether bodies stay, creep, jump or come back, those with sources and listeners included."""

    @settings(max_examples=30, deadline=None, derandomize=True)
    @given(
        st.integers(0, 10**6),
        st.lists(
            st.tuples(
                st.lists(st.integers(0, COUNT - 1), max_size=3, unique=True),
                st.sampled_from([0.0, 0.001, 0.1, 3.0]),
            ),
            min_size=1,
            max_size=8,
        ),
    )
    def check(seed, moves):
        heap, graph, kept = Heap(seed, kind, regular), None, {}
        for bodies, far in moves:
            heap.move(bodies, far)
            graph = heap.graph(graph)
            found = propagate(graph, Settings(), kept=kept)
            expected = propagate(heap.graph(), Settings())
            assert dict(found.best_path) == dict(expected.best_path)
            for key in ("gain", "band_gain", "delay"):
                one, other = getattr(found, key), getattr(expected, key)
                assert (one is None) == (other is None)
                assert one is None or one.tobytes() == other.tobytes()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "TINY", 0)
        patch.setattr(shortest_paths, "SPARSE", 0)
        patch.setattr(shortest_paths, "BATCH", batch)
        check()
