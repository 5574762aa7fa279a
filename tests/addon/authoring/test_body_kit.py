"""Listeners on bodies: on the bones of an armature, in a mesh, mirrored; what is missing is
said."""

import bpy
import pytest
from haptic_tracing.core.scene.body import BODY_PART, BODY_PARTS, DEFAULT_LISTENERS
from mathutils import Matrix, Vector

# Where a body 1.8 m high that faces -y has its bones; "L" and "R" are mirrored.
_MIDDLE = {
    "Hips": (0.92, 1.0), "Spine": (1.0, 1.12), "Spine1": (1.12, 1.25), "Spine2": (1.25, 1.42), "Neck": (1.42, 1.55), "Head": (1.55, 1.8),
}  # fmt: skip
_SIDED = {
    "Arm": ((0.18, 0, 1.45), (0.2, 0, 1.15)), "ForeArm": ((0.2, 0, 1.15), (0.22, 0, 0.9)), "Hand": ((0.22, 0, 0.9), (0.22, 0, 0.8)),
    "HandIndex1": ((0.22, 0, 0.8), (0.22, -0.02, 0.72)), "UpLeg": ((0.1, 0, 0.95), (0.1, 0, 0.5)), "Leg": ((0.1, 0, 0.5), (0.1, 0, 0.1)),
    "Foot": ((0.1, 0, 0.1), (0.1, -0.15, 0.0)),
}  # fmt: skip


def _select(*objects):
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    for obj in objects:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = objects[0] if objects else None


@pytest.fixture
def armature(scene):
    """A Mixamo skeleton as it is imported: a hundredth of its size, lying on its back and stood up
    by its object."""
    data = bpy.data.armatures.new("Armature")
    obj = bpy.data.objects.new("Armature", data)
    scene.collection.objects.link(obj)
    _select(obj)
    turn = Matrix.Rotation(-1.5707963267948966, 4, "X") @ Matrix.Scale(100, 4)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (low, high) in _MIDDLE.items():
        bone = data.edit_bones.new(f"mixamorig:{name}")
        bone.head, bone.tail = turn @ Vector((0, 0, low)), turn @ Vector((0, 0, high))
    for name, (head, tail) in _SIDED.items():
        for sign, side in ((1, "Left"), (-1, "Right")):
            bone = data.edit_bones.new(f"mixamorig:{side}{name}")
            bone.head = turn @ Vector((sign * head[0], *head[1:]))
            bone.tail = turn @ Vector((sign * tail[0], *tail[1:]))
    bpy.ops.object.mode_set(mode="OBJECT")
    obj.matrix_world = turn.inverted()
    bpy.context.view_layer.update()
    return obj


@pytest.fixture
def skinned(armature, add_box):
    body = add_box("Body", (0, 0, 0.9), (0.5, 0.3, 1.8), haptic=False)
    world = body.matrix_basis.copy()
    body.parent = armature
    body.matrix_parent_inverse = armature.matrix_world.inverted()
    body.matrix_basis = world
    body.modifiers.new("Armature", "ARMATURE").object = armature
    bpy.context.view_layer.update()
    return body


def _listeners(parent):
    bpy.context.view_layer.update()
    return {
        child.haptics.listener.body_part: child
        for child in parent.children
        if child.haptics.listener.enabled
    }


@pytest.mark.parametrize(("parts", "count"), [("DEFAULT", 12), ("PAPER", 10), ("ALL", 25)])
def test_an_armature_gets_listeners_on_its_bones(armature, skinned, parts, count):
    _select(armature)
    assert bpy.ops.haptic.add_default_listeners(parts=parts) == {"FINISHED"}
    listeners = _listeners(armature)
    assert len(listeners) == count
    for name, listener in listeners.items():
        place = listener.matrix_world.translation
        side = BODY_PART[name].side
        assert (place.x > 0.01, place.x < -0.01) == (side == "L", side == "R")
        assert tuple(listener.matrix_world.to_scale()) == pytest.approx((1, 1, 1), rel=1e-3)
        assert listener.empty_display_size == pytest.approx(BODY_PART[name].radius)
    assert listeners["hand.L"].parent_bone == "mixamorig:LeftHand"
    assert tuple(listeners["hand.L"].matrix_world.translation) == pytest.approx(
        (0.22, 0, 0.85), abs=1e-3
    )


def test_they_follow_their_bones_and_feel_through_the_body(armature, skinned, traced):
    _select(armature)
    bpy.ops.haptic.add_default_listeners()
    assert armature.haptics.body == skinned
    assert skinned.haptics.material.name == "Flesh"
    skinned.haptics.source.enabled = True
    assert (traced().amplitudes > 0).all()
    listener = _listeners(armature)["hand.L"]
    before = listener.matrix_world.translation.copy()
    armature.pose.bones["mixamorig:LeftHand"].location = (0, 30, 0)
    bpy.context.view_layer.update()
    assert (listener.matrix_world.translation - before).length == pytest.approx(0.3, rel=1e-3)


def test_a_posed_body_gets_them_where_its_parts_are_now(armature, skinned):
    armature.pose.bones["mixamorig:LeftHand"].location = (0, 30, 0)
    bpy.context.view_layer.update()
    _select(skinned)
    bpy.ops.haptic.add_default_listeners()
    assert tuple(_listeners(armature)["hand.L"].matrix_world.translation) == pytest.approx(
        (0.22, 0, 0.55), abs=1e-3
    )


def test_pressing_again_adds_only_what_is_missing(armature, skinned):
    _select(armature)
    bpy.ops.haptic.add_default_listeners()
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    assert len([child for child in armature.children if child.haptics.listener.enabled]) == 25


def test_an_armature_without_a_mesh_is_told_so(armature, capfd):
    _select(armature)
    bpy.ops.haptic.add_default_listeners()
    assert "moves no mesh" in capfd.readouterr().out


def test_missing_bones_are_named(armature, skinned, capfd):
    _select(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    for side in ("Left", "Right"):
        armature.data.edit_bones.remove(armature.data.edit_bones[f"mixamorig:{side}HandIndex1"])
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.haptic.add_default_listeners(parts="ALL")
    assert "index finger.L, index finger.R" in capfd.readouterr().out
    assert len(_listeners(armature)) == 23


def test_an_armature_of_no_body_is_refused(scene):
    data = bpy.data.armatures.new("Crane")
    crane = bpy.data.objects.new("Crane", data)
    scene.collection.objects.link(crane)
    _select(crane)
    with pytest.raises(RuntimeError, match="Crane: no bone of the head"):
        bpy.ops.haptic.add_default_listeners()
    assert len(crane.children) == 0


@pytest.mark.parametrize("parts", ["DEFAULT", "ALL"])
def test_a_mesh_gets_them_where_a_standing_body_has_its_parts(add_box, parts):
    body = add_box("body", (1, 2, 3), (0.5, 0.3, 1.8), haptic=False)
    body.rotation_euler = (0.2, 0.1, 0.5)
    _select(body)
    bpy.ops.haptic.add_default_listeners(parts=parts)
    listeners = _listeners(body)
    assert set(listeners) == (
        {part.name for part in BODY_PARTS} if parts == "ALL" else set(DEFAULT_LISTENERS)
    )
    for name, listener in listeners.items():
        x, y, z = body.matrix_world.inverted() @ listener.matrix_world.translation
        assert max(abs(x), abs(y), abs(z)) <= 0.5
        assert (x > 0.01, x < -0.01) == (name.endswith(".L"), name.endswith(".R"))
        assert tuple(listener.matrix_world.to_scale()) == pytest.approx((1, 1, 1), rel=1e-4)


def test_feet_stand_below_a_body_whose_arms_reach_out(scene):
    """A trunk on two legs, and arms as wide as it is high: without an armature, feet lie within the
    legs."""
    parts = (
        ((0, 0, 1.2), (0.3, 0.3, 0.8)),
        ((0, -0.2, 1.4), (1.8, 0.1, 0.1)),
        *(((x, 0, 0.4), (0.15, 0.25, 0.8)) for x in (0.12, -0.12)),
    )
    for place, size in parts:
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        bpy.context.object.scale = size
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.join()
    bpy.ops.haptic.add_default_listeners()
    listeners = _listeners(bpy.context.object)
    for side, sign in (("L", 1), ("R", -1)):
        x, y, z = listeners[f"foot.{side}"].matrix_world.translation
        assert 0.045 <= sign * x <= 0.195 and abs(y) <= 0.125 and 0 <= z <= 0.1


def test_a_camera_has_no_body(scene):
    camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    scene.collection.objects.link(camera)
    _select(camera)
    with pytest.raises(RuntimeError, match="no surface: select the mesh or the armature"):
        bpy.ops.haptic.add_default_listeners()


def test_a_mesh_without_vertices_is_named_and_stays_as_it_is(scene):
    body = bpy.data.objects.new("Nobody", bpy.data.meshes.new("Nobody"))
    scene.collection.objects.link(body)
    _select(body)
    with pytest.raises(RuntimeError, match="Nobody: its mesh has no vertices"):
        bpy.ops.haptic.add_default_listeners()
    assert not body.haptics.enabled and len(body.children) == 0


def test_the_drawn_volume_is_the_listeners(add_empty):
    empty = add_empty("skin")
    empty.empty_display_type = "SPHERE"
    empty.haptics.listener.radius = 0.33
    assert empty.empty_display_size == pytest.approx(0.33)
