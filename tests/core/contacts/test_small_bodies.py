"""What is small touches over small gaps: the tolerance is bounded by a tenth of the middle extent of
the smaller body, from 1 mm to 1 km."""

from __future__ import annotations

import itertools

import pytest
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box, ConvexHull
from haptic_tracing.core.scene.functions import HapticTracing
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Pose

SIZES = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0, 100.0, 1000.0)


def touching(*boxes: tuple[tuple[float, float, float], float]) -> set[tuple[int, int]]:
    """The pairs that touch of boxes (size, height of the middle) over each other."""
    objects = tuple(
        HapticObject(f"{k}", 0.1, 0.9, HapticTracing(), Box(size), Pose((0.0, 0.0, height)))
        for k, (size, height) in enumerate(boxes)
    )
    found = contacts_of_scene(HapticScene(objects))
    return {tuple(pair) for pair in found.pairs.tolist()}


@pytest.mark.parametrize("size", SIZES)
def test_cubes_touch_up_to_a_tenth_of_their_size_at_most_a_centimetre(size):
    limit = min(0.01, size / 10)
    for gap, expected in (
        (0.0, True),
        (0.9 * limit, True),
        (1.1 * limit, False),
        (size / 2, False),
    ):
        found = touching(((size,) * 3, 0.0), ((size,) * 3, size + gap))
        assert bool(found) == expected, gap


@pytest.mark.parametrize("size", SIZES)
def test_in_a_row_only_neighbours_touch(size):
    row = [((size,) * 3, k * size) for k in range(5)]
    assert touching(*row) == {(k, k + 1) for k in range(4)}


@pytest.mark.parametrize("size", SIZES)
def test_a_small_cube_near_a_large_one_counts_by_its_own_size(size):
    gap = 1.1 * min(0.01, size / 10)
    assert not touching(((size,) * 3, 0.0), ((4000.0,) * 3, 2000.0 + size / 2 + gap))
    assert touching(((size,) * 3, 0.0), ((4000.0,) * 3, 2000.0 + size / 2 + gap / 2))


def test_a_sheet_counts_by_its_width():
    """Paper of 0.1 mm on a table, 5 mm above it by its modeller."""
    sheet = ((0.21, 0.297, 0.0001), 0.00505)
    assert touching(sheet, ((1.0, 1.0, 0.1), -0.05))
    thin = ((0.001, 0.297, 0.0001), 0.00505)
    assert not touching(thin, ((1.0, 1.0, 0.1), -0.05))


def test_what_bullet_holds_apart_by_its_margin_touches():
    """A cube of 5 mm whose margin of 4 cm keeps it from the ground."""
    points = [
        (x, y, z) for x in (-0.0025, 0.0025) for y in (-0.0025, 0.0025) for z in (-0.0025, 0.0025)
    ]
    for gap, expected in ((0.04, True), (0.044, True), (0.055, False)):
        cube = HapticObject(
            "cube",
            0.1,
            0.9,
            HapticTracing(),
            ConvexHull(points, margin=0.04),
            Pose((0, 0, gap + 0.0025)),
        )
        ground = HapticObject(
            "ground", 0.1, 0.9, HapticTracing(), Box((2, 2, 1)), Pose((0, 0, -0.5))
        )
        assert bool(len(contacts_of_scene(HapticScene((cube, ground))))) == expected


def test_the_gain_is_continuous_in_the_size():
    """The weight of a contact over a gap of 3 mm, over cubes that grow."""
    weights = []
    for k in range(200):
        size = 0.02 + 0.0005 * k
        objects = tuple(
            HapticObject(
                f"{n}",
                0.1,
                0.9,
                HapticTracing(),
                Box((size,) * 3),
                Pose((0, 0, n * (size + 0.003))),
            )
            for n in range(2)
        )
        found = contacts_of_scene(HapticScene(objects))
        weights.append(float(found.weight[0]) if len(found) else 0.0)
    assert weights[0] == 0 and weights[-1] > 0.9
    assert max(abs(b - a) for a, b in itertools.pairwise(weights)) < 0.05
