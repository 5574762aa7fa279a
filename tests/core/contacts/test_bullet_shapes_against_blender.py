"""Where bodies came to rest in Blender 5.2.3, against where ours would just touch.

A cube of 1 m, its mesh scaled by ``mesh`` and the object by ``scale``, was dropped on a 20 m cube
of each shape, without restitution and in 20 substeps, and its height read after 150 frames.
"""

from __future__ import annotations

import numpy as np
import pytest
from haptic_tracing.core.contacts.bullet_shapes import (
    convex_hull_shape,
    mesh_shape,
    shape_from_bounding_box,
)
from haptic_tracing.core.contacts.scene_contacts import contacts_of_scene
from haptic_tracing.core.contacts.shapes import Box, Cylinder
from haptic_tracing.core.scene.values import HapticObject, HapticScene, Pose

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
SIDES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
TRIANGLES = [[a, b, c] for w, x, y, z in SIDES for a, b, c in ((w, x, y), (w, y, z))]
ONE = (1, 1, 1)

RESTED = [  # shape, ground, mesh, scale, use margin and margin, height [m]
    ("BOX", "BOX", ONE, ONE, None, 0.5),
    ("BOX", "CONVEX_HULL", ONE, ONE, None, 0.5008),
    ("BOX", "MESH", ONE, ONE, None, 0.54),
    ("BOX", "BOX", ONE, (2, 2, 2), None, 1.0),
    ("BOX", "BOX", ONE, (1, 1, 2), None, 1.0),
    ("BOX", "BOX", ONE, ONE, 0.1, 0.5),
    ("BOX", "BOX", (1, 1, 0.05), ONE, None, 0.025),
    ("BOX", "CONVEX_HULL", (1, 1, 0.05), ONE, None, 0.0258),
    ("BOX", "MESH", (1, 1, 0.07), ONE, None, 0.08),
    ("BOX", "MESH", (1, 1, 0.1), ONE, None, 0.09),
    ("SPHERE", "BOX", ONE, ONE, None, 0.5),
    ("SPHERE", "CONVEX_HULL", ONE, ONE, None, 0.5008),
    ("SPHERE", "MESH", ONE, ONE, None, 0.5),
    ("SPHERE", "BOX", ONE, (2, 1, 1), None, 1.0),
    ("SPHERE", "BOX", ONE, (1, 2, 1), None, 0.5),
    ("SPHERE", "BOX", ONE, (1, 1, 2), None, 0.5),
    ("SPHERE", "BOX", ONE, ONE, 0.1, 0.5),
    ("SPHERE", "BOX", (1, 1, 0.05), ONE, None, 0.5),
    ("CAPSULE", "BOX", (1, 1, 2), ONE, None, 1.0),
    ("CAPSULE", "CONVEX_HULL", (1, 1, 2), ONE, None, 1.0008),
    ("CAPSULE", "MESH", (1, 1, 2), ONE, None, 1.04),
    ("CAPSULE", "BOX", ONE, (2, 1, 1), None, 0.5),
    ("CAPSULE", "BOX", ONE, (1, 2, 1), None, 1.0),
    ("CAPSULE", "BOX", ONE, (1, 1, 2), None, 0.5),
    ("CAPSULE", "BOX", ONE, ONE, 0.1, 0.5),
    ("CYLINDER", "BOX", ONE, ONE, None, 0.5),
    ("CYLINDER", "CONVEX_HULL", ONE, ONE, None, 0.5008),
    ("CYLINDER", "MESH", ONE, ONE, None, 0.54),
    ("CYLINDER", "BOX", ONE, (1, 1, 2), None, 1.0),
    ("CYLINDER", "BOX", (1, 1, 0.07), ONE, None, 0.0399),
    ("CYLINDER", "MESH", (1, 1, 0.07), ONE, None, 0.0798),
    ("CONE", "BOX", ONE, ONE, None, 0.54),
    ("CONE", "CONVEX_HULL", ONE, ONE, None, 0.5408),
    ("CONE", "MESH", ONE, ONE, None, 0.58),
    ("CONE", "BOX", ONE, (2, 2, 2), None, 1.04),
    ("CONE", "BOX", ONE, (1, 1, 2), None, 1.04),
    ("CONE", "BOX", ONE, ONE, 0.1, 0.6),
    ("CONE", "BOX", (1, 1, 0.05), ONE, None, 0.065),
    ("CONVEX_HULL", "BOX", ONE, ONE, None, 0.5001),
    ("CONVEX_HULL", "CONVEX_HULL", ONE, ONE, None, 0.5009),
    ("CONVEX_HULL", "MESH", ONE, ONE, None, 0.5401),
    ("CONVEX_HULL", "BOX", ONE, (2, 2, 2), None, 1.0001),
    ("CONVEX_HULL", "BOX", ONE, (0.5, 0.5, 0.5), None, 0.25),
    ("CONVEX_HULL", "BOX", ONE, (1, 1, 2), None, 0.9601),
    ("CONVEX_HULL", "BOX", ONE, (1, 1, 3), None, 1.4202),
    ("CONVEX_HULL", "BOX", ONE, (1, 2, 2), None, 0.9601),
    ("CONVEX_HULL", "BOX", ONE, (2, 2, 2.01), None, 1.0047),
    ("CONVEX_HULL", "BOX", ONE, (1, 1, 0.05), None, 0.025),
    ("CONVEX_HULL", "BOX", ONE, ONE, 0.1, 0.6),
    ("CONVEX_HULL", "BOX", ONE, (2, 2, 2), 0.1, 1.1),
    ("CONVEX_HULL", "BOX", (1, 1, 0.05), ONE, None, 0.025),
    ("MESH", "BOX", ONE, ONE, None, 0.54),
    ("MESH", "CONVEX_HULL", ONE, ONE, None, 0.5408),
    ("MESH", "SPHERE", ONE, ONE, None, 0.5),
    ("MESH", "BOX", ONE, (2, 2, 2), None, 1.04),
    ("MESH", "BOX", ONE, ONE, 0.1, 0.6),
]


def built(kind, vertices, scale=ONE, own_margin=None):
    margin = 0.04 if own_margin is None else own_margin
    if kind == "CONVEX_HULL":
        return convex_hull_shape(vertices, scale, own_margin)
    if kind == "MESH":
        return mesh_shape(vertices, TRIANGLES, scale, margin)
    return shape_from_bounding_box(kind, vertices, scale, margin)


@pytest.mark.parametrize(("kind", "ground", "mesh", "scale", "margin", "height"), RESTED)
def test_bodies_rest_where_they_touch(kind, ground, mesh, scale, margin, height):
    floor = HapticObject("floor", 0.1, 0.9, shape=built(ground, CUBE * 20), pose=Pose((0, 0, -10)))
    body = HapticObject(
        "body",
        0.1,
        0.9,
        shape=built(kind, CUBE * mesh, scale, margin),
        pose=Pose((0.1, 0.2, height)),
    )
    if ground == "SPHERE":
        body = HapticObject("body", 0.1, 0.9, shape=body.shape, pose=Pose((0, 0, height)))
    found = contacts_of_scene(HapticScene((floor, body)))
    assert len(found) == 1
    assert abs(found.distance[0]) < 1e-3
    np.testing.assert_allclose(found.normal[0], [0, 0, 1], atol=1e-3)


def test_sizes_beside_the_origin():
    """Box and round shapes take the size of the bounding box, wherever that lies."""
    corners = np.array([[0, 0, 0], [2, 1, 4]], dtype=float)
    assert shape_from_bounding_box("BOX", corners) == Box((2, 1, 4), rounding=0.04)
    assert shape_from_bounding_box("CYLINDER", corners, (2, 3, 4)) == Cylinder(
        2.0, 16.0, rounding=0.04
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: shape_from_bounding_box("BOX", CUBE, (1, 0, 1)), "scale: must be greater than 0"),
        (lambda: shape_from_bounding_box("BOX", CUBE, (1, -1, 1)), "scale: must be greater than 0"),
        (lambda: shape_from_bounding_box("BLOB", CUBE), "kind: expected BOX"),
        (lambda: shape_from_bounding_box("BOX", CUBE * [1, 1, 0]), "size: must be greater than 0"),
        (lambda: shape_from_bounding_box("SPHERE", CUBE * np.nan), "bounds: point 0 is not finite"),
        (lambda: convex_hull_shape(CUBE[:1]), "points: they all lie in one place"),
        (lambda: convex_hull_shape(CUBE * np.nan), "points: point 0 is not finite"),
        (lambda: mesh_shape(CUBE, []), "triangles: there are none"),
        (lambda: mesh_shape(CUBE, TRIANGLES, (1, 1, 0)), "scale: must be greater than 0"),
    ],
)
def test_bad_geometry(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_flat_hulls_are_thin():
    flat = convex_hull_shape(CUBE * [1, 1, 0])
    assert flat.rounding == 0
    floor = HapticObject("floor", 0.1, 0.9, shape=Box((10, 10, 1)), pose=Pose((0, 0, -0.5)))
    found = contacts_of_scene(
        HapticScene((floor, HapticObject("sheet", 0.1, 0.9, shape=flat, pose=Pose((1, 2, 0.001)))))
    )
    np.testing.assert_allclose(found.distance, [0.001], atol=1e-6)
    np.testing.assert_allclose(found.area, [1.0], rtol=1e-3)


def test_self_intersecting_mesh():
    crossed = mesh_shape(
        [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0], [0.5, 0.5, 1]],
        [[0, 1, 4], [2, 3, 4], [0, 1, 2], [1, 0, 3]],
    )
    floor = HapticObject("floor", 0.1, 0.9, shape=Box((10, 10, 1)), pose=Pose((0, 0, -0.5)))
    found = contacts_of_scene(
        HapticScene((floor, HapticObject("knot", 0.1, 0.9, shape=crossed, pose=Pose((0, 0, 0.04)))))
    )
    np.testing.assert_allclose(found.distance, [0.0], atol=1e-6)
