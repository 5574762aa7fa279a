"""Blows of keyed objects against the curves that Blender evaluates, sampled far finer than frames."""

import math

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.session import session

MASS, HEIGHT = 20.0, 1.5
KINDS = ("SINE", "QUAD", "CUBIC", "QUART", "QUINT", "EXPO", "CIRC", "BACK", "BOUNCE", "ELASTIC")
WAYS = [
    ("CONSTANT", "AUTO"),
    ("LINEAR", "AUTO"),
    ("BEZIER", "AUTO"),
    *(
        (kind, way)
        for kind in KINDS
        for way in ("EASE_IN", "EASE_OUT", "EASE_IN_OUT")
        if (kind, way) != ("CIRC", "EASE_IN")  # it ends without a bound on its speed
    ),
]
PACES = [(24, 0.0), (24, 0.625), (25, 0.25), (25, 0.875), (30, 0.375), (30, 0.5)]
PACES += [(60, 0.125), (60, 0.75)]


@pytest.fixture
def crate(add_box, scene):
    """A box of 20 kg that stands on the floor, and is keyed."""
    add_box("floor", (0, 0, -0.5), (20, 20, 1), "PASSIVE")
    box = add_box("crate", (0, 0, 0.2), (0.4, 0.4, 0.4), "ACTIVE", mass=MASS)
    box.rigid_body.kinematic = True
    return box


def keyed(obj, path, begin, end, values, kind, easing):
    """Key a property from the first of the ``values`` to the second, and return its curves."""
    for frame, value in zip((begin, end), values, strict=True):
        setattr(obj, path, value)
        obj.keyframe_insert(path, frame=frame)
    curves = fcurves_of(obj)
    for curve in curves:
        for key in curve.keyframe_points:
            key.interpolation, key.easing = kind, easing
    return curves


def blows(scene, last):
    found = []
    for frame in range(1, last + 1):
        scene.frame_set(frame)
        found += session.result_of(scene).impacts
    return found


def entries(height, begin, end, fps):
    """Times [s] and speeds [m/s] with which a curve of ``height``, by frame, comes down to 0 from
    above, each time that it has been up."""
    frames = np.linspace(begin, end, 400_001)
    heights = np.array([height(frame) for frame in frames.tolist()])
    found, up = [], heights[0] > 1e-4
    for k in range(2, len(frames)):
        if up and heights[k] <= 1e-5:
            # Back to where its steps are even: the last one may stop within itself.
            speed = (heights[k - 9] - heights[k - 1]) / (frames[k - 1] - frames[k - 9]) * fps
            jumps = heights[k - 1] - heights[k] > 0.1
            found.append(((frames[k] - 1) / fps, 0.0 if jumps else speed))
            up = False
        up = up or heights[k] > 1e-4
    return found


def told(touches):
    """Those that are blows: not within a tenth of a second after another, unless 2 dB faster."""
    blows = []
    for time, speed in touches:
        if not blows or time - blows[-1][0] >= 0.1 or speed > 1.25 * blows[-1][1]:
            blows.append((time, speed))
    return blows


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "easing"), WAYS)
def test_what_interpolation_sets_down(crate, scene, kind, easing):
    """A blow has the speed at the touch, and none comes where a curve ends at rest."""
    fps, phase = PACES[WAYS.index((kind, easing)) % len(PACES)]
    scene.render.fps = fps
    begin = 6 + phase
    end = begin + 0.4 * fps
    path = "location"
    curves = keyed(crate, path, begin, end, [(0, 0, 0.2 + HEIGHT), (0, 0, 0.2)], kind, easing)
    (curve,) = (curve for curve in curves if curve.array_index == 2)
    touches = told(entries(lambda frame: curve.evaluate(frame) - 0.2, begin, end, fps))
    expected = [(time, MASS / 2 * speed**2) for time, speed in touches]
    found = [(blow.time, blow.energy) for blow in blows(scene, math.ceil(end) + 3)]
    strong = [blow for blow in expected if blow[1] > 5]
    assert len([blow for blow in found if blow[1] > 5]) == len(strong)
    for (time, energy), (due, truth) in zip(
        [blow for blow in found if blow[1] > 5], strong, strict=True
    ):
        assert time == pytest.approx(due, abs=0.002)
        assert energy == pytest.approx(truth, rel=0.05)
    for time, energy in found:
        assert energy <= 0.5 or any(abs(time - due) < 0.002 for due, truth in expected if truth)


@pytest.mark.parametrize("parent", ["OBJECT", "BONE"])
def test_what_is_carried_by_a_curve_of_something_else(crate, scene, add_empty, parent):
    """The curves of a parent, and of a bone, count like an object's own."""
    crate.location.z = 0.0
    if parent == "OBJECT":
        carrier = add_empty("carrier", (0, 0, 0.2), None)
        crate.parent = carrier
        item, path, values = carrier, "location", [(0, 0, 0.2 + HEIGHT), (0, 0, 0.2)]
    else:
        rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("arm")
        bone.head, bone.tail = (0, 0, 0), (0, 0, 0.2)
        bpy.ops.object.mode_set(mode="OBJECT")
        crate.parent, crate.parent_type, crate.parent_bone = rig, "BONE", "arm"
        crate.rotation_euler = (-math.pi / 2, 0, 0)
        item, path, values = rig.pose.bones["arm"], "location", [(0, HEIGHT, 0), (0, 0, 0)]
    for frame, value in zip((6.3, 15.3), values, strict=True):
        setattr(item, path, value)
        item.keyframe_insert(path, frame=frame)
    owner = item.id_data
    for curve in fcurves_of(owner):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    (blow,) = blows(scene, 19)
    assert blow.time == pytest.approx(14.3 / 24, abs=0.002)
    assert blow.energy == pytest.approx(MASS / 2 * (HEIGHT / 9 * 24) ** 2, rel=0.02)
    for curve in fcurves_of(owner):
        for key in curve.keyframe_points:
            key.interpolation = "BEZIER"
    assert blows(scene, 19) == []


def test_a_door_beside_its_hinge_slams_or_is_shut_gently(add_box, scene):
    """Hinged 5 mm from the wall that it meets, it touches that throughout: the edge that comes to
    it strikes by its own speed."""
    add_box("wall", (0.5, 0.505, 1), (3, 1, 2), "PASSIVE")
    door = add_box("door", (0, 0, 1), (1, 0.04, 2), "ACTIVE", mass=12.0)
    door.rigid_body.kinematic = True
    corners = [vertex.co for vertex in door.data.vertices]
    for corner in corners:
        corner.x += 0.5
        corner.y -= 0.02
    found = {}
    for kind in ("LINEAR", "BEZIER"):
        keyed(door, "rotation_euler", 5.4, 17.4, [(0, 0, -1.2), (0, 0, 0)], kind, "AUTO")
        found[kind] = [blow for blow in blows(scene, 21) if blow.energy > 0.5]
        door.animation_data_clear()
    (slam,) = found["LINEAR"]
    assert slam.time == pytest.approx(16.4 / 24, abs=0.005)
    whole = 12.0 / 3 * (1.2 / 0.5) ** 2 / 2
    assert 0.6 * whole < slam.energy < 0.8 * whole  # 3/4, of a door without thickness
    assert found["BEZIER"] == []
