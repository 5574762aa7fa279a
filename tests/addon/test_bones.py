"""Meshes that bones deform touch others by a convex part for each bone, against what Blender's own
armature does to their vertices."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.contacts.hull import convex_hull
from making_haptic import make_haptic
from mathutils.bvhtree import BVHTree

_BONES = {
    "hips": ((0, 0, 0.9), (0, 0, 1.1)),
    "chest": ((0, 0, 1.1), (0, 0, 1.5)),
    "leg.L": ((0.12, 0, 0.9), (0.12, 0, 0.5)),
    "shin.L": ((0.12, 0, 0.5), (0.12, 0, 0.1)),
    "leg.R": ((-0.12, 0, 0.9), (-0.12, 0, 0.5)),
    "shin.R": ((-0.12, 0, 0.5), (-0.12, 0, 0.1)),
}
_PARENTS = {"chest": "hips", "leg.L": "hips", "leg.R": "hips", "shin.L": "leg.L", "shin.R": "leg.R"}


def walker(smooth: float = 0.0) -> tuple[Any, Any]:
    """An armature and a mesh of a cylinder around each bone, bound by a modifier alone. ``smooth``
    [m]: along how much of each bone its parent's weight fades out."""
    data = bpy.data.armatures.new("rig")
    rig = bpy.data.objects.new("rig", data)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail) in _BONES.items():
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
    for name, parent in _PARENTS.items():
        data.edit_bones[name].parent = data.edit_bones[parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    points, faces, weights = [], [], []
    for name, ends in _BONES.items():
        head, tail = map(np.array, ends)
        for ring, along in enumerate(np.linspace(0, 1, 9)):
            for k in range(12):
                angle = math.tau * k / 12
                side = 0.08 * np.array([math.cos(angle), math.sin(angle), 0])
                fades = 1 - along * np.linalg.norm(tail - head) / smooth if smooth else 0.0
                points.append(head + along * (tail - head) + side)
                weights.append((name, 0.5 * max(0.0, fades)))
            if ring:
                start = len(points) - 24
                faces += [
                    (start + k, start + (k + 1) % 12, start + 12 + (k + 1) % 12, start + 12 + k)
                    for k in range(12)
                ]
    mesh = bpy.data.meshes.new("body")
    mesh.from_pydata(points, [], faces)
    body = bpy.data.objects.new("body", mesh)
    bpy.context.scene.collection.objects.link(body)
    groups = {name: body.vertex_groups.new(name=name) for name in _BONES}
    for k, (name, fading) in enumerate(weights):
        groups[name].add([k], 1 - fading, "REPLACE")
        if fading and name in _PARENTS:
            groups[_PARENTS[name]].add([k], fading, "REPLACE")
    body.modifiers.new("rig", "ARMATURE").object = rig
    return rig, body


def walk(rig: Any) -> None:
    """Both legs swing, and their knees bend, over 24 frames."""
    for name, share, shift in (("leg", 0.5, 0.0), ("shin", 0.4, 1.0)):
        for side, phase in (("L", 0.0), ("R", math.pi)):
            bone = rig.pose.bones[f"{name}.{side}"]
            bone.rotation_mode = "XYZ"
            for frame in range(1, 25, 2):
                bone.rotation_euler.x = share * math.sin(frame / 4 + phase + shift)
                bone.keyframe_insert("rotation_euler", frame=frame)


def traced() -> Any:
    return session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())


def skin(body: Any) -> np.ndarray:
    """The vertices (n, 3) as Blender deforms them, in the world."""
    evaluated = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    points = np.array([vertex.co for vertex in evaluated.data.vertices])
    matrix = np.array(evaluated.matrix_world)
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def parts(name: str) -> list[np.ndarray]:
    """The corners (n, 3) of the parts that touch, in the world."""
    reading = sessions.shown(bpy.context.scene).reading
    number = [body.name for body in reading.bodies].index(name)
    place = reading.transforms[number]
    found = []
    shape = reading.bodies[number].shape
    for hull, own in zip(shape.parts, shape.places, strict=True):
        matrix = place @ own
        found.append(hull.points @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def test_feet_touch_the_floor_where_the_skin_does(add_box):
    rig, body = walker()
    walk(rig)
    floor = add_box("floor", (0, 0, 0), (4, 4, 0.2), haptic=False)
    rig.location.z = 0.02
    make_haptic(body, floor)
    floor.haptics.source.enabled = body.haptics.listener.enabled = True
    touched = 0
    for frame in range(1, 25):
        bpy.context.scene.frame_set(frame)
        result = session.result_of(bpy.context.scene) or traced()
        gap = float(skin(body)[:, 2].min()) - 0.1
        if abs(gap - bpy.context.scene.haptics.contact_tolerance) < 1e-5:
            continue
        touches = bool(gap <= bpy.context.scene.haptics.contact_tolerance)
        assert (len(result.contacts.pairs) == 1) is touches, (frame, gap)
        touched += touches
        if touches:
            assert result.contacts.distance[0] == pytest.approx(gap, abs=2e-5)
    assert 4 < touched < 20
    assert len(parts("body")) == len(_BONES)


@pytest.mark.parametrize(
    "change", ["none", "scaled", "mirrored", "moved", "child", "stretched", "unweighted"]
)
def test_parts_are_where_blender_moves_their_vertices(scene, change):
    rig, body = walker()
    if change == "scaled":
        body.scale, rig.scale = (0.5, 0.8, 1.2), (2, 2, 2)
    elif change == "mirrored":
        body.scale.x = -1
    elif change == "moved":
        body.location, rig.rotation_euler = (1, 2, 3), (0.3, 0.2, 1.0)
    elif change == "child":
        body.parent, body.location, rig.location = rig, (0.1, 0, 0), (0, 5, 0)
    elif change == "stretched":
        rig.pose.bones["leg.L"].scale = (1.2, 1.5, 0.9)
    elif change == "unweighted":
        body.vertex_groups.remove(body.vertex_groups["chest"])
    rig.pose.bones["hips"].rotation_mode = rig.pose.bones["shin.R"].rotation_mode = "XYZ"
    rig.pose.bones["hips"].rotation_euler = (0.2, 0.5, -0.4)
    rig.pose.bones["shin.R"].rotation_euler = (0.9, 0.1, 0.2)
    make_haptic(body)
    body.haptics.source.enabled = body.haptics.listener.enabled = True
    traced()
    seen = skin(body).reshape(len(_BONES), -1, 3)
    found = {tuple(np.round(box, 2).ravel()): box for box in map(bounds, parts("body"))}
    assert len(found) == len(_BONES)
    tolerance = 2e-3 if change == "stretched" else 1e-5  # stretches have three digits
    for box in map(bounds, seen):
        nearest = min(found.values(), key=lambda other: np.abs(other - box).max())
        assert np.abs(nearest - box).max() < tolerance


def bounds(points: np.ndarray) -> np.ndarray:
    """Lowest and highest coordinates (2, 3)."""
    return np.array([points.min(axis=0), points.max(axis=0)])


def test_the_deviation_holds_for_every_vertex(scene):
    """With weights that fade, the distance of a deformed vertex outside the parts, by Blender's own
    trees of their faces."""
    rig, body = walker(smooth=0.2)
    make_haptic(body)
    for name, angle in (("leg.L", 0.9), ("shin.L", -1.1), ("chest", 0.5)):
        rig.pose.bones[name].rotation_mode = "XYZ"
        rig.pose.bones[name].rotation_euler.x = angle
    bpy.context.view_layer.update()
    session.of(scene).reader.forget()
    traced()
    deviation = sessions.shown(scene).reading.hulls["body"].deviation
    hulls = [convex_hull(points) for points in parts("body")]
    trees = [BVHTree.FromPolygons(h.points.tolist(), h.triangles.tolist()) for h in hulls]
    outside = [
        min(
            0.0 if (h.planes()[0] @ point <= h.planes()[1]).all() else tree.find_nearest(point)[3]
            for h, tree in zip(hulls, trees, strict=True)
        )
        for point in skin(body)
    ]
    assert 0.01 < max(outside) <= deviation < 0.2


def test_weights_bones_and_vertices_can_be_edited(scene):
    rig, body = walker()
    make_haptic(body)
    body.haptics.source.enabled = body.haptics.listener.enabled = True
    traced()
    body.vertex_groups["chest"].add(range(12), 1.0, "REPLACE")
    body.vertex_groups["hips"].remove(range(12))
    body.data.update()
    traced()
    lowest = sorted(points[:, 2].min() for points in parts("body"))
    assert lowest[-1] == pytest.approx(0.925)  # the chest begins with the hips' first ring
    for vertex in body.data.vertices:
        vertex.co.z += 1
    body.data.update()
    traced()
    assert min(points[:, 2].min() for points in parts("body")) == pytest.approx(1.1)
    rig.data.bones["shin.L"].use_deform = False
    body.modifiers.new("half", "MIRROR")
    traced()
    reading = sessions.shown(scene).reading
    assert reading.bodies[0].shape.type == "mesh"  # bones alone don't move it any more


def test_weights_count_beside_edits_of_properties(scene):
    _, body = walker()
    make_haptic(body)
    body.haptics.source.enabled = body.haptics.listener.enabled = True

    def lowest_of_chest():
        traced()
        return sorted(points[:, 2].min() for points in parts("body"))[-1]

    def give(group, other, vertices):
        body.vertex_groups[group].add(vertices, 1.0, "REPLACE")
        body.vertex_groups[other].remove(vertices)
        body.data.update()

    assert lowest_of_chest() == pytest.approx(1.1)
    body.haptics.kappa = 0.4
    assert lowest_of_chest() == pytest.approx(1.1)
    give("chest", "hips", range(12))  # without anything else
    assert lowest_of_chest() == pytest.approx(0.925)
    body.haptics.kappa = 0.5
    give("hips", "chest", range(12))  # at the same time
    traced()
    scene.frame_set(scene.frame_current + 1)
    assert lowest_of_chest() == pytest.approx(1.1)
    body.haptics.kappa = 0.6
    give("chest", "hips", range(12))
    bpy.ops.object.select_all(action="DESELECT")
    assert lowest_of_chest() == pytest.approx(0.925)


def test_body_listeners_find_a_mesh_that_a_modifier_binds(scene):
    rig, body = walker()
    rig.data.bones["chest"].name = "head"
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = rig
    bpy.ops.haptic.add_default_listeners()
    assert rig.haptics.body == body and body.haptics.enabled and body.haptics.surface == "SEEN"
