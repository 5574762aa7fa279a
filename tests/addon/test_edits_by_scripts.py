"""What a script sets between two frames counts from the next one on, also of meshes that change
from frame to frame by themselves."""

import bpy
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.contacts.settings import Motion
from making_haptic import make_haptic


def by_bones(add_box):
    """A box that a bone carries up."""
    box = add_box("box", (0, 0, 0.5), (1, 1, 1), haptic=False)
    bpy.ops.object.armature_add()
    armature = bpy.context.object
    box.modifiers.new("armature", "ARMATURE").object = armature
    box.vertex_groups.new(name="Bone").add(range(8), 1, "ADD")
    bone = armature.pose.bones["Bone"]
    for frame in (1, 20):
        bone.location.y = frame / 10
        bone.keyframe_insert("location", frame=frame)
    return box


def by_shape_key(add_box):
    """A box that a shape key stretches."""
    box = add_box("box", (0, 0, 0.5), (1, 1, 1), haptic=False)
    box.shape_key_add(name="Basis")
    key = box.shape_key_add(name="Tall")
    for point in key.data:
        point.co.z *= 2
    for frame in (1, 20):
        key.value = frame / 20
        key.keyframe_insert("value", frame=frame)
    return box


def at_rest(add_box):
    return add_box("box", (0, 0, 0.5), (1, 1, 1), haptic=False)


@pytest.mark.parametrize("make", [by_bones, by_shape_key, at_rest])
def test_what_a_script_sets_counts_from_the_next_frame_on(scene, add_box, make):
    box = make(add_box)
    make_haptic(box, add_box("floor", (0, 0, -0.1), (9, 9, 0.2), haptic=False))
    listener = box.haptics.listener
    listener.enabled = True

    def read():
        scene.frame_set(scene.frame_current + 1)
        session.result_of(scene)
        reading = session.of(scene).reading
        return {item.name: item for item in reading.objects}["box"], reading.listeners

    for _ in range(3):
        read()
    box.haptics.kappa = 0.125
    assert read()[0].kappa == 0.125
    box.haptics.rho = 0.25
    assert read()[0].rho == 0.25
    box.haptics.material.name = "Steel"
    assert read()[0].material == "Steel"
    listener.gain = 0.5
    assert read()[1][0].gain == 0.5
    listener.enabled = False
    assert read()[1] == ()


@pytest.mark.parametrize("make", [by_bones, by_shape_key, at_rest])
def test_a_rigid_body_counts_from_the_next_frame_on_until_it_is_removed(scene, add_box, make):
    box = make(add_box)
    make_haptic(box, add_box("floor", (0, 0, -0.1), (9, 9, 0.2), haptic=False))

    def read():
        if bpy.app.version < (4, 5):  # in a frame, an edit of a rigid body is named as a move is
            bpy.context.view_layer.update()
        scene.frame_set(scene.frame_current + 1)
        session.result_of(scene)
        (found,) = [o for o in session.of(scene).reading.objects if o.name == box.name]
        return found

    for _ in range(3):
        assert (read().motion, read().mass) == (Motion.KINEMATIC, None)
    bpy.context.view_layer.objects.active = box
    bpy.ops.rigidbody.object_add(type="PASSIVE")
    assert read().motion is Motion.STATIC
    box.rigid_body.mass = 3
    assert read().mass == 3
    assert read().layers == 1
    box.rigid_body.collision_collections = [k < 3 for k in range(20)]
    assert read().layers == 0b111
    box.rigid_body.kinematic = True
    assert read().motion is Motion.KINEMATIC
    bpy.ops.rigidbody.object_remove()
    assert read().mass is None
    box.name = "renamed"
    assert read().name == "renamed"
