"""What the add-on traces in a Blender scene, against closed forms and against the command line on
its own export."""

import json
import math
from dataclasses import fields
from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.scene_reader.reader import SceneReader
from haptic_tracing.addon.session import session
from haptic_tracing.command_line import main


def _gain(kappa, rho, distance, epsilon=0.1):
    k = (1 - kappa) * rho
    return k * math.exp(-max(k, epsilon) * distance)


@pytest.fixture
def seesaw(add_box, add_empty):
    """A source on the left end of a plank, a listener on a box that stands on its right end."""
    plank = add_box("plank", (0, 0, 0), (4, 1, 0.2))
    box = add_box("box", (1.5, 0, 0.35), (0.5, 0.5, 0.5))
    source = add_empty("shaker", (-1.5 / 4, 0, 0), plank)
    source.haptics.source.enabled = True
    listener = add_empty("skin", (0, 0, 0), box)
    listener.haptics.listener.enabled = True
    listener.haptics.listener.radius = 0.0
    return plank, box, source, listener


def test_gain_of_two_touching_boxes_is_the_closed_form(seesaw, traced):
    for obj in seesaw[:2]:
        obj.haptics.kappa, obj.haptics.rho = 0.25, 0.8
    result = traced()
    distances = math.hypot(3.0, 0.1), 0.25
    expected = math.prod(_gain(0.25, 0.8, d) for d in distances)
    assert result.amplitudes.shape == (1, 1)
    assert result.amplitudes[0, 0] == pytest.approx(expected, rel=1e-6)
    assert result.path_objects(0, 0) == ("plank", "box")


def test_what_creeps_is_where_it_is_to_ten_micrometres_and_in_every_32nd_frame_to_the_bit(
    seesaw, scene
):
    plank, box, _, _ = seesaw
    scene.frame_end = 97
    for obj, path, speed in ((plank, "rotation_euler", 1e-6), (box, "location", 2e-6)):
        begin = np.array(getattr(obj, path))
        for frame in (1, 97):
            setattr(obj, path, begin + speed * (frame - 1))
            obj.keyframe_insert(path, frame=frame)
    corners = np.array(
        [(x, y, z, 1) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    )
    kept = []
    for frame in range(2, 98):
        scene.frame_set(frame)
        reading = session.of(scene).reading
        kept.append(reading.transforms)
        for body, transform in zip((box, plank), reading.transforms, strict=True):
            matrix, sides = np.array(body.matrix_world), np.array([*body.scale, 1])
            away = np.linalg.norm(((transform * sides - matrix) @ corners.T)[:3], axis=0).max()
            assert away <= (1e-6 if frame % 32 == 0 else 3e-5), (body.name, frame)
    assert 10 < len({id(transforms) for transforms in kept}) < 60


def test_amplitude_and_kappa_that_are_keyframed_count_at_each_frame(seesaw, scene):
    plank, _, source, _ = seesaw
    for frame, amplitude, kappa in ((1, 0.2, 0.0), (11, 1.0, 0.5)):
        source.haptics.source.amplitude = amplitude
        source.haptics.source.keyframe_insert("amplitude", frame=frame)
        plank.haptics.kappa = kappa
        plank.haptics.keyframe_insert("kappa", frame=frame)
    for frame in (1, 4, 11):
        scene.frame_set(frame)
        result = session.result_of(scene)
        amplitude, kappa = source.haptics.source.amplitude, plank.haptics.kappa
        expected = (
            amplitude
            * _gain(kappa, plank.haptics.rho, math.hypot(3.0, 0.1))
            * _gain(0.1, 0.9, 0.25)
        )
        assert result.amplitudes[0, 0] == pytest.approx(expected, rel=1e-5)
    assert 0.2 < session.result_of(scene).sources[0].amplitude <= 1.0


def test_settings_of_the_scene_that_are_keyframed_count_at_each_frame(seesaw, scene):
    bpy.ops.rigidbody.world_add()
    later = {"mode": "SD", "strategy": "as_in_the_paper",
             "contact_tolerance": 0.02, "minimum_energy": 0.5, "maximum_energy": 7, "impact_energy": "as_in_the_paper",
             "impacts": False}  # fmt: skip
    keyed = [(scene.haptics, *item) for item in later.items()]
    keyed += [
        (scene.rigidbody_world, "time_scale", 0.5),
        (scene, "gravity", (1, 2, 3)),
        (scene, "use_gravity", False),
    ]
    for owner, name, value in keyed:
        owner.keyframe_insert(name, frame=1)
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=2)
    found = []
    for frame in (1, 2, 1):
        scene.frame_set(frame)
        known, fresh = (
            session.of(scene).reading,
            SceneReader().read(scene, bpy.context.evaluated_depsgraph_get()),
        )
        assert (known.settings, known.contact_settings) == (fresh.settings, fresh.contact_settings)
        found.append(
            {
                item.name: getattr(part, item.name)
                for part in (fresh.settings, fresh.contact_settings)
                for item in fields(part)
            }
        )
    same = {name for name, value in found[0].items() if value == found[1][name]}
    files_only = {"max_connections", "threshold", "epsilon", "slack", "passing"}
    files_only |= {"templates", "refractory"}
    assert same == files_only | {"impact_table", "transmission_table", "textures", "joints"}


def test_drivers_and_strips_of_the_nla_count_at_each_frame(seesaw, scene):
    plank, _, source, _ = seesaw
    driver = plank.haptics.driver_add("kappa").driver
    driver.type = "SCRIPTED"
    driver.expression = "frame / 20"
    for frame, amplitude in ((1, 0.0), (11, 1.0)):
        source.haptics.source.amplitude = amplitude
        source.haptics.source.keyframe_insert("amplitude", frame=frame)
    data = source.animation_data
    action, data.action = data.action, None
    data.nla_tracks.new().strips.new("strip", 1, action)
    felt = []
    for frame in (2, 3, 6, 6, 9):
        scene.frame_set(frame)
        result = session.result_of(scene)
        amplitude, kappa = source.haptics.source.amplitude, frame / 20
        assert plank.haptics.kappa == pytest.approx(kappa)
        expected = (
            amplitude
            * _gain(kappa, plank.haptics.rho, math.hypot(3.0, 0.1))
            * _gain(0.1, 0.9, 0.25)
        )
        assert result.amplitudes[0, 0] == pytest.approx(expected, rel=1e-5)
        felt.append(amplitude)
    assert 0 < felt[0] < felt[1] < felt[2] == felt[3] < felt[4] < 1


def test_moving_the_box_away_breaks_the_path(seesaw, traced):
    assert traced().amplitudes[0, 0] > 0
    seesaw[1].location.z += 1.0
    bpy.context.view_layer.update()
    result = traced()
    assert result.amplitudes[0, 0] == 0
    assert result.path_objects(0, 0) == ()


def test_renamed_deleted_and_duplicated_objects_keep_being_traced(seesaw, traced, scene):
    plank, box, _, _ = seesaw
    before = traced().amplitudes[0, 0]
    plank.name = "zzz board"
    assert traced().path_objects(0, 0) == ("zzz board", "box")
    copy = box.copy()  # linked: shares the mesh
    scene.collection.objects.link(copy)
    copy.location.x -= 1.0
    bpy.context.view_layer.update()
    result = traced()
    assert len(result.objects) == 3
    assert len(result.contacts) == 2
    assert result.amplitudes[0, 0] == pytest.approx(before)
    bpy.data.objects.remove(box)
    bpy.context.view_layer.update()
    result = traced()
    assert box_names(result) == ["box.001", "zzz board"]
    assert "skin" in [
        p.object for p in session.problems_of(scene)
    ]  # its parent is gone: it is on no haptic object


def test_linked_objects_are_traced_beside_local_ones_of_the_same_name(
    seesaw, traced, scene, tmp_path: Path
):
    plank, _, _, _ = seesaw
    before = traced()
    library = tmp_path / "library.blend"
    copy = plank.copy()
    copy.name = plank.name  # Blender numbers it; in the library it is the only one
    bpy.data.libraries.write(str(library), {plank}, fake_user=True)
    bpy.data.objects.remove(copy)
    with bpy.data.libraries.load(str(library), link=True) as (there, here):
        here.objects = [name for name in there.objects if name == plank.name]
    (linked,) = here.objects
    assert linked.name == plank.name and linked.library is not None
    scene.collection.objects.link(linked)
    bpy.context.view_layer.update()
    result = traced()
    assert sorted(result.objects) == sorted((*before.objects, linked.name_full))
    # It lies in the same place as the local one.
    assert result.contacts is not None and len(result.contacts) > len(before.contacts)


def box_names(result):
    return sorted(result.objects)


def test_two_scenes_are_traced_each_by_itself(seesaw, traced, add_box):
    first = bpy.context.scene
    gain = traced().amplitudes[0, 0]
    second = bpy.data.scenes.new("other")
    bpy.context.window.scene = second
    other = add_box("lonely", (0, 0, 0), (1, 1, 1))
    other.haptics.source.enabled = other.haptics.listener.enabled = True
    result = session.trace(second, bpy.context.evaluated_depsgraph_get())
    assert result.objects == ("lonely",)
    assert result.amplitudes[0, 0] == pytest.approx(_gain(0.1, 0.9, 0.0))
    bpy.context.window.scene = first
    assert session.trace(first, bpy.context.evaluated_depsgraph_get()).amplitudes[0, 0] == gain
    assert session.result_of(second).objects == ("lonely",)


def test_nothing_tagged_traces_nothing(traced, add_box):
    add_box("plain", (0, 0, 0), (1, 1, 1), haptic=False)
    assert traced() is None
    assert session.problems_of(bpy.context.scene) == ()


def test_tracing_switched_off_leaves_the_frame_alone(seesaw, scene):
    scene.haptics.tracing = False
    scene.frame_set(7)
    assert session.result_of(scene) is None
    scene.haptics.tracing = True
    scene.frame_set(8)
    assert session.result_of(scene).number == 8


def test_a_dropped_crate_makes_one_impact_of_its_energy(add_box, add_empty, scene):
    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (10, 10, 1), "PASSIVE")
    add_box("crate", (0, 0, 1.25), (0.5, 0.5, 0.5), "ACTIVE", mass=8.0)
    listener = add_empty("skin", (0.1, 0, 0.5), ground)
    listener.haptics.listener.enabled = True
    impacts = []
    for frame in range(1, 40):
        scene.frame_set(frame)
        impacts += session.result_of(scene).impacts
    assert len(impacts) == 1
    assert impacts[0].energy == pytest.approx(8.0 * 9.81 * 1.0, rel=0.15)
    assert impacts[0].time == pytest.approx(math.sqrt(2 * 1.0 / 9.81), abs=0.05)


def test_a_dropped_compound_makes_one_impact_whatever_of_it_is_haptic(add_box, add_empty, scene):
    """Its parts move as one and with its mass: two crates on an empty mesh's place."""
    add_box("floor", (0, 0, -0.5), (10, 10, 1), body="PASSIVE")
    whole = add_box("whole", (0, 0, 3), (0.5, 0.5, 0.5), body="ACTIVE", mass=10)
    for x in (-1, 1):
        part = add_box("part", (x, 0, 3), (1, 1, 1), body="ACTIVE", mass=5)
        part.parent, part.matrix_parent_inverse = whole, whole.matrix_world.inverted()
    whole.rigid_body.collision_shape = "COMPOUND"
    add_empty("hand.L", parent=whole).haptics.listener.enabled = True
    impacts = []
    for frame in range(1, 35):
        scene.frame_set(frame)
        result = session.result_of(scene)
        impacts += [
            (impact.energy, {result.objects[k] for k in impact.objects})
            for impact in result.impacts
        ]
    ((energy, bodies),) = impacts
    assert bodies == {"whole", "floor"}
    assert energy == pytest.approx(10 * 9.81 * 2.5, rel=0.05)


def test_the_command_line_finds_the_same_gains_in_the_export(
    seesaw, traced, tmp_path: Path, capsys
):
    result = traced()
    path = tmp_path / "scene.json"
    bpy.ops.export_scene.haptic_scene(filepath=str(path))
    capsys.readouterr()
    assert main(["propagate", str(path)]) == 0
    pairs = json.loads(capsys.readouterr().out)["gains"]
    assert [(p["source"], p["listener"]) for p in pairs] == [("shaker", "skin")]
    assert pairs[0]["gain"] == pytest.approx(result.amplitudes[0, 0], rel=1e-12)
    assert pairs[0]["path"] == ["plank", "box"]


def test_the_same_timeline_played_twice_gives_the_same_bits(add_box, add_empty, scene):
    from haptic_tracing.command_line.playing import play

    bpy.ops.rigidbody.world_add()
    ground = add_box("ground", (0, 0, -0.5), (10, 10, 1), "PASSIVE")
    add_box("crate", (0, 0, 1.0), (0.5, 0.5, 0.5), "ACTIVE", mass=8.0)
    ground.haptics.source.enabled = True
    listener = add_empty("skin", (0.1, 0, 0.5), ground)
    listener.haptics.listener.enabled = True
    first = play(scene, 1, 30)
    second = play(scene, 1, 30)
    assert first.samples.shape == (1, 30 * 8000 // 24)  # both ends count
    assert first.samples.tobytes() == second.samples.tobytes()
    assert len(first.impacts) == 1
    assert scene.frame_current == 1
