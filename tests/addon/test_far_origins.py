"""A source or listener whose origin is outside its mesh, as CAD files leave them, stands at the
nearest point of its surface."""

from __future__ import annotations

import math

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.contacts.nearest_point import nearest_to_origin
from haptic_tracing.core.contacts.shapes import Box, ConvexHull, Mesh, Sphere
from mathutils.bvhtree import BVHTree


def shifted(obj, by):
    """Move the mesh of an object in its own space, and the object back."""
    for vertex in obj.data.vertices:
        vertex.co += by
    obj.data.update()


@pytest.mark.parametrize("distance", [0.0, 2.0, 50.0, 1000.0])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_the_node_is_the_nearest_point_that_blender_finds(scene, add_box, traced, distance, turn):
    from mathutils import Vector

    torus_of = bpy.ops.mesh.primitive_torus_add
    torus_of(major_radius=0.5, minor_radius=0.1)
    torus = bpy.context.object
    torus.haptics.enabled = torus.haptics.listener.enabled = True
    torus.haptics.source.enabled = True
    shifted(torus, Vector((distance, 0.3 * distance, 0)))
    torus.rotation_euler = (turn, 0, 2 * turn)
    torus.scale = (1, 2, 1)
    assert traced() is not None
    bpy.context.view_layer.update()
    reading = sessions.shown(scene).reading
    mesh = torus.data.copy()
    mesh.transform(torus.matrix_world)
    tree = BVHTree.FromPolygons([v.co for v in mesh.vertices], [p.vertices for p in mesh.polygons])
    origin = torus.matrix_world.translation
    expected = tree.find_nearest(origin)[0] if distance else origin
    for item in (*reading.sources, *reading.listeners):
        assert math.dist(item.position, expected) < 1e-5 * max(1.0, distance)


def test_a_far_origin_is_as_loud_as_one_at_the_surface(scene, add_box, traced):
    """A block whose nearest corner to the origin is where the source's signal comes in."""
    from mathutils import Vector

    gains = []
    for distance in (0.5, 5.0, 500.0):
        for obj in list(scene.objects):
            bpy.data.objects.remove(obj)
        block = add_box("block", (0, 0, 0), (1, 1, 1))
        block.haptics.listener.enabled = True
        shifted(block, Vector((distance, 0, 0)))
        end = bpy.data.objects.new("end", None)
        scene.collection.objects.link(end)
        end.parent = block
        end.location = (distance + 0.5, 0, 0)
        end.haptics.source.enabled = True
        bpy.context.view_layer.update()
        gains.append(float(traced().gains[0, 0]))
        assert session.problems_of(scene) == ()
    assert gains == pytest.approx(3 * [gains[0]], rel=1e-4) and gains[0] > 0.1


@pytest.mark.parametrize(
    ("shape", "point"),
    [
        (Box((1, 1, 1)), (0, 0, 0)),
        (Sphere(2.0), (0, 0, 0)),
        (ConvexHull([(1, 0, 0), (3, 0, 0), (1, 1, 0), (1, 0, 1)]), (1, 0, 0)),
        (
            ConvexHull([(x, y, z) for x in (2, 3) for y in (-1, 1) for z in (4, 5)]),
            (2, 0, 4),
        ),
        (Mesh([(1, -1, -1), (1, 1, -1), (1, 0, 2)], [(0, 1, 2)]), (1, 0, 0)),
    ],
)
def test_closed_forms(shape, point):
    assert np.allclose(nearest_to_origin(shape), point)
