"""Penetration depth against its definition: the least overlap of the two bodies' shadows on a line,
over all directions of the line."""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.motion import rotations
from haptic_tracing.core.contacts.narrow.narrow_phase import NarrowPhase
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
)
from hypothesis import example, given, settings
from hypothesis import strategies as st

POINTS = np.random.default_rng(7).normal(size=(12, 3)) * 0.4
SHAPES = {
    "box": Box((1, 0.8, 0.6)),
    "hull": ConvexHull(POINTS),
    "capsule": Capsule(0.3, 0.5),
    "cylinder": Cylinder(0.4, 0.8),
    "cone": Cone(0.4, 0.8),
}


def height(name, directions):
    """Greatest heights of a shape along unit directions (n, 3), from its definition."""
    across, z = np.hypot(directions[:, 0], directions[:, 1]), directions[:, 2]
    match name:
        case "box":
            return np.abs(directions) @ [0.5, 0.4, 0.3]
        case "hull":
            return (directions @ POINTS.T).max(axis=1)
        case "capsule":
            return 0.3 + 0.25 * np.abs(z)
        case "cylinder":
            return 0.4 * across + 0.4 * np.abs(z)
    return np.maximum(0.4 * z, 0.4 * across - 0.4 * z)


def directions_around(generator, centre, count):
    """Directions at 1e-7 to 0.1 rad from a unit vector, as many at each scale."""
    ways = (
        centre
        + generator.normal(size=(count, 3))
        * np.exp(generator.uniform(np.log(1e-7), np.log(0.1), count))[:, None]
    )
    return ways / np.linalg.norm(ways, axis=1)[:, None]


@pytest.mark.parametrize("second", SHAPES)
@pytest.mark.parametrize(
    "first",
    [
        pytest.param("cylinder", marks=pytest.mark.slow),
        pytest.param("cone", marks=pytest.mark.slow),
        "hull",
    ],
)
@settings(max_examples=12, derandomize=True, deadline=None)
@given(seed=st.integers(0, 10**6), spread=st.sampled_from([0.02, 0.3]))
# A cone and a capsule whose nearest points FCL does not find to 2e-5.
@example(seed=323, spread=0.3)
# A cone in a cylinder whose depth takes 261 corners of the polytope.
@example(seed=7770, spread=0.02)
def test_no_direction_separates_with_less(first, second, seed, spread):
    generator = np.random.default_rng(seed)
    rotation, offset = (
        rotations(generator.normal(size=(3, 1)) * 2),
        generator.normal(size=(3, 1)) * spread,
    )
    found = NarrowPhase([SHAPES[first], SHAPES[second]]).query(
        np.array([[0, 1]]), rotation, offset, np.full(1, 0.1)
    )
    if found.distance[0] > -1e-3:
        return

    def overlap(ways):
        return height(first, ways) + height(second, -ways @ rotation[..., 0]) - ways @ offset[:, 0]

    normal, depth = found.normal[:, 0], -found.distance[0]
    # The cores of capsules may be apart: then GJK's bound holds.
    error = 2e-5 if second == "capsule" else 2e-9
    assert overlap(normal[None])[0] == pytest.approx(depth, abs=error)
    assert overlap(directions_around(generator, normal, 5000)).min() > depth - error
    everywhere = generator.normal(size=(20_000, 3))
    assert overlap(everywhere / np.linalg.norm(everywhere, axis=1)[:, None]).min() > depth - 1e-6


FLOOR = Box((4, 4, 1))


@pytest.mark.parametrize("second", ["hull", "cylinder", "cone"])
def test_the_nearest_way_out_of_a_floor_is_upwards(second):
    """Also where the body stands on a face, so that many points are equally deep: their middle
    counts, wherever it stands."""
    generator = np.random.default_rng(11)
    narrow = NarrowPhase([FLOOR, SHAPES[second]])
    turns = np.concatenate(
        [rotations(generator.normal(size=(3, 20)) * 2), np.eye(3)[:, :, None]], axis=2
    )
    for k in range(21):
        rotation = turns[..., k]
        ways = np.concatenate([-rotation[2:], generator.normal(size=(3000, 3))])
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        depth, place = generator.uniform(0.001, 0.05), generator.uniform(-1, 1, 2)
        offset = np.array([*place, 0.5 + height(second, ways[:1])[0] - depth])
        found = narrow.query(
            np.array([[0, 1]]), rotation[..., None], offset[:, None], np.full(1, 0.1)
        )
        assert found.distance[0] == pytest.approx(-depth, abs=1e-12)
        assert found.normal[:, 0].tolist() == [0, 0, 1]
        outwards = -ways @ rotation.T
        floor = np.abs(outwards) @ [2, 2, 0.5]
        assert (floor + height(second, ways) - outwards @ offset).min() > depth - 1e-12
        assert found.centre[2, 0] == pytest.approx(0.5 - depth / 2, abs=1e-12)
    same = narrow.query(
        np.array([[0, 1]]), rotation[..., None], offset[:, None] + [[0.3], [0.1], [0]], np.ones(1)
    )
    assert same.area[0] == pytest.approx(found.area[0], rel=1e-9)


def test_a_bar_that_lies_across_two_rails_touches_each_where_that_is():
    """Its corners beyond a rail are as deep as those in it, but don't count there."""
    rail = Box((4, 0.2, 0.2))
    corners = [(x, y, z) for y in (-1, 1) for x, z in ((0.1, -0.2), (-0.1, -0.2), (0.2, 0.1))]
    bar = ConvexHull(np.array([*corners, (0, -1.1, 0.2), (0, 1.1, 0.2)]))
    for side in (-0.95, 0.95):
        offset = np.array([[0.3], [-side], [0.298]])
        found = NarrowPhase([rail, bar]).query(
            np.array([[0, 1]]), np.eye(3)[:, :, None], offset, np.full(1, 0.01)
        )
        assert found.distance[0] == pytest.approx(-0.002, abs=1e-12)
        np.testing.assert_allclose(found.normal[:, 0], [0, 0, 1])
        # From the rail's inner edge to the end of the bar.
        middle = [0.3, np.sign(side) * (-0.1 + 0.05) / 2, 0.099]
        np.testing.assert_allclose(found.centre[:, 0], middle, atol=1e-9)


def test_what_is_not_confirmed_is_found_among_others():
    """Cones and cylinders beside hulls, some of whose nearest points FCL does not find to 2e-5, are
    as far apart as each pair alone."""
    generator = np.random.default_rng(1)
    narrow, count = NarrowPhase([SHAPES[name] for name in ("hull", "cone", "cylinder")]), 300
    pairs = np.array([[0, 0], [0, 1], [0, 2], [1, 2]])[generator.integers(0, 4, count)]
    rotation, offset = (
        rotations(generator.normal(size=(3, count)) * 2),
        generator.normal(size=(3, count)),
    )
    offset *= 0.9 / np.linalg.norm(offset, axis=0)
    limit = np.full(count, 0.2)
    together = narrow.query(pairs, rotation, offset, limit).distance
    for k in range(count):
        part = slice(k, k + 1)
        alone = narrow.query(pairs[part], rotation[..., part], offset[:, part], limit[part])
        assert alone.distance[0] == together[k]


def overlap_along(ways, first, second):
    """Overlaps of the hulls of points (m, 3) along unit directions (n, 3), by their definition."""
    return (ways @ first.T).max(axis=1) - (ways @ second.T).min(axis=1)


def test_no_direction_separates_a_triangle_from_a_hull_with_less():
    """Also where faces are parallel, so that some points are as deep as others."""
    generator = np.random.default_rng(3)
    examined = 0
    for trial in range(20):
        points = generator.normal(size=(30, 3)).round(trial % 3)
        for _ in range(8):
            triangle = (generator.normal(size=(3, 3)) * 0.5).round(trial % 4 + 1)
            narrow = NarrowPhase([ConvexHull(points), Mesh(triangle, [[0, 1, 2]])])
            found = narrow.query(
                np.array([[0, 1]]), np.eye(3)[:, :, None], np.zeros((3, 1)), np.full(1, 0.1)
            )
            if found.distance[0] > -1e-3:
                continue
            examined += 1
            normal, depth = found.normal[:, 0], -found.distance[0]
            assert overlap_along(normal[None], points, triangle)[0] == pytest.approx(
                depth, abs=2e-9
            )
            near = directions_around(generator, normal, 2000)
            everywhere = generator.normal(size=(5000, 3))
            everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]
            for ways in (near, everywhere):
                assert overlap_along(ways, points, triangle).min() > depth - 2e-9
    assert examined > 100
