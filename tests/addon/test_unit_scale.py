"""What is traced are the metres that Blender shows: a scene modelled at another unit scale has the
same contacts, levels, impacts and files."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.io import frame_scene
from haptic_tracing.addon.panels.hints import of_units
from haptic_tracing.addon.session import session, sessions
from haptic_tracing.addon.view import doubtful_scale, overlay
from haptic_tracing.addon.view.options import options_of
from haptic_tracing.core.formats.scene.scene_json import scene_to_dict
from making_haptic import make_haptic

SCALES = (1.0, 0.01, 0.001)


def rigid(obj: Any, kind: str, shape: str, mass: float, scale: float) -> None:
    with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
        bpy.ops.rigidbody.object_add(type=kind)
    body = obj.rigid_body
    body.kinematic, body.collision_shape, body.mass = kind == "ACTIVE", shape, mass / scale**3
    body.use_margin, body.collision_margin = True, 0.002 / scale


def modelled(scale: float, add_box: Any, add_empty: Any) -> None:
    """A beam on two posts with a ring on it, a hand inside the ring's hole on the beam, a passing
    trolley, a hammer that falls on the beam, and an instance of a stone beside it."""
    scene = bpy.context.scene
    scene.unit_settings.scale_length = scale
    scene.gravity = (0, 0, -9.81 / scale)
    scene.frame_end = 20

    def box(name: str, place: tuple[float, ...], size: tuple[float, ...]) -> Any:
        obj = add_box(name, place, size, haptic=False)
        obj.location, obj.scale = obj.location / scale, obj.scale / scale
        return obj

    beam = box("wooden beam", (0, 0, 1), (4, 0.2, 0.2))
    posts = [
        box(f"steel post {k}", (x, 0, 0.45), (0.2, 0.2, 0.9)) for k, x in ((1, -1.8), (2, 1.8))
    ]
    bpy.ops.mesh.primitive_torus_add(
        major_radius=0.2 / scale, minor_radius=0.03 / scale, location=(1 / scale, 0, 1.13 / scale)
    )
    ring = bpy.context.object
    hand = box("hand", (1, 0, 1.14), (0.1, 0.1, 0.08))
    hammer = box("steel hammer", (-1, 0, 1.5), (0.1, 0.1, 0.1))
    for frame, height in ((1, 1.8), (20, 1.0)):
        hammer.location.z = height / scale
        hammer.keyframe_insert("location", index=2, frame=frame)
    cone = box("cone", (0, 0, 1.2), (0.1, 0.1, 0.2))
    make_haptic(beam, *posts, ring, hand, hammer, cone)
    rigid(hammer, "ACTIVE", "CONVEX_HULL", 12.0, scale)
    rigid(beam, "PASSIVE", "BOX", 30.0, scale)
    rigid(cone, "ACTIVE", "CYLINDER", 2.0, scale)
    stone = box("stone", (0.4, 0, 0.02), (0.2, 0.2, 0.1))
    collection = bpy.data.collections.new("stones")
    collection.objects.link(stone)
    scene.collection.objects.unlink(stone)
    stone.haptics.enabled = True
    shown = add_empty("heap", (-1 / scale, 0, 1.13 / scale))
    shown.instance_type, shown.instance_collection = "COLLECTION", collection
    source = posts[0]
    bpy.context.view_layer.objects.active = source
    source.haptics.source.enabled = True
    source.haptics.source.frequency = 60.0
    shot = cone.haptics.source
    shot.enabled = shot.one_shot = True
    shot.decay = 0.05
    shot.trigger_markers = "Shot"
    scene.timeline_markers.new("Shot", frame=9)
    listener = hand.haptics.listener
    listener.enabled, listener.radius = True, 0.05


def found() -> dict[str, Any]:
    """What is to be the same, over all frames."""
    scene, result = bpy.context.scene, {"impacts": [], "levels": [], "contacts": [], "lengths": []}
    for frame in range(1, 21):
        scene.frame_set(frame)
        traced = session.result_of(scene)
        assert traced is not None and not sessions.shown_problems(scene)
        result["impacts"] += [(i.time, i.energy, i.amplitude) for i in traced.impacts]
        with np.errstate(divide="ignore"):
            result["levels"].append(20 * np.log10(np.abs(traced.gains)).max())
        names = traced.objects
        pairs = zip(traced.contacts.pairs.tolist(), traced.contacts.distance.tolist(), strict=True)
        result["contacts"].append(
            sorted((*sorted(names[k] for k in pair), distance) for pair, distance in pairs)
        )
        drawn = overlay.GraphShapes.of(
            traced, session.of(scene).reading.settings, options_of(scene, traced)
        ).data
        result["lengths"].append(np.diff(drawn.paths.arc_length, axis=1).ravel().tolist())
        places = drawn.points.position[:, 0] @ np.array(overlay.from_metres(scene))[:3, :3].T
        hand = scene.objects["hand"].matrix_world.translation
        assert np.abs(places - hand).max(axis=1).min() < 1e-5 * hand.length
    scene.frame_set(1)
    result["file"] = scene_to_dict(frame_scene.current_scene(bpy.context))
    return result


def assert_same(one: Any, other: Any, where: str, tolerance: float = 3e-6) -> None:
    assert type(one) is type(other), where
    if isinstance(one, dict):
        assert one.keys() == other.keys(), where
        for key in one:
            assert_same(one[key], other[key], f"{where}.{key}", tolerance)
    elif isinstance(one, list | tuple):
        assert len(one) == len(other), where
        for k, pair in enumerate(zip(one, other, strict=True)):
            assert_same(*pair, f"{where}[{k}]", tolerance)
    elif isinstance(one, float):
        assert other == pytest.approx(one, rel=tolerance, abs=tolerance), where
    else:
        assert one == other, where


@pytest.mark.slow
def test_a_scene_at_another_unit_scale_is_the_same(add_box, add_empty, scene):
    results = []
    for scale in SCALES:
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        modelled(scale, add_box, add_empty)
        results.append(found())
    first = results[0]
    assert len(first["impacts"]) >= 1 and first["impacts"][0][1] > 5.0
    assert any("heap" in name for frame in first["contacts"] for *pair, _ in frame for name in pair)
    assert np.isfinite(first["levels"]).all() and max(map(len, first["lengths"])) > 3
    for other in results[1:]:
        assert other["levels"] == pytest.approx(first["levels"], abs=0.01)
        assert_same(first["impacts"], other["impacts"], "impacts", 1e-4)
        for key in ("contacts", "lengths", "file"):
            assert_same(first[key], other[key], key, 3e-6 if key == "file" else 2e-5)


def test_lengths_are_those_that_blender_shows(scene, add_box, traced):
    scene.unit_settings.scale_length = 0.01
    add_box("low", (0, 0, 0), (1, 1, 1))
    add_box("high", (0, 0, 1.05), (1, 1, 1))
    scene.haptics.contact_tolerance = 0.0002
    assert len(traced().contacts) == 0  # the gap is 0.5 mm
    scene.unit_settings.scale_length = 0.001
    assert len(traced().contacts) == 1  # 0.05 mm
    scene.unit_settings.system = "NONE"  # Blender shows units
    assert len(traced().contacts) == 0


def falling(scale: float) -> Any:
    """A scene of a crate that falls with Blender's defaults."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.unit_settings.scale_length = scale
    scene.haptics.contact_tolerance = 0.01 * scale
    for name, place, size in (("floor", (0, 0, -0.5), (8, 8, 1)), ("crate", (0, 0, 2), (1, 1, 1))):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place, scale=size)
        bpy.context.object.name = name
    make_haptic(*scene.objects)
    for name, kind in (("floor", "PASSIVE"), ("crate", "ACTIVE")):
        obj = scene.objects[name]
        with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
            bpy.ops.rigidbody.object_add(type=kind)
    return scene


def impacts_of(scene: Any) -> list[tuple[float, float]]:
    found = []
    for frame in range(1, 25):
        scene.frame_set(frame)
        found += [(impact.time, impact.energy) for impact in session.result_of(scene).impacts]
    return found


def test_gravity_that_ignores_the_scale_is_named_and_mended():
    """1 kg at a hundredth weighs a milligram, falls 1.5 cm under 0.0981 m/s², and strikes with
    1.5e-9 J."""
    scene = falling(0.01)
    hint = of_units(scene)
    assert hint.draw is not None and "Gravity" in hint.words
    assert "0.0981" in hint.words
    assert impacts_of(scene) == []
    scene.gravity.z = -9.81 / 0.01  # shown as -9.81 m/s²
    assert of_units(scene) is None
    assert math.isclose(scene.gravity.z, -981, rel_tol=1e-6)


def test_implausible_sizes_and_thousands_without_contact_are_named(scene, add_box, traced, settle):
    """An engine of 271 m whose parts are small is named by its extent, and no longer at a scale at
    which Blender shows 2.71 m."""
    for k in range(4):
        add_box(f"engine part {k}", (k * 90.3, 0, 0), (1, 1, 1))
    traced()
    assert settle(lambda: doubtful_scale.doubt(scene)) == ("engine", pytest.approx(270.9, abs=0.01))
    scene.unit_settings.scale_length = 0.01
    traced()
    assert settle(lambda: doubtful_scale.doubt(scene)) is None
    add_box("left hand", (0, 500, 0), (300, 20, 20))
    traced()
    assert settle(lambda: doubtful_scale.doubt(scene)) == ("hand", pytest.approx(3.0))
    for obj in scene.objects:
        obj.name = "part"
    for k in range(995):
        add_box("part", (0, 1000 + 30 * k, 0), (1, 1, 1))
    traced()
    assert settle(lambda: doubtful_scale.doubt(scene)) == ("", 1000)
