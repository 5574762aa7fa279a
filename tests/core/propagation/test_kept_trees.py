"""Trees that are kept while bodies move lead to the paths, bit by bit, of a search in the new graph
alone."""

from __future__ import annotations

import dataclasses
import math
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

SIDE = 8
COUNT = SIDE * SIDE
MOVERS = (0, 9, 10, 15, 20, 45, 46, 60)
"""Bodies that move; the others stand still."""
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
    anywhere. Each has a node of a contact, a source or a listener on itself."""

    def __init__(self, seed: int, kind: str, regular: bool) -> None:
        self.random = np.random.default_rng(seed)
        functions = FUNCTIONS[kind]
        self.home = np.array([(x, y, 0.5) for x, y in product(range(SIDE), repeat=2)], dtype=float)
        if not regular:
            self.home = self.random.uniform(0, SIDE, (COUNT, 3))
        self.spots = self.home.copy()
        names = [*(f"box {k:02d}" for k in range(COUNT)), "ground"]
        self.table = ObjectTable.of(
            [
                HapticObject(
                    name, 0.1, 0.9, functions[(k == COUNT if regular else k) % len(functions)]
                )
                for k, name in enumerate(names)
            ],
            0.1,
        )
        away = np.linalg.norm(self.home[:, None] - self.home, axis=2)
        pairs = [(a, b) for b in range(COUNT) for a in range(b) if away[a, b] < 1.3]
        self.joined = np.array([(k, COUNT) for k in range(COUNT)] + pairs)
        link = Impedance() if kind == "measured" and seed % 4 > 1 else Identity()
        self.contacts = ContactSet.from_contacts(
            [
                Contact((names[a], names[b]), ((0, 0, 0),) * 2, link)
                for a, b in self.joined.tolist()
            ],
            self.table.index(),
        )
        self.area = np.full(len(self.joined), 1e-4)
        self.sources = 2 if seed % 2 else 10  # trees grow from these or from the listeners
        self.loud = True

    def move(self, bodies: list[int], far: float) -> None:
        """Move bodies about their homes, or, not far at all, change the patches on them."""
        away = self.random.normal(0, 1, (len(bodies), 3)) * far
        self.spots[bodies] = self.home[bodies] + away
        if far == 0:
            mine = np.isin(self.joined, bodies).any(axis=1)
            self.area[mine] = self.random.uniform(0, 4, np.count_nonzero(mine))

    def graph(self, before: HapticGraph | None = None) -> HapticGraph:
        """The nodes of a contact lie a bit from the middles of the boxes towards each other, on the
        ground below the box."""
        one, other = self.joined.T
        first = self.spots[one]
        second = np.vstack([self.spots, np.zeros(3)])[other]
        on_ground = other == COUNT
        second[on_ground] = first[on_ground] * (1, 1, 0)
        towards = np.sign(self.home[one] - np.vstack([self.home, np.zeros(3)])[other]) / 2
        towards[on_ground] = 0
        positions = np.stack([first - towards, second + towards], axis=1)
        contacts = dataclasses.replace(self.contacts, positions=positions, area=self.area.copy())
        ends = [(f"box {k:02d}", tuple(self.spots[k].tolist())) for k in range(0, COUNT, 5)]
        sources = tuple(
            Source(f"s{k}", *ends[k], amplitude=float(self.loud or k > 0))
            for k in range(self.sources)
        )
        listeners = tuple(
            Listener(f"l{k}", *ends[k], radius=0.05 * (k % 2))
            for k in range(self.sources, len(ends))
        )
        return build_graph(self.table, contacts, sources, listeners, before=before)


@pytest.mark.parametrize("kind", FUNCTIONS)
@pytest.mark.parametrize("regular", [True, False], ids=["rows", "anywhere"])
def test_kept_trees_hold_the_best_paths(kind, regular):
    """Whether bodies stay, creep, jump or come back, those with sources and listeners included."""

    @settings(max_examples=30, deadline=None, derandomize=True)
    @given(
        st.integers(0, 10**6),
        st.lists(
            st.tuples(
                st.lists(st.sampled_from(MOVERS), max_size=2, unique=True),
                st.sampled_from([0.0, 0.001, 0.1, 3.0]),
                st.sampled_from([True, True, True, False]),
            ),
            min_size=2,
            max_size=8,
        ),
    )
    def check(seed, moves):
        heap, graph, kept = Heap(seed, kind, regular), None, {}
        for bodies, far, heap.loud in moves:
            heap.move(bodies, far)
            graph = heap.graph(graph)
            found = propagate(graph, Settings(), True, kept)
            expected = propagate(heap.graph(), Settings(), True)
            assert dict(found.best_path) == dict(expected.best_path)
            for key in ("gain", "band_gain", "delay"):
                one, other = getattr(found, key), getattr(expected, key)
                assert (one is None) == (other is None)
                assert one is None or one.tobytes() == other.tobytes()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "TINY", 0)
        patch.setattr(shortest_paths, "SPARSE", 0)
        patch.setattr(shortest_paths, "BATCH", 20)
        check()


@pytest.mark.parametrize("moving", [3, 5, 8, 20], ids=["end", "way", "neither", "hand"])
def test_only_what_is_lost_is_found_anew(moving):
    """Posts of 1 m stand in a row, the k-th k m from the source, with two hands on each, but on the
    fifth a table of 1 m with two. A post, or the hands on the last, that move alone take no search."""
    posts = [f"post {k}" for k in range(1, 21)]
    table = ObjectTable.of(
        [HapticObject(name, 0, 1, Exponential(alpha=0.1)) for name in ("ground", "table", *posts)],
        0.1,
    )

    def graph(shift: float, before: HapticGraph | None = None) -> HapticGraph:
        foot = [(k + shift * (k == moving < 20), 0.0, 0.0) for k in range(1, 21)]
        top = [(x, 0.0, 2.0 if k == 5 else 1.0) for k, (x, _, _) in enumerate(foot, 1)]
        top[19] = (20.0, 0.0, 1.0 + shift * (moving == 20))
        below = (foot[4][0], 0.0, 1.0)
        joined = [
            Contact(("post 5", "table"), (below, below), Identity()),
            *(
                Contact(("ground", name), (spot, spot), Identity())
                for name, spot in zip(posts, foot, strict=True)
            ),
        ]
        held = [name.replace("post 5", "table") for name in posts]
        return build_graph(
            table,
            ContactSet.from_contacts(joined, table.index()),
            [Source("s", "ground", (0.0, 0.0, 0.0))],
            [
                Listener(f"{hand} on {on}", on, spot, radius=0.0)
                for on, spot in zip(held, top, strict=True)
                for hand in ("left", "right")
            ],
            before=before,
        )

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "BATCH", 1)
        known, kept = graph(0.0), {}
        propagate(known, Settings(), kept=kept)
        patch.setattr(shortest_paths, "TINY", math.inf)
        patch.setattr(shortest_paths._Search, "one_by_one", None)  # any search would call it
        for shift in (-0.2, 0.0, -0.3, -0.3, -0.1, 0.0):
            known = graph(shift, known)
            found = propagate(known, Settings(), kept=kept)
            far = {
                f"on {'table' if k == 5 else f'post {k}'}": k + shift * (k == moving) + 1 + (k == 5)
                for k in range(1, 21)
            }
            cost = [0.1 * far[name.split(" ", 1)[1]] for name in known.listeners]
            assert found.gain[0] == pytest.approx(np.exp(-np.array(cost)), rel=1e-12)


@pytest.mark.parametrize("walked", ["before", "beyond"])
@pytest.mark.parametrize(
    "frames",
    [
        [(4.0, 0, 0), (3.0, 0, 0), (0.5, 0, 0), (0.25, 0, 0), (2.0, 0, 0)],
        [(4.0, 0, 0), (1.0, 0, 0), (4.0, 0, 0), (0.5, 0, 0), (1.0, 0, 0), (3.0, 0, 0)],
        [(0.25, 0, 0), (2.0, 0, 0), (0.25, 0, 0)],
        [(0.5, 0, 0), (0.5, 3, 0), (0.5, 0, 0)],
        [(0.9, 0, 0), (0.9, 0, 2), (0.9, 0, 1)],
    ],
    ids=["height", "equal", "farther", "loss", "radius"],
)
def test_a_bridge_that_comes_near_is_taken(frames, walked):
    """From one bank of a river to the other a ford, in two parts, costs 2 m and as much along one of
    the banks, and a bridge at some height, with a loss, twice the height and 2 m; less near the
    listener, within its radius. Where both cost the same, the way is that of a search in the new
    graph alone, which takes the one that reaches the other bank at less."""
    names = ["here", "there", "ford", "shoal", "bridge", *(f"stone {k}" for k in range(20))]
    table = ObjectTable.of(
        [HapticObject(name, 0, 1, Exponential(alpha=1.0)) for name in names], 0.1
    )

    def graph(
        height: float, loss: float, radius: float, before: HapticGraph | None = None
    ) -> HapticGraph:
        aside = (2, 0) if walked == "before" else (0, 2)
        left, right = (0.0, 0.0, height), (2.0, 0.0, height)
        joined = [
            Contact(("here", "ford"), ((0, aside[0], 0), (0, 2, 0)), Identity()),
            Contact(("ford", "shoal"), ((1, 2, 0), (1, 2, 0)), Identity()),
            Contact(("shoal", "there"), ((2, 2, 0), (2, aside[1], 0)), Identity()),
            Contact(("here", "bridge"), (left, left), Identity(), weight=math.exp(-loss)),
            Contact(("bridge", "there"), (right, right), Identity()),
            *(Contact(("ford", name), ((9, 9, 9),) * 2, Identity()) for name in names[5:]),
        ]
        return build_graph(
            table,
            ContactSet.from_contacts(joined, table.index()),
            [Source("s", "here", (0.0, 0.0, 0.0))],
            [Listener("l", "there", (2.0, 0.0, 0.0), radius=radius)],
            before=before,
        )

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shortest_paths, "BATCH", 1)
        known, kept = None, {}
        for height, loss, radius in frames:
            known = graph(height, loss, radius, known)
            found = propagate(known, Settings(), kept=kept)
            over = height + 2 + max(height - radius, 0) + loss
            ford = 4 - radius * (walked == "beyond")
            assert found.gain.item() == pytest.approx(np.exp(-min(ford, over)), rel=1e-12)
            expected = propagate(graph(height, loss, radius), Settings())
            assert dict(found.best_path) == dict(expected.best_path)
