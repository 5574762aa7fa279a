"""Shapes: their form in a scene file, their bounds, and what is said of bad ones."""

from __future__ import annotations

import json

import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import (
    MAX_TRIANGLES,
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
    parts_of,
    shape_from_dict,
)
from haptic_tracing.core.scene.values import Pose

TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
SHAPES = [
    Box((1, 2, 3)),
    Box((1, 2, 3), margin=0.1, rounding=0.04),
    Sphere(0.5, 0.1),
    Capsule(0.5, 0.0),
    Cylinder(0.5, 1.0, 0.1, 0.04),
    Cone(0.5, 1.0, 0.04),
    ConvexHull(TETRAHEDRON, 0.1, 0.04),
    Mesh(TETRAHEDRON, FACES, 0.04, 0.0),
    Compound.of(
        (
            (Box((1, 1, 1)), Pose((1, 0, 0), (0, 1, 0, 0))),
            (Compound.of(((Sphere(1), Pose()),)), Pose()),
        ),
        0.1,
    ),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.type)
def test_form_of_the_scene_file_and_back(shape):
    form = json.loads(json.dumps(shape.to_dict(), allow_nan=False))
    again = shape_from_dict(form)
    assert again == shape and hash(again) == hash(shape)
    assert again.to_dict() == shape.to_dict()


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: s.type)
def test_margin_widens_the_bounds(shape):
    bounds, core = shape.local_bounds, shape.core_bounds()
    np.testing.assert_allclose(bounds, core + np.array([[-shape.margin], [shape.margin]]))
    assert (bounds[0] < bounds[1]).all()


def test_bounds_of_a_compound():
    pair = Compound.of(
        (
            (Box((2, 4, 6)), Pose((10, 0, 0), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)))),
            (Sphere(1, 0.5), Pose((0, 0, 5))),
        ),
        0.25,
    )
    np.testing.assert_allclose(
        pair.local_bounds, [[-1.75, -1.75, -3.25], [12.25, 1.75, 6.75]], atol=1e-12
    )
    assert [part.radius for part in parts_of(pair)] == [0.25, 0.75]


@pytest.mark.parametrize(
    ("form", "message"),
    [
        ({"type": "box", "size": [1, 2]}, "size: expected three"),
        ({"type": "box", "size": [1, 2, 0]}, "size: must be greater than 0"),
        ({"type": "box", "size": [1, 2, -1]}, "size: must be finite"),
        ({"type": "box", "size": [1, 2, float("nan")]}, "size: must be finite"),
        ({"type": "box", "size": [1, 2, "3"]}, "size: expected a number"),
        ({"type": "sphere", "radius": float("inf")}, "radius: must be finite"),
        ({"type": "sphere", "radius": True}, "radius: expected a number"),
        ({"type": "sphere", "radius": 1, "margin": -1}, "margin: must be finite"),
        ({"type": "convex_hull", "points": []}, "points: there are none"),
        ({"type": "convex_hull", "points": [[1, 2, 3]]}, "points: they all lie in one place"),
        ({"type": "convex_hull", "points": [[1, 2, 3], [1, 2]]}, "points: expected a list"),
        ({"type": "convex_hull", "points": [[1, 2, 3], [1, 2, None]]}, "points: "),
        (
            {"type": "convex_hull", "points": [[0, 0, 0], [1, 1, float("nan")]]},
            "points: point 1 is not finite",
        ),
        ({"type": "mesh", "points": TETRAHEDRON, "triangles": []}, "triangles: there are none"),
        (
            {"type": "mesh", "points": TETRAHEDRON, "triangles": [[0, 1, 4]]},
            "triangles: triangle 0 refers",
        ),
        (
            {"type": "mesh", "points": TETRAHEDRON, "triangles": [[0, 1, -1]]},
            "triangles: triangle 0 refers",
        ),
        (
            {"type": "mesh", "points": TETRAHEDRON, "triangles": [[0, 1, 1.5]]},
            "triangles: expected",
        ),
        ({"type": "compound", "children": []}, "children: there are none"),
        (
            {"type": "compound", "children": [{"type": "sphere", "radius": 0}]},
            "children/0/radius: must be greater",
        ),
        (
            {
                "type": "compound",
                "children": [{"type": "sphere", "radius": 1, "pose": {"position": [1, 2]}}],
            },
            "children/0/position: expected 3",
        ),
    ],
)
def test_bad_shapes(form, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        shape_from_dict(form)


def test_a_mesh_that_is_too_large():
    triangles = np.zeros((MAX_TRIANGLES + 1, 3), dtype=int)
    with pytest.raises(ValueError, match="triangles: 500,001 are more than"):
        Mesh(TETRAHEDRON, triangles)
