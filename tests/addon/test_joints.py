"""Parts that bones, drivers or constraints turn on each other conduct at the pivot, against where
Blender has it, and against tracing of the same parts without joints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.contacts.tracker import ContactTracker
from mathutils import Matrix, Vector
from written_scenes import read_scene


def found() -> Any:
    """The contacts of the current frame, every pair of bodies queried."""
    scene = bpy.context.scene
    return session.trace(scene, bpy.context.evaluated_depsgraph_get()).contacts


def without_joints() -> ContactSet:
    """The contacts in the poses of the last trace as they are between any bodies."""
    reading = sessions.shown(bpy.context.scene).reading
    settings = replace(reading.contact_settings, joints=())
    return ContactTracker(reading.bodies, settings).update(0.0, reading.transforms).contacts


def joints() -> Any:
    return sessions.shown(bpy.context.scene).reading.contact_settings.joints


def assert_at(pivot: Any, contacts: ContactSet, row: int = 0, tolerance: float = 1e-5) -> None:
    """That a contact has its nodes at a pivot: on each object half its depth beside it."""
    beside = np.linalg.norm(contacts.positions[row] - np.array(pivot), axis=1)
    np.testing.assert_allclose(beside, np.abs(contacts.distance[row]) / 2, atol=tolerance)


def keyed(obj: Any, path: str, *values: tuple[int, Any]) -> None:
    for frame, value in values:
        prefix, _, name = path.rpartition(".")
        owner = obj.path_resolve(prefix) if prefix else obj
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)


def on_bone(obj: Any, rig: Any, bone: str) -> None:
    """Parent an object to a bone where it is."""
    bpy.context.view_layer.update()
    tail = Matrix.Translation((0, rig.data.bones[bone].length, 0))
    carried = rig.matrix_world @ rig.pose.bones[bone].matrix @ tail
    obj.parent, obj.parent_type, obj.parent_bone = rig, "BONE", bone
    obj.matrix_parent_inverse = carried.inverted()


@pytest.fixture
def arm(scene, add_box):
    """Two bones on top of each other, of which the second one turns about (0, 0, 1.5), and a rod of
    20 x 20 cm on each that overlap there by 1 cm; a bracket of the lower one touches neither."""

    def add(connected: bool = False) -> Any:
        rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        lower, upper = map(rig.data.edit_bones.new, ("lower", "upper"))
        lower.head, lower.tail, lower.roll = (0, 0, 0.5), (0, 0, 1.5), 0.4
        upper.head, upper.tail = (0, 0, 1.5), (0, 0.2, 2.5)
        upper.parent, upper.use_connect = lower, connected
        bpy.ops.object.mode_set(mode="OBJECT")
        for name, z in (("lower", 1.0), ("upper", 1.99)):
            on_bone(add_box(f"{name} rod", (0, 0, z), (0.2, 0.2, 1)), rig, name)
            rig.pose.bones[name].rotation_mode = "XYZ"
        return rig

    return add


def turned_by_keys(rig: Any) -> None:
    keyed(rig, 'pose.bones["upper"].rotation_euler', (1, (0.5, 0, 0)), (20, (1.2, 0.3, 0)))
    keyed(rig, 'pose.bones["upper"].location', (1, (0, 0, 0)), (20, (0, 0, 0)))


def turned_by_a_constraint(rig: Any) -> None:
    target = bpy.data.objects.new("target", None)
    bpy.context.scene.collection.objects.link(target)
    keyed(target, "location", (1, (0, 1, 2)), (20, (1, 1, 1.5)))
    rig.pose.bones["upper"].constraints.new("IK").target = target


def turned_by_a_driver(rig: Any) -> None:
    curve = rig.pose.bones["upper"].driver_add("rotation_euler", 0)
    curve.driver.expression = "frame / 20"


TURNS = [turned_by_keys, turned_by_a_constraint, turned_by_a_driver]


@pytest.mark.parametrize("connected", [False, True])
@pytest.mark.parametrize("turns", TURNS)
def test_parts_of_a_bone_and_its_parent_conduct_at_its_head(scene, arm, turns, connected):
    rig = arm(connected)
    contact = found()
    at_rest = without_joints()
    np.testing.assert_allclose(contact.area, at_rest.area, rtol=1e-4)
    np.testing.assert_allclose(contact.area, [0.04], rtol=1e-4)
    np.testing.assert_allclose(contact.distance, at_rest.distance, atol=1e-6)
    np.testing.assert_allclose(contact.positions, at_rest.positions, atol=0.006)
    turns(rig)
    for frame in (1, 8, 20):
        rig.location, rig.rotation_euler = (frame, 2, 3), (0, frame / 5, 0)
        scene.frame_set(frame)
        contact = found()
        assert len(contact) == 1
        head = np.array(rig.matrix_world @ rig.pose.bones["upper"].head)
        assert_at(head, contact)
        np.testing.assert_allclose(contact.area, at_rest.area, rtol=1e-4)
        np.testing.assert_allclose(contact.depth, [0.01], atol=1e-5)


def test_levels_at_rest_are_those_of_parts_without_a_joint(scene, arm, add_box, traced):
    """Two rods beside the arm's, of the same places, that nothing holds together."""
    arm()
    names = "lower rod", "upper rod"
    for name in names:
        rod = scene.objects[name]
        add_box(f"loose {name}", rod.matrix_world.translation + Vector((5, 0, 0)), (0.2, 0.2, 1))
    for kind in ("", "loose "):
        scene.objects[f"{kind}lower rod"].haptics.source.enabled = True
        scene.objects[f"{kind}upper rod"].haptics.listener.enabled = True
    result = traced()
    assert [set(joint.objects) for joint in joints()] == [set(names)]
    of_arm, loose = np.sort(result.amplitudes[result.amplitudes > 0])
    assert abs(20 * np.log10(of_arm / loose)) < 0.1


@pytest.mark.parametrize("scale", [0.5, 2.0, -1.0])
def test_a_scaled_armature_has_its_joints_where_they_are_seen(scene, arm, scale):
    rig = arm()
    scene.unit_settings.scale_length = 0.5
    rig.scale, rig.rotation_euler = (scale,) * 3, (0.3, 0.2, 0.1)
    turned_by_keys(rig)
    scene.frame_set(20)
    contact = found()
    head = 0.5 * np.array(rig.matrix_world @ rig.pose.bones["upper"].head)
    assert_at(head, contact)
    np.testing.assert_allclose(contact.area, [0.04 * (0.5 * scale) ** 2], rtol=1e-4)


def test_a_bone_that_slides_is_no_joint(scene, arm):
    rig = arm()
    turned_by_keys(rig)
    keyed(rig, 'pose.bones["upper"].location', (20, (0, 0.004, 0)))
    scene.frame_set(10)
    contact = found()
    assert joints() == ()
    anew = without_joints()
    np.testing.assert_allclose(contact.positions, anew.positions, atol=1e-9)


def test_a_joint_that_a_constraint_parts_is_none(scene, arm, add_empty):
    rig = arm()
    turned_by_keys(rig)
    away = add_empty("away", (0.05, 0, 1.5))
    pulled = rig.pose.bones["upper"].constraints.new("COPY_LOCATION")
    pulled.target = away
    scene.frame_set(10)
    contact = found()
    assert len(joints()) == 1
    np.testing.assert_allclose(contact.positions, without_joints().positions, atol=1e-9)
    away.location.x = 0.0
    scene.frame_set(11)
    assert_at((0, 0, 1.5), found())


def test_what_is_on_the_same_bone_is_computed_once(scene, arm, add_box):
    """Under bones that turn, also where no tagged object is the first of the armature's."""
    rig = arm()
    scene.objects["lower rod"].haptics.source.enabled = True
    for side in (-1, 1):
        plate = add_box(f"plate {side}", (0.2 * side, 0, 2.3), (0.2, 0.2, 0.2))
        on_bone(plate, rig, "upper")
        plate.haptics.listener.enabled = True
    turned_by_keys(rig)
    keyed(rig, "location", (1, (0, 0, 0)), (20, (30, 5, 2)))
    keyed(rig, "rotation_euler", (1, (0, 0, 0)), (20, (1, 2, 3)))
    for frame in range(2, 21):
        scene.frame_set(frame)
        result = session.result_of(scene)
        assert len(result.contacts) == 3
        asked, near = (result.statistics[k] for k in ("contact_queries", "candidate_pairs"))
        assert frame < 4 or asked <= near - 3


def test_a_driver_that_turns_is_a_joint_and_one_that_moves_is_none(scene, add_box):
    post = add_box("post", (0, 0, 0.5), (0.2, 0.2, 1))
    blade = add_box("blade", (0, 0, 1.005), (1, 0.2, 0.2))
    bpy.context.view_layer.update()
    blade.parent, blade.matrix_parent_inverse = post, post.matrix_world.inverted()
    blade.rotation_euler.z = 0.7
    for index in range(3):
        blade.driver_add("rotation_euler", index).driver.expression = f"frame * {index} / 20"
    for frame in (3, 12):
        scene.frame_set(frame)
        assert_at(blade.matrix_world.translation, found())
    driver = blade.driver_add("location", 0)
    driver.driver.expression = "frame / 1000"
    bpy.context.view_layer.update()
    positions = found().positions
    assert joints() == ()
    np.testing.assert_allclose(positions, without_joints().positions, atol=1e-9)


def test_a_part_of_a_link_has_its_joints(scene, add_box, add_empty):
    """A hub, fixed to an arm that turns and moves, and a wheel that keys turn on it about an axle
    whose origin is further out: they conduct on the axis, in the middle of where it is in the bounds
    of both, from 0.15 - 0.01 to 0.16 + 0.01 m, with the tolerance."""
    root = add_empty("root")
    bodies = [
        add_box("arm", (0.5, 0, 0), (1, 0.1, 0.1)),
        add_box("hub", (1, 0, 0.1), (0.1, 0.1, 0.12)),
        add_box("wheel", (1, 0, 0.18), (0.8, 0.8, 0.06)),
    ]
    axle = add_empty("axle", (1, 0, 0.5))
    bpy.context.view_layer.update()
    for child, parent in zip(
        (*bodies[:2], axle, bodies[2]), (root, *bodies[:2], axle), strict=True
    ):
        child.parent, child.matrix_parent_inverse = parent, parent.matrix_world.inverted()
    keyed(root, "location", (1, (0, 0, 0)), (20, (1, 2, 3)))
    keyed(axle, "rotation_euler", (1, (0, 0, 0)), (20, (0, 0, 5)))
    for frame in (1, 7, 20):
        scene.frame_set(frame)
        contacts = found()
        assert [set(joint.objects) for joint in joints()] == [{"hub", "wheel"}]
        names = sorted(obj.name for obj in bodies)
        pairs = [{names[k] for k in pair} for pair in contacts.pairs.tolist()]
        place = axle.matrix_world @ Vector((0, 0, 0.155 - 0.5))
        assert_at(place, contacts, pairs.index({"hub", "wheel"}))


def simulated(add_box: Any, add_empty: Any, kind: str) -> tuple[Any, Any, Any]:
    """A door of 2 kg on a fixed frame, which gravity turns about an axis along y at one end."""
    frame = add_box("frame", (-0.145, 0, 2), (0.3, 0.3, 0.3), "PASSIVE")
    door = add_box("door", (0.495, 0, 2), (1, 0.2, 0.1), "ACTIVE", mass=2.0)
    frame.rigid_body.collision_shape = door.rigid_body.collision_shape = "BOX"
    frame.haptics.source.enabled = door.haptics.listener.enabled = True
    hinge = add_empty("hinge", (0, 0, 2))
    hinge.rotation_euler.x = np.pi / 2
    bpy.context.view_layer.objects.active = hinge
    bpy.ops.rigidbody.constraint_add(type=kind)
    constraint = hinge.rigid_body_constraint
    constraint.object1, constraint.object2 = frame, door
    constraint.disable_collisions = True
    return frame, door, hinge


@pytest.mark.parametrize("kind", ["HINGE", "POINT", "FIXED"])
def test_bodies_of_a_simulated_constraint_conduct_at_its_place(scene, add_box, add_empty, kind):
    _, door, hinge = simulated(add_box, add_empty, kind)
    scene.frame_set(1)
    at_rest = found()
    np.testing.assert_allclose(at_rest.area, without_joints().area, rtol=1e-4)
    np.testing.assert_allclose(at_rest.area, [0.02], rtol=1e-4)
    begin = door.matrix_world.copy()
    swung = 0.0
    for frame in range(2, 25):
        scene.frame_set(frame)
        contacts = session.result_of(scene).contacts
        assert len(contacts) == 1
        pivot = door.matrix_world @ begin.inverted() @ hinge.matrix_world.translation
        swung = max(swung, (door.matrix_world.translation - begin.translation).length)
        assert_at(pivot, contacts, tolerance=0.005)
        np.testing.assert_allclose(contacts.area, at_rest.area, rtol=1e-5)
    assert swung > 0.5 or kind == "FIXED"


@pytest.mark.parametrize("change", ["SLIDER", "disabled", "broken"])
def test_a_constraint_that_lets_go_is_no_joint(scene, add_box, add_empty, change):
    _, door, hinge = simulated(add_box, add_empty, change if change == "SLIDER" else "HINGE")
    constraint = hinge.rigid_body_constraint
    constraint.enabled = change != "disabled"
    if change == "SLIDER":
        hinge.rotation_euler = (0, np.pi / 2, 0)  # along which it slides down
    if change == "broken":
        constraint.type = "FIXED"
        constraint.use_breaking, constraint.breaking_threshold = True, 0.01
    for frame in range(1, 25):
        scene.frame_set(frame)
        contacts = session.result_of(scene).contacts
        if frame in (12, 24):
            positions = without_joints().positions
            np.testing.assert_allclose(contacts.positions, positions, atol=1e-9)
    assert (len(joints()) == 1) is (change == "broken")
    assert door.matrix_world.translation.z < 1.5


@pytest.mark.parametrize("turns", TURNS)
def test_joints_do_not_depend_on_the_frame(scene, arm, turns, tmp_path):
    """In which they were read first: also exports have the same."""
    turns(arm())
    seen = set()
    for frame in (1, 20, 7):
        session.clear()
        scene.frame_set(frame)
        found()
        seen.add(joints())
    path = tmp_path / "scene.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(path))
    assert seen == {read_scene(path).rules.joints}
    assert len(joints()) == 1


def test_edits_of_what_hangs_together_count_at_once(scene, arm):
    rig = arm()
    turned_by_keys(rig)
    bpy.context.view_layer.update()
    found()
    assert len(joints()) == 1
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones["upper"].head.z = 1.495
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    found()
    head = np.array(rig.matrix_world @ rig.pose.bones["upper"].head)
    assert_at(head, found())
    rig.pose.bones["upper"].driver_add("location", 1).driver.expression = "frame / 1000"
    bpy.context.view_layer.update()
    found()
    assert joints() == ()
    assert compatibility.is_animated(rig, {'pose.bones["upper"].location'})
