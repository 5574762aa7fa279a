"""An edit of a mesh is seen whenever it was made, and nothing is built anew where no mesh
changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import pytest
from haptic_tracing.addon.registration import handlers
from haptic_tracing.addon.scene_reader import collision_shapes, shapes
from haptic_tracing.addon.session import session


@pytest.fixture
def boxes(add_box: Callable[..., Any], scene: Any) -> list[Any]:
    """A plank with a source, and a box that stands on it and listens, until its mesh is edited."""
    found = [
        add_box("plank", (0, 0, 0), (4, 1, 0.2)),
        add_box("box", (1.5, 0, 0.35), (0.5, 0.5, 0.5)),
    ]
    found[0].haptics.source.enabled = found[1].haptics.listener.enabled = True
    bpy.context.view_layer.update()
    assert contacts(scene) == 1
    return found


def lift(mesh: Any) -> None:
    """Move all vertices of a mesh up by its height."""
    for vertex in mesh.vertices:
        vertex.co.z += 1.0
    mesh.update()
    bpy.context.view_layer.update()


def contacts(scene: Any) -> int:
    result = session.result_of(scene)
    return 0 if result is None else len(result.contacts)


def test_an_edit_while_tracing_is_on(boxes, scene):
    lift(boxes[1].data)
    assert contacts(scene) == 0


def test_an_edit_while_tracing_is_off(boxes, scene):
    scene.haptics.tracing = False
    lift(boxes[1].data)
    scene.haptics.tracing = True
    bpy.context.view_layer.update()
    assert contacts(scene) == 0


def test_an_edit_while_the_timeline_plays(boxes, scene, monkeypatch):
    monkeypatch.setattr(handlers, "is_playing", lambda: True)
    scene.frame_set(1)
    lift(boxes[1].data)
    scene.frame_set(2)
    assert contacts(scene) == 0


def test_an_edit_through_a_window_of_another_scene(boxes, scene):
    other = bpy.data.scenes.new("other")
    other.collection.objects.link(boxes[1])
    bpy.context.window.scene = other
    lift(boxes[1].data)
    bpy.context.window.scene = scene
    scene.frame_set(2)
    assert contacts(scene) == 0


@pytest.mark.parametrize("tracing", [True, False])
def test_a_modifier(boxes, scene, tracing):
    scene.haptics.tracing = tracing
    boxes[1].modifiers.new("smaller", "SUBSURF").levels = 2  # a sphere that touches no longer
    bpy.context.view_layer.update()
    scene.haptics.tracing = True
    bpy.context.view_layer.update()
    assert contacts(scene) == 0


def emptied(obj: Any) -> Any:
    """A modifier that leaves nothing of the mesh of an object."""
    modifier = obj.modifiers.new("nothing", "MASK")
    modifier.vertex_group = obj.vertex_groups.new(name="no vertex").name
    bpy.context.view_layer.update()
    return modifier


@pytest.mark.parametrize("body", [None, "BOX", "CYLINDER", "CONVEX_HULL", "MESH"])
def test_a_mesh_emptied_by_a_modifier_does_not_conduct_after_a_click_elsewhere(boxes, scene, body):
    if body is not None:
        with bpy.context.temp_override(
            object=boxes[1], active_object=boxes[1], selected_objects=[boxes[1]]
        ):
            bpy.ops.rigidbody.object_add(type="PASSIVE")
        boxes[1].rigid_body.collision_shape = body
        bpy.context.view_layer.update()
        assert contacts(scene) == 1
    modifier = emptied(boxes[1])
    assert contacts(scene) == 0
    boxes[0].select_set(True)
    bpy.context.view_layer.objects.active = boxes[0]
    bpy.context.view_layer.update()
    assert contacts(scene) == 0
    assert [problem.message for problem in session.problems_of(scene)] == [
        "its modifiers leave no vertices of its mesh"
    ]
    boxes[1].modifiers.remove(modifier)
    bpy.context.view_layer.update()
    assert contacts(scene) == 1


def test_a_mesh_emptied_in_edit_mode_has_no_vertices(boxes, scene):
    bpy.context.view_layer.objects.active = boxes[1]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.context.view_layer.update()
    assert contacts(scene) == 0
    assert [problem.message for problem in session.problems_of(scene)] == [
        "its mesh has no vertices"
    ]


def test_multiresolution_conducts_as_it_is_while_it_is_sculpted(boxes, scene):
    """Subdivision shrinks a box until it touches nothing; Sculpt Mode does not bring it back."""
    bpy.context.view_layer.objects.active = boxes[1]
    boxes[1].modifiers.new("multires", "MULTIRES")
    bpy.ops.object.multires_subdivide(modifier="multires")
    found = []
    for mode in ("OBJECT", "SCULPT", "OBJECT"):
        bpy.ops.object.mode_set(mode=mode)
        bpy.context.view_layer.update()
        found.append(contacts(scene))
    assert found == [0, 0, 0]
    boxes[1].modifiers["multires"].levels = 0
    bpy.context.view_layer.update()
    assert contacts(scene) == 1


def test_an_array_whose_offset_is_another_objects_place(boxes, scene):
    """A modifier without animation follows what it refers to."""
    away = bpy.data.objects.new("away", None)
    scene.collection.objects.link(away)
    array = boxes[1].modifiers.new("array", "ARRAY")
    array.use_relative_offset, array.use_object_offset, array.offset_object = False, True, away
    boxes[1].location.z += 2.0
    for frame, z in ((1, 3.0), (2, 0.0), (3, 3.0)):
        away.location.z = z
        away.keyframe_insert("location", frame=frame)
    found = []
    for frame in (1, 2, 3):
        scene.frame_set(frame)
        found.append(contacts(scene))
    assert found == [0, 1, 0]


def test_a_mesh_bound_to_an_armature_by_parenting_alone(boxes, scene):
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("bone")
    bone.tail = (0, 1, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    boxes[1].parent, boxes[1].parent_type = rig, "ARMATURE"
    boxes[1].vertex_groups.new(name="bone").add(range(8), 1.0, "ADD")
    for frame, z in ((1, 0.0), (2, 2.0)):
        rig.pose.bones["bone"].location.z = z
        rig.pose.bones["bone"].keyframe_insert("location", frame=frame)
    found = []
    for frame in (1, 2, 1):
        scene.frame_set(frame)
        found.append(contacts(scene))
    assert found == [1, 0, 1]


def test_frames_that_are_not_traced(boxes, scene):
    """The mesh changes while tracing is off; nothing changes when it is switched on."""
    mask = emptied(boxes[1])
    for frame, seen in ((1, False), (2, True), (3, True)):
        mask.show_viewport = seen
        mask.keyframe_insert("show_viewport", frame=frame)
    scene.frame_set(1)
    assert contacts(scene) == 1
    scene.haptics.tracing = False
    scene.frame_set(2)
    scene.haptics.tracing = True
    scene.frame_set(3)
    assert contacts(scene) == 0


def test_a_part_of_a_compound(add_box, scene):
    add_box("plank", (0, 0, 0), (4, 1, 0.2)).haptics.source.enabled = True
    parent = add_box("parent", (0, 0, 3), (1, 1, 1), body="ACTIVE")
    parent.haptics.listener.enabled = True
    part = add_box("part", (0, 0, 0.35), (0.5, 0.5, 0.5), body="PASSIVE", haptic=False)
    part.parent, part.matrix_parent_inverse = parent, parent.matrix_world.inverted()
    parent.rigid_body.collision_shape = "COMPOUND"
    bpy.context.view_layer.update()
    part.matrix_world.translation = (0, 0, 0.35)
    bpy.context.view_layer.update()
    assert contacts(scene) == 1
    lift(part.data)
    assert contacts(scene) == 0


def test_shapes_are_built_once_where_only_settings_change(boxes, scene, monkeypatch):
    built = []
    build = shapes.collision_shape
    monkeypatch.setattr(
        shapes, "collision_shape", lambda *what: built.append(what[0].name) or build(*what)
    )
    boxes[0].haptics.rho = 0.5
    boxes[1].location.x = 1.0
    bpy.context.view_layer.update()
    assert built == []
    lift(boxes[1].data)
    assert built == ["box"]


@pytest.mark.parametrize("kind", ["monkey", "text", "wire"])
def test_triangles_are_those_of_blender(kind, scene):
    """Of a mesh, of a surface that is not stored as one, and of a mesh without faces."""
    match kind:
        case "monkey":
            bpy.ops.mesh.primitive_monkey_add()
        case "text":
            bpy.ops.object.text_add()
        case _:
            mesh = bpy.data.meshes.new("wire")
            mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1), (1, 2)], [])
            scene.collection.objects.link(bpy.data.objects.new("wire", mesh))
            bpy.context.view_layer.objects.active = scene.objects["wire"]
    depsgraph = bpy.context.evaluated_depsgraph_get()
    obj = bpy.context.object.evaluated_get(depsgraph)
    vertices, triangles = collision_shapes._arrays_of(obj.to_mesh())
    mesh = obj.to_mesh()
    mesh.calc_loop_triangles()
    assert triangles.tolist() == [list(item.vertices) for item in mesh.loop_triangles]
    assert vertices.tolist() == [list(item.co) for item in mesh.vertices]


def test_another_split_of_a_face_is_another_content(boxes):
    """The same vertices, in the same order at the corners: one face of six, or two triangles."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)]
    sums = []
    for faces in ([(0, 1, 2, 3, 4, 5)], [(0, 1, 2), (3, 4, 5)]):
        mesh = bpy.data.meshes.new("faces")
        mesh.from_pydata(corners, [], faces)
        boxes[1].data = mesh
        depsgraph = bpy.context.evaluated_depsgraph_get()
        sums.append(collision_shapes.mesh_checksum(boxes[1], depsgraph))
    assert sums[0] != sums[1]
