"""What the tracker composes, each part alone: poses, near pairs, and when impacts count."""

from __future__ import annotations

from itertools import combinations

import networkx
import numpy as np
import pytest
from haptic_tracing.core.contacts.body_poses import BodyPoses
from haptic_tracing.core.contacts.body_table import BodyTable
from haptic_tracing.core.contacts.impacts import Hits
from haptic_tracing.core.contacts.motion import MotionHistory
from haptic_tracing.core.contacts.near_pairs import NearPairs
from haptic_tracing.core.contacts.recent_impacts import RecentImpacts
from haptic_tracing.core.contacts.settings import Body, ContactSettings
from haptic_tracing.core.contacts.shapes import Box

CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
GROW = 0.01


def turned_at_random(generator, count):
    """Matrices (n, 4, 4) of random rotations and places."""
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3, :3] = np.linalg.qr(generator.normal(size=(count, 3, 3)))[0]
    matrices[:, :3, 3] = generator.uniform(-2, 2, (count, 3))
    return matrices


def boxes(generator, count):
    sizes = generator.uniform(0.2, 1.0, (count, 3))
    return BodyTable([Body(f"box {k}", Box(tuple(size))) for k, size in enumerate(sizes)]), sizes


def test_extents_are_those_of_the_corners():
    """Boxes in random poses: the bounding boxes of their corners, grown; what has no finite pose is
    nowhere, and is placed anew when it has one again."""
    generator = np.random.default_rng(1)
    table, sizes = boxes(generator, 30)
    poses = BodyPoses(30)
    matrices = turned_at_random(generator, 30)
    corners = np.einsum("nij,nkj->nki", matrices[:, :3, :3], CORNERS * sizes[:, None])
    corners += matrices[:, None, :3, 3]
    _, moved, left, lost = poses.place(table, matrices, GROW)
    assert moved.tolist() == left.tolist() == list(range(30)) and len(lost) == 0
    expected = np.stack([-corners.min(axis=1).T, corners.max(axis=1).T]) + GROW
    np.testing.assert_allclose(poses.extents, expected, atol=1e-12)
    broken = matrices.copy()
    broken[7, 0, 0] = np.nan
    _, moved, _, lost = poses.place(table, broken, GROW)
    assert moved.tolist() == lost.tolist() == [7]
    assert np.isneginf(poses.extents[..., 7]).all() and poses.version[7] == 2
    _, moved, _, _ = poses.place(table, matrices, GROW)
    assert moved.tolist() == [7]
    np.testing.assert_allclose(poses.extents, expected, atol=1e-12)


def test_near_pairs_and_heaps_while_boxes_drift():
    """Every two boxes that overlap are near and met, none met that do not (by comparing all), and
    heaps are the connected components that NetworkX finds."""
    generator = np.random.default_rng(2)
    table, _ = boxes(generator, 40)
    poses, near, history = BodyPoses(40), NearPairs(40), MotionHistory(40)
    matrices = turned_at_random(generator, 40)
    speeds = generator.normal(size=(40, 3)) * 0.05
    seen = set()
    for frame in range(30):
        matrices[:20, :3, 3] += speeds[:20]
        columns, moved, left, _ = poses.place(table, matrices, GROW)
        history.advance(frame / 24, columns, left)
        near.widen(table, history, poses.extents, moved)
        low, high = -poses.extents[0].T, poses.extents[1].T
        overlapping = {
            (a, b)
            for a, b in combinations(range(40), 2)
            if (low[a] <= high[b]).all() and (low[b] <= high[a]).all()
        }
        met = near.met(poses.extents)
        assert {tuple(pair) for pair in table.numbers(near.key[met]).tolist()} == overlapping
        seen |= overlapping
        graph = networkx.Graph(table.numbers(near.key).tolist())
        graph.add_nodes_from(range(40))
        some = generator.random(40) < 0.1
        reached = set().union(
            *(part for part in networkx.connected_components(graph) if some[list(part)].any())
        )
        assert set(near.in_heaps_of(some).nonzero()[0].tolist()) == reached
    assert len(seen) > len(overlapping) > 5


@pytest.mark.parametrize(
    ("after", "speed", "parted", "counts"),
    [
        (0.02, 1.0, True, False),  # within the refractory time, no stronger
        (0.02, 1.3, True, True),  # a clearly stronger one
        (0.5, 1.0, True, True),
        (0.5, 1.0, False, False),  # it has not parted since
        (0.5, 1.3, False, True),
        (0.5, 0.01, True, False),  # too little energy
    ],
)
def test_when_a_second_hit_is_an_impact(after, speed, parted, counts):
    """A ball of 2 kg hits a fixed body twice, with an energy of m v² / 2."""
    bodies = [Body("ball", Box((1, 1, 1)), 2.0), Body("wall", Box((1, 1, 1)), motion="static")]
    table = BodyTable(bodies)
    recent = RecentImpacts(
        ContactSettings(energy="effective", least_energy=0.1, full_energy=4.0, refractory=0.1)
    )

    def hit(time, approach, struck):
        one = np.ones(1)
        hits = Hits(
            pairs=np.array([[0, 1]]),
            after=0 * one,
            time=0 * one,
            distance=0 * one,
            normal=np.array([[0.0, 0.0, 1.0]]),
            centre=np.zeros((1, 3)),
            approach=approach * one,
            poses=np.tile(np.concatenate([np.eye(3).ravel(), np.zeros(3)]), (1, 2, 1)),
            velocities=np.zeros((1, 2, 3)),
            spins=np.zeros((1, 2, 3)),
            expected=0 * one,
            actual=0 * one,
            passes=np.zeros(1, dtype=bool),
        )
        estimated = np.zeros(1, dtype=np.bool_)
        return recent.of(hits, time, np.array([struck]), estimated, bodies, table)

    (first,) = hit(1.0, 1.0, False)
    assert first.time == 1.0 and first.energy == pytest.approx(1.0)
    assert first.amplitude == pytest.approx(0.25)
    found = hit(1.0 + after, speed, not parted)
    assert [blow.energy for blow in found] == pytest.approx([speed**2] if counts else [])
    recent.expire(3.0, 0.1)
    assert len(recent.keys()) == 0
