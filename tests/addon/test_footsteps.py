"""*Footsteps* makes a character that walks over wood, gravel and carpet felt in its feet."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bmesh
import bpy
import pytest
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.panels import hints
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view.levels import shown_levels
from mathutils import Matrix, Vector

FLOORS = ("wooden floor", "gravel path", "carpet")
STEP, STRIDE, LIFT = 12, 0.7, 0.15
"""Frames and metres of a step, and the height of a swinging foot [m]."""


@pytest.fixture
def walker(scene: Any, add_box: Any) -> Any:
    """A figure of boxes on bones that takes six steps over three floors whose tops are at z = 0,
    its feet coming down straight."""
    for number, name in enumerate(FLOORS):
        add_box(name, (number * 2 * STRIDE, 0, -0.1), (2 * STRIDE, 2, 0.2), haptic=False)
    parts = {"spine": ((0, 0, 0.9), (0, 0, 1.5)), "head": ((0, 0, 1.5), (0, 0, 1.75))}
    for side, y in (("L", 0.12), ("R", -0.12)):
        parts |= {
            f"thigh.{side}": ((0, y, 0.9), (0, y, 0.5)),
            f"shin.{side}": ((0, y, 0.5), (0, y, 0.1)),
            f"foot.{side}": ((0, y, 0.05), (0.2, y, 0.05)),
        }
    data = bpy.data.armatures.new("Walker")
    rig = bpy.data.objects.new("Walker", data)
    scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    for name, (head, tail) in parts.items():
        bone = data.edit_bones.new(name)
        bone.head, bone.tail = head, tail
        above = {"thigh": "spine", "shin": "thigh", "foot": "shin", "head": "spine"}
        kind, dot, side = name.partition(".")
        if kind in above:
            own = above[kind]
            bone.parent = data.edit_bones[own if own == "spine" else own + dot + side]
    bpy.ops.object.mode_set(mode="OBJECT")
    shape, groups = bmesh.new(), {}
    for name, ends in parts.items():
        head, tail = map(Vector, ends)
        size = [max(0.1, abs(a - b)) for a, b in zip(head, tail, strict=True)]
        place = Matrix.Translation((head + tail) / 2) @ Matrix.Diagonal((*size, 1))
        made = bmesh.ops.create_cube(shape, size=1.0, matrix=place)
        shape.verts.index_update()
        groups[name] = [vertex.index for vertex in made["verts"]]
    mesh = bpy.data.meshes.new("Skin")
    shape.to_mesh(mesh)
    shape.free()
    skin = bpy.data.objects.new("Skin", mesh)
    scene.collection.objects.link(skin)
    for name, vertices in groups.items():
        skin.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
    skin.parent = rig
    skin.modifiers.new("Armature", "ARMATURE").object = rig
    scene.frame_start, scene.frame_end, scene.render.fps = 1, 1 + 6 * STEP, 24
    for step in range(7):
        rig.location.x = step * STRIDE * 2 / 3
        rig.keyframe_insert("location", frame=1 + step * STEP)
        for number, side in enumerate("LR"):
            bone = rig.pose.bones[f"thigh.{side}"]
            up = data.bones[bone.name].matrix_local.to_3x3().inverted() @ Vector((0, 0, LIFT))
            for part, height in ((0, 0.0), (STEP // 2, 1.0), (STEP, 0.0)):
                bone.location = up * height * (step % 2 == number)
                bone.keyframe_insert("location", frame=1 + step * STEP + part)
    for curve in fcurves_of(rig):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.frame_set(1)
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    return SimpleNamespace(rig=rig, skin=skin)


def blows_of(scene: Any) -> list[tuple[int, Any]]:
    """The impacts of the whole scene, with the frame of each."""
    found = []
    for frame in range(1, scene.frame_end + 1):
        scene.frame_set(frame)
        found += [(frame, impact) for impact in session.result_of(scene).impacts]
    return found


def test_the_floors_under_its_feet_become_haptic_in_one_step(scene, walker, add_box):
    far = add_box("far wall", (0, 8, 0), (1, 1, 1), haptic=False)
    assert bpy.ops.haptic.add_footsteps() == {"FINISHED"}
    assert walker.skin.haptics.enabled and not far.haptics.enabled
    materials = [scene.objects[name].haptics.material.name for name in FLOORS]
    assert len(set(materials)) == 3, materials
    feet = [obj for obj in walker.rig.children if "foot" in obj.haptics.listener.body_part]
    assert len(feet) == 2 and scene.frame_current == 1
    bpy.ops.haptic.add_footsteps()
    assert len(scene.haptics.impact_table.items) == 1


def test_a_walk_is_felt_in_the_feet(scene, walker):
    bpy.ops.haptic.add_footsteps()
    for frame in range(1, scene.frame_end + 1):
        scene.frame_set(frame)
        session.result_of(scene)
        step, part = divmod(frame - 1, STEP)
        if step and not part:  # two steps on each floor
            levels = shown_levels(sessions.shown(scene), False)
            felt = [level.title for level in levels if level.is_felt]
            assert ("foot.L", "foot.R")[1 - step % 2] in felt, (step, felt)


@pytest.mark.parametrize("modifier", [None, "DECIMATE", "EDGE_SPLIT", "SOLIDIFY", "WELD"])
def test_feet_strike_with_the_energies_of_walking(scene, walker, modifier):
    """Feet that come down flat at 0.6 m/s once a step, with the effective mass of a heel, 6.3 % of
    the body's (Chi and Schmitt, J. Biomechanics 2005), by that of the reference adult (73 kg, 1.76
    m, ICRP Publication 89) at this height; heels of people strike with 0.2 to 4 J."""
    if modifier is not None:
        walker.skin.modifiers.new(modifier, modifier)
    bpy.ops.haptic.add_footsteps()
    blows = blows_of(scene)
    assert [(frame - 1) / STEP for frame, _ in blows] == [1, 2, 3, 4, 5, 6]
    speed, mass = LIFT / (STEP / 2 / 24), 0.063 * 73.0 * (1.70 / 1.76) ** 3
    for _, impact in blows:
        assert 0.2 <= impact.energy <= 4.0
        assert impact.energy == pytest.approx(mass * speed**2 / 2, rel=0.01)
        assert abs(impact.normal[2]) == pytest.approx(1.0)
        assert min(abs(place[2]) for place in impact.positions) < 1e-6


def test_feet_that_stand_or_slide_on_the_ground_strike_nothing(scene, walker):
    bpy.ops.haptic.add_footsteps()
    for curve in fcurves_of(walker.rig):
        if "pose.bones" in curve.data_path:
            curve.mute = True
    assert not blows_of(scene)
    walker.rig.animation_data_clear()
    assert not blows_of(scene)


def test_what_strikes_nothing_is_said_with_the_character(scene, walker, add_box):
    box = add_box("seat", (0, 5, 0), (1, 1, 1))
    box.haptics.listener.enabled = True
    scene.frame_set(2)
    words = "Nothing strikes: no object of 'Walker' is haptic"
    assert hints.striking_nothing(scene) == ("Walker", words)
    walker.skin.haptics.enabled = True
    box.haptics.enabled = False
    assert "what it walks on" in hints.striking_nothing(scene)[1]
    bpy.ops.haptic.add_footsteps()
    assert hints.striking_nothing(scene) is None


def test_what_is_keyed_strikes_without_a_rigid_body(scene, add_box):
    """A box of 0.2 m comes down 1.2 m in half a second: half of 8 l of its material's density."""
    floor = add_box("floor", (0, 0, -0.1), (2, 2, 0.2))
    floor.haptics.listener.enabled = True
    box = add_box("hammer", (0, 0, 1.3), (0.2, 0.2, 0.2))
    box.haptics.function = "physical"
    for frame, height in ((1, 1.3), (13, 0.1), (24, 0.1)):
        box.location.z = height
        box.keyframe_insert("location", frame=frame)
    for curve in fcurves_of(box):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.frame_end = 24
    ((frame, impact),) = blows_of(scene)
    density = next(
        item.propagation.density
        for item in sessions.shown(scene).reading.objects
        if item.name == "hammer"
    )
    assert frame == 13
    assert impact.energy == pytest.approx(0.2**3 * density * 2.4**2 / 2, rel=0.02)
