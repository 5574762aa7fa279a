"""Hulls: every point lies behind every face, every corner is a point, the surface is closed; moved
inwards they are what is that deep."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.hull import (
    MAX_HULL_POINTS,
    convex_hull,
    extreme_points,
    hull_2d,
    shrunk_hull,
)
from hypothesis import given, settings
from hypothesis import strategies as st

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def check_hull(points, hull):
    extent = np.ptp(points, axis=0).max()
    normals, offsets = hull.planes()
    assert (points @ normals.T - offsets).max() <= 1e-6 * extent
    given_points = {tuple(p) for p in points.tolist()}
    assert all(tuple(p) in given_points for p in hull.points.tolist())
    edges = [(t[k], t[(k + 1) % 3]) for t in hull.triangles.tolist() for k in range(3)]
    assert len(set(edges)) == len(edges) and {(b, a) for a, b in edges} == set(edges)
    assert len(hull.points) - len(edges) // 2 + len(hull.triangles) == 2


@settings(max_examples=80, derandomize=True, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(5, 60),
    kind=st.sampled_from(["ball", "shell", "grid", "needle", "far"]),
)
def test_hulls(seed, count, kind):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(count, 3))
    if kind == "shell":
        points /= np.linalg.norm(points, axis=1)[:, None]
    elif kind == "grid":
        points = np.concatenate([generator.integers(-2, 3, (count, 3)).astype(float), CUBE])
    elif kind == "needle":
        points *= [1, 1, 1e-4]
    elif kind == "far":
        points += 1000.0
    check_hull(points, convex_hull(points))


@pytest.mark.parametrize("tolerance", [5e-3, 0.02])
def test_no_point_is_outside_by_more_than_the_tolerance(tolerance):
    """Of a ball of radius 1, with corners in inverse proportion to it, as bodies within so thin a
    layer have; a box keeps its own."""
    ball = np.random.default_rng(3).normal(size=(3000, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    hull = convex_hull(ball, tolerance)
    check_hull(hull.points, hull)
    normals, offsets = hull.planes()
    assert 0 < (ball @ normals.T - offsets).max() <= tolerance
    assert len(hull.points) < 8 / tolerance
    np.testing.assert_array_equal(convex_hull(CUBE, tolerance).points, convex_hull(CUBE).points)


def test_flat_lines_and_points():
    square = np.array([[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1], [0.5, 0.5, 1]], dtype=float)
    flat = convex_hull(square)
    assert len(flat.points) == 4 and len(flat.triangles) == 4
    line = convex_hull(np.outer([0, 0.3, 1, 0.5], [1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(line.points, [[0, 0, 0], [1, 2, 3]])
    assert len(line.triangles) == 0
    assert len(convex_hull(np.ones((3, 3))).points) == 1


@settings(max_examples=60, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(5, 40), depth=st.floats(0.01, 0.6))
def test_moved_inwards(seed, count, depth):
    generator = np.random.default_rng(seed)
    hull = convex_hull(generator.normal(size=(count, 3)))
    inner = shrunk_hull(hull, depth)
    normals, offsets = hull.planes()
    offsets = offsets - depth
    inside = generator.normal(size=(4000, 3))
    inside = inside[(inside @ normals.T <= offsets - 1e-6).all(axis=1)]
    if inner is None:
        assert len(inside) == 0
        return
    assert (inner.points @ normals.T <= offsets + 1e-5).all()
    inner_normals, inner_offsets = inner.planes()
    assert (inside @ inner_normals.T <= inner_offsets + 1e-5).all()


@pytest.mark.parametrize("depth", [-0.2, 0.04, 0.3])
def test_cube_moved_inwards(depth):
    np.testing.assert_allclose(
        shrunk_hull(convex_hull(CUBE), depth).points, CUBE * (1 - 2 * depth), atol=1e-12
    )
    assert shrunk_hull(convex_hull(CUBE * [1, 1, 0.05]), 0.04) is None
    assert shrunk_hull(convex_hull(CUBE * [1, 1, 0]), 0.04) is None


@pytest.mark.slow
def test_many_points_are_reduced_to_extreme_ones():
    generator = np.random.default_rng(1)
    points = generator.normal(size=(200_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    kept = extreme_points(points, MAX_HULL_POINTS)
    assert len(kept) <= MAX_HULL_POINTS
    hull = convex_hull(points)
    normals, offsets = hull.planes()
    assert (points[::100] @ normals.T - offsets).max() < 3e-3


@settings(max_examples=60, derandomize=True, deadline=None)
@given(points=st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1, max_size=30))
def test_outline_in_the_plane(points):
    array = np.array(points, dtype=float)
    outline = array[hull_2d(array)]
    following = np.roll(outline, -1, axis=0)
    for start, end in zip(outline, following, strict=True):
        across = (end[0] - start[0]) * (array[:, 1] - start[1]) - (end[1] - start[1]) * (
            array[:, 0] - start[0]
        )
        assert (across >= 0).all()
