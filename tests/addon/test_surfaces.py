"""What is seen is what touches: concave objects by their surface, or by their hull where that is
chosen."""

from __future__ import annotations

import itertools
import math
import random
from typing import Any

import bpy
import fcl
import numpy as np
import pytest
from haptic_tracing.addon.session import session, sessions
from making_haptic import make_haptic
from mathutils import Vector
from mathutils.bvhtree import BVHTree


def contacts() -> dict[frozenset[str], float]:
    """Touching pairs and their signed distances, in a trace of everything."""
    bpy.context.view_layer.update()
    result = session.trace(bpy.context.scene, bpy.context.evaluated_depsgraph_get())
    pairs = (frozenset(result.objects[k] for k in pair) for pair in result.contacts.pairs.tolist())
    return dict(zip(pairs, result.contacts.distance.tolist(), strict=True))


def shape_of(name: str) -> Any:
    return next(
        body.shape for body in sessions.shown(bpy.context.scene).reading.bodies if body.name == name
    )


@pytest.fixture
def ring(scene, add_box):
    """A torus around z, 0.2 m thick, with a hand in its hole and a block under it; none haptic
    yet."""
    bpy.ops.mesh.primitive_torus_add(major_radius=0.5, minor_radius=0.1)
    torus = bpy.context.object
    torus.name = "ring"
    hand = add_box("hand", (0, 0, 0), (0.2, 0.2, 0.2), haptic=False)
    block = add_box("block", (0.5, 0, -0.2), (0.2, 0.2, 0.2), haptic=False)
    return torus, hand, block


def test_a_hand_in_the_hole_of_a_ring_is_not_touched(ring):
    make_haptic(*ring)
    assert set(contacts()) == {frozenset(("ring", "block"))}
    assert shape_of("ring").type == "mesh" and shape_of("ring").sunk_in == pytest.approx(0.05)
    assert shape_of("hand").type == "convex_hull"  # which is its surface
    ring[1].location.x = 0.31  # its corners inside the ring, whose inner side is at radius 0.4
    assert contacts()[frozenset(("ring", "hand"))] == pytest.approx(
        0.4 - math.hypot(0.41, 0.1), abs=2e-3
    )


def test_a_hull_that_was_chosen_touches(ring):
    make_haptic(*ring)
    ring[0].haptics.surface = "CONVEX_HULL"
    assert frozenset(("ring", "hand")) in contacts()
    deviation = sessions.shown(bpy.context.scene).reading.hulls["ring"].deviation
    assert 0.09 < deviation < 0.11  # the inner sides are under the flat top of the hull


def test_a_lamp_in_the_air_of_a_room_is_silent(add_box):
    """Whichever way the room's faces look; what stands on its floor or is sunk into its ceiling
    touches."""
    room = add_box("room", (0, 0, 0), (6, 4, 3), haptic=False)
    lamp, table = (
        add_box("lamp", (0, 0, 1), (0.3, 0.3, 0.2), haptic=False),
        add_box("table", (2, 1, -1.1), (1, 1, 0.8), haptic=False),
    )
    make_haptic(room, lamp, table)
    assert set(contacts()) == {frozenset(("room", "table"))}
    room.data.flip_normals()
    room.data.update()
    assert set(contacts()) == {frozenset(("room", "table"))}
    assert shape_of("room").sunk_in == 0
    room.data.flip_normals()
    lamp.location.z = 1.5 - 0.1 - 0.03  # 3 cm beneath the ceiling
    assert contacts()[frozenset(("room", "lamp"))] == pytest.approx(0.03 - 0.05, abs=1e-6)
    lamp.location.z = 1.5 - 0.1 - 0.07
    assert frozenset(("room", "lamp")) not in contacts()


def test_objects_that_share_a_mesh_have_the_shapes_of_copies(ring):
    torus = ring[0]
    others = [torus.copy() for _ in range(9)]
    for k, obj in enumerate(others):
        obj.name, obj.location.x = f"other {k}", 2.0 * (k + 1)
        bpy.context.collection.objects.link(obj)
    make_haptic(torus, *others)
    chosen, _, large, mirrored, thick, body, mesh_body, whole, part = others
    chosen.haptics.surface = "CONVEX_HULL"
    large.scale = 2, 1, 1
    mirrored.scale = -1, 1, 1
    thick.modifiers.new("thick", "DISPLACE").strength = 0.05
    for obj, shape in ((body, "BOX"), (mesh_body, "MESH"), (whole, "COMPOUND"), (part, "SPHERE")):
        bpy.context.view_layer.objects.active = obj
        bpy.ops.rigidbody.object_add()
        obj.rigid_body.collision_shape = shape
    part.parent = whole

    def shapes():
        session.clear()
        contacts()
        return {body.name: body.shape for body in sessions.shown(bpy.context.scene).reading.bodies}

    shared = shapes()
    for obj in others:
        obj.data = obj.data.copy()
    assert shapes() == shared
    kinds = [shared[obj.name].type for obj in (torus, *others)]
    hull, box, whole_of = "convex_hull", "box", "compound"
    assert kinds == ["mesh", hull, *["mesh"] * 4, box, "mesh", whole_of, "sphere"]
    assert len({shared[obj.name] for obj in (torus, large, mirrored, thick, mesh_body)}) == 5


def test_the_classes_of_surfaces(scene, add_box):
    """Open surfaces are shells, also where only a seam is open; closed ones solids, also where
    vertices at a seam are double."""
    bpy.ops.mesh.primitive_monkey_add(size=1.0)
    monkey = bpy.context.object
    bpy.ops.mesh.primitive_torus_add(location=(3, 0, 0))
    split = bpy.context.object
    split.modifiers.new("seams", "EDGE_SPLIT").split_angle = 0.0
    bpy.ops.mesh.primitive_uv_sphere_add(location=(6, 0, 0), radius=0.3)
    sphere = bpy.context.object
    bpy.ops.mesh.primitive_grid_add(location=(9, 0, 0))
    grid = bpy.context.object
    mirrored = split.copy()
    scene.collection.objects.link(mirrored)
    mirrored.location.y, mirrored.scale = 5, (-1, 1, 1)
    make_haptic(monkey, split, sphere, grid, mirrored)
    contacts()
    assert (shape_of(monkey.name).type, shape_of(monkey.name).sunk_in) == ("mesh", 0.0)
    for solid in (split, mirrored):
        assert shape_of(solid.name).sunk_in == pytest.approx(0.05)
    assert shape_of(sphere.name).type == shape_of(grid.name).type == "convex_hull"
    monkey.haptics.surface, split.haptics.surface = "SOLID", "SHELL"
    contacts()
    assert (
        shape_of(monkey.name).sunk_in == pytest.approx(0.05) and shape_of(split.name).sunk_in == 0
    )


def test_a_mesh_that_changes_class_opens_and_closes_no_contact(add_box):
    """A dent grows in a convex block between two others: hull, then solid."""
    below, above = (
        add_box("below", (0, 0, -0.15), (1, 1, 0.1), haptic=False),
        add_box("above", (0.3, 0, 0.155), (0.2, 0.2, 0.1), haptic=False),
    )
    bpy.ops.mesh.primitive_cube_add(size=0.2)
    block = bpy.context.object
    block.scale.x = 4
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=2)
    bpy.ops.object.mode_set(mode="OBJECT")
    block.shape_key_add(name="Basis")
    dented = block.shape_key_add(name="dent")
    for point in dented.data:
        if abs(point.co.x) < 0.05 and point.co.z > 0.09:
            point.co.z -= 0.02
    for frame, value in ((1, 0.0), (11, 1.0)):
        dented.value = value
        dented.keyframe_insert("value", frame=frame)
    make_haptic(block, below, above)
    kinds, touching = set(), set()
    for frame in range(1, 12):
        bpy.context.scene.frame_set(frame)
        touching.add(frozenset(contacts()))
        kinds.add(shape_of(block.name).type)
    assert kinds == {"convex_hull", "mesh"}
    assert list(sessions.shown(bpy.context.scene).reading.rebuilt) == [block.name]
    assert len(touching) == 1 and len(next(iter(touching))) == 2


def test_a_rigid_body_has_blenders_shape_also_that_of_its_mesh(ring):
    make_haptic(*ring)
    torus = ring[0]
    with bpy.context.temp_override(object=torus, active_object=torus, selected_objects=[torus]):
        bpy.ops.rigidbody.object_add(type="PASSIVE")
    torus.rigid_body.collision_shape = "CONVEX_HULL"
    assert frozenset(("ring", "hand")) in contacts()
    assert sessions.shown(bpy.context.scene).reading.hulls["ring"].deviation > 0.05
    bpy.context.view_layer.objects.active = torus
    torus.rigid_body.collision_shape = "MESH"
    assert frozenset(("ring", "hand")) not in contacts()


def test_skin_that_is_too_fine_names_its_cure(add_box, monkeypatch):
    from haptic_tracing.addon.scene_reader import collision_shapes

    monkeypatch.setattr(collision_shapes, "MAX_TRIANGLES", 100)
    bpy.ops.mesh.primitive_torus_add()
    torus, box = bpy.context.object, add_box("box", (5, 0, 0), (1, 1, 1))
    make_haptic(torus)
    box.haptics.source.enabled = True
    contacts()
    (problem,) = session.problems_of(bpy.context.scene)
    assert (
        problem.object == torus.name
        and "Convex Hull" in problem.message
        and "Decimate" in problem.message
    )
    torus.haptics.surface = "CONVEX_HULL"
    contacts()
    assert session.problems_of(bpy.context.scene) == ()


def encloses(trees: dict[str, Any], corners: dict[str, Any], a: str, b: str) -> bool:
    """Whether a corner of one object is inside the other: an odd number of faces is above it."""

    def is_inside(point: Any, tree: Any) -> bool:
        count, start = 0, point
        while (hit := tree.ray_cast(start, (0.0, 0.0, 1.0)))[0] is not None:
            count, start = count + 1, hit[0] + Vector((0, 0, 1e-5))
        return count % 2 == 1

    return is_inside(corners[a][0], trees[b]) or is_inside(corners[b][0], trees[a])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_what_blender_finds_to_overlap_touches_and_what_is_apart_does_not(scene, seed):
    """Suzanne, rings and cones in random poses, against the trees of triangles of Blender
    itself."""
    draw = random.Random(seed)
    makers = (
        lambda: bpy.ops.mesh.primitive_monkey_add(size=0.8),
        lambda: bpy.ops.mesh.primitive_torus_add(
            major_radius=0.4, minor_radius=0.12, major_segments=24, minor_segments=10
        ),
        lambda: bpy.ops.mesh.primitive_cone_add(radius1=0.3, depth=0.6),
        lambda: bpy.ops.mesh.primitive_torus_add(
            major_radius=0.3, minor_radius=0.08, major_segments=7, minor_segments=4
        ),
    )
    objects = []
    for k in range(24):
        makers[k % len(makers)]()
        obj = bpy.context.object
        obj.location = [draw.uniform(-0.8, 0.8) for _ in range(3)]
        obj.rotation_euler = [draw.uniform(0, 6) for _ in range(3)]
        obj.scale = [draw.uniform(0.5, 1.2)] * 3
        objects.append(obj)
    make_haptic(*objects)
    found = contacts()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    trees, corners = {}, {}
    for obj in objects:
        mesh = obj.evaluated_get(depsgraph).data
        corners[obj.name] = [obj.matrix_world @ vertex.co for vertex in mesh.vertices]
        trees[obj.name] = BVHTree.FromPolygons(
            corners[obj.name], [tuple(face.vertices) for face in mesh.polygons]
        )
    tolerance = scene.haptics.contact_tolerance
    overlapping = apart = 0
    for a, b in itertools.combinations(trees, 2):
        if trees[a].overlap(trees[b]):
            overlapping += 1
            assert found[frozenset((a, b))] <= 1e-4
        else:  # no corner of either is nearer to the other than the surfaces are
            nearest = min(
                min(trees[p].find_nearest(corner)[3] for corner in corners[q])
                for p, q in ((a, b), (b, a))
            )
            distance = found.get(frozenset((a, b)))
            if distance is None:
                apart += 1
                assert nearest > tolerance - 1e-4 or encloses(trees, corners, a, b)
            else:
                assert distance <= nearest + 1e-4
    assert overlapping > 15 and apart > 100


@pytest.mark.parametrize("has_root", [False, True])
def test_what_stands_still_to_its_parent_is_computed_once(scene, add_box, add_empty, has_root):
    """A link of a robot and two shells on it, far from the origin; one shell begins to move. Or all
    three hang on an empty, as in files of other programs."""
    link = add_box("link", (20, 5, 1), (0.5, 0.2, 0.2), haptic=False)
    carrier = link
    if has_root:
        carrier = add_empty("root", (20, 5, 1))
        carrier.scale, link.scale = link.scale.copy(), (1, 1, 1)
        link.parent, link.location = carrier, (0, 0, 0)
    shells = [
        add_box(f"shell {k}", (0.2 - 0.4 * k, 0, 0.1), (0.4, 1, 1), haptic=False) for k in (0, 1)
    ]
    for shell in shells:
        shell.parent = carrier
    carrier.rotation_mode = "XYZ"
    for frame in (1, 20):
        carrier.rotation_euler, carrier.location.y = (frame / 9, frame / 5, 0), frame
        carrier.keyframe_insert("rotation_euler", frame=frame)
        carrier.keyframe_insert("location", frame=frame)
        if frame == 20:
            shells[1].keyframe_insert("location", frame=10)
            shells[1].location.z += 0.02
            shells[1].keyframe_insert("location", frame=frame)
    make_haptic(link, *shells)
    link.haptics.source.enabled = shells[0].haptics.listener.enabled = True
    scene.haptics.impacts = False
    queries = []
    for frame in range(1, 21):
        scene.frame_set(frame)
        result = session.result_of(scene)
        queries.append(result.statistics["contact_queries"])
        pose = dict(zip(result.objects, sessions.shown(scene).reading.transforms, strict=True))
        for obj in (link, *shells):
            place = Vector(pose[obj.name][:3, 3])
            assert (place - obj.matrix_world.translation).length < 1e-4
    assert queries[0] > 0 and set(queries[1:10]) == {0} and min(queries[11:]) > 0


def test_a_mesh_without_extent_names_a_cure(add_box):
    point = add_box("point", (0, 0, 0), (1, 1, 1))
    for vertex in point.data.vertices:
        vertex.co = (1, 1, 1)
    contacts()
    (problem,) = session.problems_of(bpy.context.scene)
    assert problem.object == "point" and "move them apart" in problem.message


def as_seen(obj) -> fcl.CollisionObject:
    """The surface that Blender shows of a mesh."""
    mesh, model = obj.data, fcl.BVHModel()
    mesh.calc_loop_triangles()
    places = [tuple(obj.matrix_world @ vertex.co) for vertex in mesh.vertices]
    triangles = [tuple(triangle.vertices) for triangle in mesh.loop_triangles]
    model.beginModel(len(places), len(triangles))
    model.addSubModel(np.array(places), np.array(triangles))
    model.endModel()
    return fcl.CollisionObject(model)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_sheared_object_touches_where_it_is_seen(add_box, mirrored):
    """A turned child of a parent whose scale differs from axis to axis."""
    parent = add_box("parent", (0, 0, 0), (0.1, 0.1, 0.1), haptic=False)
    parent.scale = (-3.0 if mirrored else 3.0, 1.0, 0.6)
    child = add_box("child", (0, 0, 0), (0.4, 0.3, 0.2), haptic=False)
    child.parent = parent
    child.location = (0.5, 0.2, 0.9)
    finger = add_box("finger", (0, 0, 0), (0.05, 0.05, 0.05), haptic=False)
    make_haptic(child, finger)
    touching = apart = 0
    for turn in (0.0, 0.4, 0.9, 1.7):
        child.rotation_euler = (turn, 0.7 * turn, -1.3 * turn)
        bpy.context.view_layer.update()
        middle = child.matrix_world.translation.copy()
        for vertex in child.data.vertices:
            corner = child.matrix_world @ vertex.co
            for away in (0.005, 0.03, 0.05):
                finger.location = corner + away * (corner - middle).normalized()
                found = contacts().get(frozenset(("child", "finger")))
                distance = fcl.distance(
                    as_seen(child), as_seen(finger), fcl.DistanceRequest(), fcl.DistanceResult()
                )
                if distance > 0.0051:  # the tolerance of so small a finger
                    apart += 1
                    assert found is None
                elif distance < 0.0049:
                    touching += 1
                    assert found == pytest.approx(distance, abs=1e-5) if distance > 0 else found < 0
    assert touching >= 40 and apart >= 20


@pytest.mark.parametrize("through_empties", [False, True])
def test_a_keyed_link_conducts_at_its_joint(scene, add_box, add_empty, through_empties):
    """A forearm, scaled, turns by 1 rad about its end in the end of an upper arm that turns."""
    upper = add_box("upper", (0, 0, 1), (0.2, 0.2, 1), haptic=True)
    fore = add_box("fore", (0, 0, 1.99), (0.2, 0.2, 1), haptic=True)
    bpy.context.view_layer.update()
    elbow = add_empty("elbow", (0, 0, 1.5))
    shoulder = add_empty("shoulder", (0, 0, 0.5))
    bpy.context.view_layer.update()
    for child, parent in ((upper, shoulder), (fore, elbow), (elbow, shoulder)):
        child.parent, child.matrix_parent_inverse = parent, parent.matrix_world.inverted()
    if not through_empties:
        elbow.parent, elbow.matrix_parent_inverse = upper, upper.matrix_world.inverted()
    for obj in (shoulder, elbow):
        obj.rotation_mode = "XYZ"
        for frame in (1, 20):
            obj.rotation_euler.x = frame / 20
            obj.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.view_layer.update()
    for frame in (1, 7, 20):
        scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        contacts = session.trace(scene, depsgraph).contacts
        beside = contacts.positions[0] - np.array(elbow.matrix_world.translation)
        expected = contacts.depth[0] / 2
        np.testing.assert_allclose(np.linalg.norm(beside, axis=1), expected, atol=1e-5)
