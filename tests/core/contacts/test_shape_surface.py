"""Surfaces of shapes as they are drawn: Euler's formula, and the edges of their faces alone."""

import numpy as np
import pytest
from haptic_tracing.core.contacts.shape_surface import edges, surface
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.scene.values import Pose

CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])


@pytest.mark.parametrize(
    "shape",
    [Box((1, 2, 3)), Sphere(1), Capsule(0.5, 1), Cylinder(1, 1), Cone(1, 1), ConvexHull(CORNERS)],
)
def test_closed_surfaces(shape):
    _, faces = surface(shape)
    sides = {
        frozenset(pair) for face in faces for pair in zip(face, (*face[1:], face[0]), strict=True)
    }
    assert len({k for face in faces for k in face}) - len(sides) + len(faces) == 2


def test_a_cube_has_twelve_edges_however_it_is_given():
    hull = ConvexHull(CORNERS)
    points, faces = surface(hull)
    for shape in (Box((1, 1, 1)), hull, Mesh(points, list(faces))):
        places, pairs = edges(shape)
        assert len(pairs) == 12
        np.testing.assert_allclose(
            np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1), 1
        )
    assert len(edges(Compound.of(((hull, Pose()), (Box((1, 1, 1)), Pose((3, 0, 0))))))[1]) == 24


def test_open_edges_are_drawn():
    assert (
        len(edges(Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]))[1])
        == 4
    )
