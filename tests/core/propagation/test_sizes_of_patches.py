"""Where waves begin with the size of a patch: the size by what touches, and by which functions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import Box
from haptic_tracing.core.graph.haptic_graph import graph_of_scene
from haptic_tracing.core.graph.object_frames import ObjectFrames
from haptic_tracing.core.scene.functions import Physical, Wave
from haptic_tracing.core.scene.values import Contact, HapticObject, HapticScene, Pose

TURNED = (math.cos(0.4), 0.0, math.sin(0.4), 0.0)
"""About y by 0.8 rad."""


def size(one, other, area: float, normal: tuple[float, float, float], turned=None) -> float:
    """The size of a patch between two boxes, both turned by 0.8 rad with it if ``turned``."""
    rotation = TURNED if turned else (1.0, 0.0, 0.0, 0.0)
    objects = [
        HapticObject(
            name, 0.1, 0.9, shape=Box(box) if box else None, pose=Pose((0, 0, 0), rotation)
        )
        for name, box in (("a", one), ("b", other))
    ]
    x, y, z = normal
    if turned:
        x, z = math.cos(0.8) * x + math.sin(0.8) * z, math.cos(0.8) * z - math.sin(0.8) * x
    frames = ObjectFrames.of_objects(objects)
    return float(frames.patch_sizes(np.array([[0, 1]]), np.array([area]), np.array([[x, y, z]]))[0])


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    ("one", "other", "area", "normal", "expected"),
    [
        ((1, 1, 1), (40, 40, 1), 1.0, (0, 0, 1), 1.0),  # a crate on the ground
        ((8, 8, 0.1), (40, 40, 1), 64.0, (0, 0, 1), 8.0),  # a slab on the ground
        ((4, 8, 0.1), (4, 8, 0.1), 0.8, (1, 0, 0), 8.0),  # two strips, edge to edge
        ((1, 8, 0.1), (1, 8, 0.1), 0.8, (1, 0, 0), 2.0),  # waves go along narrow ones
        ((5, 0.2, 2.5), (6, 6, 0.2), 1.0, (0, 0, 1), 5.0),  # a wall on a floor
        ((0.2, 5, 0.2), (40, 40, 1), 1.0, (0, 0, 1), 0.4),  # a rail on the ground
        ((4, 1, 1), (4, 1, 1), 1.0, (1, 0, 0), 1.0),  # two blocks, end to end
        (None, None, 2.25, (0, 0, 1), 1.5),  # nothing is known
    ],
)
def test_the_size_of_a_patch(one, other, area, normal, expected, turned):
    if turned and one is None:
        return
    assert size(one, other, area, normal, turned) == pytest.approx(expected, rel=1e-12)
    assert size(other, one, area, normal, turned) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("one", "other"),
    [((8, 8, 0.1), (1, 1, 1)), ((4, 8, 0.1), (4, 8, 0.1)), ((9, 3, 1e-6), (2, 1, 1))],
)
def test_it_is_continuous_in_the_normal(one, other):
    angles = np.linspace(0, math.pi / 2, 2000)
    sizes = [size(one, other, 0.6, (math.sin(t), 0.0, math.cos(t))) for t in angles.tolist()]
    assert np.abs(np.diff(sizes)).max() < 0.03


@pytest.mark.parametrize(("area", "large"), [(0.0, False), (0.24, False), (0.26, True)])
def test_patches_up_to_the_driven_radius_and_those_of_other_functions_are_points(area, large):
    function = Physical(wave=Wave.BOUNDED, thickness=0.6, extent=2.0)
    objects = (HapticObject("a", 0.1, 0.9, function), HapticObject("b", 0.1, 0.9))
    place = (0.0, 0.0, 0.0)
    graph = graph_of_scene(HapticScene(objects, (Contact(("a", "b"), (place, place), area=area),)))
    if not large:
        assert graph.fronts is None
    else:
        assert graph.fronts[:, 0] == pytest.approx(
            [math.sqrt(area) - 0.5, math.log(math.sqrt(area) / 0.5) / 2], rel=1e-12
        )
        assert graph.fronts[:, 1].tolist() == [0, 0]
