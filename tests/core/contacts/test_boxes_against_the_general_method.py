"""Pairs of single boxes against the general method, which has its own patches, and against SciPy
and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.narrow.boxes import box_contacts
from haptic_tracing.core.contacts.narrow.manifold import ROUGHNESS
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.shapes import Box, Compound, pose_matrix
from haptic_tracing.core.scene.values import Pose
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

COUNT = 300
SIZES = ((1.0, 1.0, 1.0), (1.3, 0.6, 0.2))


def placed(seed: int, tilt: float, square: bool):
    """Random places of two boxes near touching: turned by ``tilt`` radians, or exactly upright
    about some axes."""
    generator = np.random.default_rng(seed)
    turn = generator.normal(size=(3, COUNT)) * tilt
    if square:
        turn *= generator.integers(0, 2, (3, COUNT))
    rotation = rotations(turn)
    half = np.array(SIZES) / 2
    offset = generator.uniform(-1, 1, (3, COUNT)) * half.sum(axis=0)[:, None]
    if square:
        offset = np.round(offset, 1)
    axis = generator.integers(0, 3, COUNT)
    reach = (
        half[0] @ np.eye(3)[axis].T
        + np.einsum("ijp,j->ip", np.abs(rotation), half[1])[axis, np.arange(COUNT)]
    )
    offset[axis, np.arange(COUNT)] = (
        reach + generator.normal(size=COUNT) * 0.004
    ) * generator.choice([-1, 1], COUNT)
    return rotation, offset


@settings(max_examples=40, derandomize=True, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    tilt=st.sampled_from([0.0, 1e-9, 3e-9, 1e-8, 1e-6, 1e-3, 0.05, 2.0]),
    square=st.booleans(),
)
def test_both_methods_find_the_same_contacts(seed, tilt, square):
    rotation, offset = placed(seed, tilt, square)
    half = [np.repeat(np.array(size)[:, None] / 2, COUNT, axis=1) for size in SIZES]
    reach = np.full(COUNT, 0.01)
    fast = box_contacts(rotation, offset, *half, reach)
    narrow = NarrowPhase([Box(size) for size in SIZES])
    general = narrow._general(np.tile([[0, 1]], (COUNT, 1)), rotation, offset, reach, None)
    both = (general.distance <= 0.0099) & fast.exact & (fast.distance <= 0.01)
    assert both.sum() > 0.3 * COUNT
    np.testing.assert_allclose(fast.distance[both], general.distance[both], atol=1e-4)
    same = both & ((fast.normal * general.normal).sum(axis=0) > 1 - 1e-9)
    assert same.sum() > 0.95 * both.sum()
    np.testing.assert_allclose(fast.area[same], general.area[same], rtol=1e-3, atol=2e-3)
    wide = same & (general.area > 0.05)
    np.testing.assert_allclose(fast.centre[:, wide], general.centre[:, wide], atol=2e-3)
    # The two methods place a sliver along an edge differently, but both boxes are there.
    local = fast.centre, np.einsum("ijp,ip->jp", rotation, fast.centre - offset)
    for half_extents, place in zip(half, local, strict=True):
        away = np.linalg.norm(place - np.clip(place, -half_extents, half_extents), axis=0)
        assert away[same].max() < (reach[0] + 3 * ROUGHNESS) / 2


@settings(max_examples=20, derandomize=True, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    tilt=st.sampled_from([0.0, 1e-3, 0.05, 2.0]),
    shift=st.sampled_from([0.0, 0.3]),
)
def test_both_methods_find_the_same_corners_of_patches(seed, tilt, shift):
    """In every direction the outermost corner of a patch is as far out by either method, also if
    boxes are turned and off their origins."""
    rotation, offset = placed(seed, tilt, False)
    pose = Pose((shift, 0.0, 0.0), (1.0, shift, -shift, 0.0))
    turn, place = pose_matrix(pose)[:3, :3], np.array(pose.position)
    narrow = NarrowPhase([Compound.of(((Box(size), pose),)) for size in SIZES])
    rotation = np.einsum("ij,jkp,lk->ilp", turn, rotation, turn)
    offset = turn @ offset + place[:, None] - np.einsum("ijp,j->ip", rotation, place)
    placing = np.tile([[0, 1]], (COUNT, 1)), rotation, offset, np.full(COUNT, 0.01)
    general = narrow._general(*placing, corners=True)
    number, corners = narrow.corners(*placing, general.normal, general.centre)
    ways = np.random.default_rng(seed).normal(size=(20, 3))
    near = np.flatnonzero(general.distance <= 0.01)
    assert len(near) > 0.3 * COUNT
    for k in near.tolist():
        reach = (ways @ corners[:, number == k]).max(axis=1)
        np.testing.assert_allclose(reach, (ways @ general.corners[k].T).max(axis=1), atol=1.5e-4)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("ratio", [1e6, 1e9, 1e12])
@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_a_pin_on_a_huge_floor(ratio, tilt):
    """A square pin, turned about the vertical by ``tilt``, on a floor ``ratio`` times as wide: its
    whole face is the patch."""
    pin = np.array([[0.001], [0.001], [0.01]])
    floor = np.array([[0.001 * ratio], [0.001 * ratio], [1.0]])
    rotation = rotations(np.array([[0.0], [0.0], [tilt]]))
    offset = np.array([[0.2], [-0.3], [1.01]])
    for first, second, turn, place in (
        (floor, pin, rotation, offset),
        (pin, floor, rotation.transpose(1, 0, 2), None),
    ):
        shift = -np.einsum("ijp,ip->jp", rotation, offset) if place is None else place
        found = box_contacts(turn, shift, first, second, np.array([0.01]))
        assert found.distance[0] == pytest.approx(0.0, abs=1e-12)
        assert found.area[0] == pytest.approx(4e-6, rel=1e-3)
        middle = found.centre - (shift if place is not None else 0)
        np.testing.assert_allclose(np.abs(middle[:2]), 0, atol=1e-3 if ratio > 1e9 else 1e-6)


@pytest.mark.slow
@settings(max_examples=25, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), tilt=st.sampled_from([0.0, 1e-3, 0.05, 2.0]))
def test_distances_against_bounded_least_squares(seed, tilt):
    """The least distance of a point in the one box to a point in the other; 0 where they
    overlap."""
    rotation, offset = placed(seed, tilt, False)
    found = NarrowPhase([Box(size) for size in SIZES]).query(
        np.tile([[0, 1]], (COUNT, 1)), rotation, offset, np.full(COUNT, 0.05)
    )
    limit = np.concatenate(SIZES) / 2
    for k in range(0, COUNT, 20):
        nearest = lsq_linear(
            np.hstack([np.eye(3), -rotation[..., k]]), offset[:, k], (-limit, limit), tol=1e-14
        )
        distance = float(np.sqrt(2 * nearest.cost))
        if found.distance[k] <= 0.05:
            assert max(found.distance[k], 0.0) == pytest.approx(distance, abs=1.01e-4)
        else:
            assert distance > 0.05
