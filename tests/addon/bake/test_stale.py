"""A track says that the scene has changed since, and what."""

import wave
from pathlib import Path

import bpy
import numpy as np
import pytest
from haptic_tracing.addon.bake import playback
from haptic_tracing.addon.blender import compatibility
from haptic_tracing.addon.scene_reader.digest import changes, digest_of


def _reasons(scene):
    bpy.context.view_layer.update()
    return playback.stale_reasons(scene)


@pytest.fixture
def baked(shaken):
    bpy.ops.haptic.bake()
    return shaken


def test_a_fresh_bake_is_not_stale_in_any_frame(baked):
    for frame in (1, 5, 13, 24):
        baked.frame_set(frame)
        assert _reasons(baked) == ()


def _move(scene):
    bpy.data.objects["ground"].location.x += 1


def _kappa(scene):
    bpy.data.objects["crate"].haptics.kappa = 0.4


def _mute(scene):
    bpy.data.objects["shaker"].haptics.source.muted = True


def _key(scene):
    crate = bpy.data.objects["crate"]
    crate.location.z = 3.0
    crate.keyframe_insert("location", frame=14)


def _mesh(scene):
    bpy.data.objects["crate"].data.vertices[0].co.x -= 0.1


def _parent(scene):
    bpy.data.objects["foot"].parent = None


def _add(scene):
    obj = bpy.data.objects["crate"].copy()
    obj.name = "other"
    scene.collection.objects.link(obj)


def _remove(scene):
    bpy.data.objects.remove(bpy.data.objects["hand"])


def _least_energy(scene):
    scene.haptics.minimum_energy = 0.01


def _rate(scene):
    scene.render.fps = 30


def _gravity(scene):
    scene.gravity.z = -1.6


def _range(scene):
    scene.frame_end = 99


def _start(scene):
    scene.frame_start = 2


def _rule(scene):
    scene.haptics.impact_table.items.add()


def _rule_changed(scene):
    scene.haptics.transmission_table.items[0].function = "resilient"


def _easing(scene):
    animation = bpy.data.objects["crate"]
    for point in compatibility.fcurves_of(animation)[0].keyframe_points:
        point.interpolation = "CONSTANT"


def _driver(scene):
    variable = bpy.data.objects["driven"].animation_data.drivers[0].driver.variables[0]
    variable.targets[0].data_path = "location.y"


def _delta(scene):
    bpy.data.objects["crate"].delta_location.x = 0.1


def _influence(scene):
    bpy.data.objects["driven"].constraints[0].influence = 0.5


def _target(scene):
    bpy.data.objects["target"].location.x = 3


def _modifier(scene):
    bpy.data.objects["driven"].modifiers[0].count = 3


def _exclude(scene):
    bpy.context.view_layer.layer_collection.children[0].exclude = True


def _drawn(scene):
    node = bpy.data.objects["shaker"].haptics.source.drawing.nodes["Amplitude"]
    node.mapping.curves[0].points[0].location = (0, 0.1)


def _emphasis(scene):
    bpy.data.objects["shaker"].haptics.source.drawing.haptics.emphases.add()


def _recording(scene):
    path = Path(bpy.data.objects["recorder"].haptics.source.filepath)
    write_wav(path, np.full(800, 0.5))


def _settings_keyed(scene):
    scene.haptics.keyframe_insert("minimum_energy", frame=3)


def write_wav(path, samples):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8000)
        file.writeframes((samples * 32767).astype("<i2").tobytes())


@pytest.fixture
def baked_from_much(shaken, add_box, add_empty, tmp_path):
    """The same, with more that a bake depends on: a rule, a drawn signal, a recording, a driver, a
    constraint, a modifier, a collection."""
    add_empty("target", (0, 0, 5), None)
    driven = add_box("driven", (0, 0, 3), (0.2, 0.2, 0.2))
    driven.modifiers.new("Array", "ARRAY")
    driven.constraints.new("COPY_LOCATION").target = bpy.data.objects["target"]
    driver = driven.driver_add("scale", 0).driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = bpy.data.objects["target"], "location.x"
    driver.expression = f"1 + {variable.name}"
    shaken.haptics.transmission_table.items.add()
    recorder = add_empty("recorder", (0.1, 0, 0), bpy.data.objects["ground"]).haptics.source
    recorder.enabled, recorder.signal, recorder.filepath = True, "FILE", str(tmp_path / "a.wav")
    write_wav(tmp_path / "a.wav", np.full(800, 0.25))
    collection = bpy.data.collections.new("shelf")
    shaken.collection.children.link(collection)
    hidden = add_box("hidden", (0, 0, 9), (1, 1, 1))
    shaken.collection.objects.unlink(hidden)
    collection.objects.link(hidden)
    shaker = bpy.data.objects["shaker"]
    bpy.context.view_layer.objects.active = shaker
    bpy.ops.haptic.draw_signal()
    bpy.ops.haptic.bake()
    return shaken


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_start, "the scene's first frame changed"),
        (_rule, "rules of contacts, impacts or textures, or the animation of settings changed"),
        (
            _rule_changed,
            "rules of contacts, impacts or textures, or the animation of settings changed",
        ),
        (
            _settings_keyed,
            "rules of contacts, impacts or textures, or the animation of settings changed",
        ),
        (_easing, "'crate': its animation changed"),
        (_driver, "'driven': its animation changed"),
        (_delta, "'crate': it was moved, turned or scaled"),
        (_influence, "'driven': its parent, constraints or modifiers changed"),
        (_modifier, "'driven': its parent, constraints or modifiers changed"),
        (_target, "'target': it was moved, turned or scaled"),
        (_exclude, "'hidden' was removed"),
        (_drawn, "'shaker': its haptic settings changed"),
        (_emphasis, "'shaker': its haptic settings changed"),
        (_recording, "'recorder': its haptic settings changed"),
    ],
)
def test_what_a_bake_depends_on_is_named(baked_from_much, change, words):
    for frame in (3, 14):
        baked_from_much.frame_set(frame)
        assert _reasons(baked_from_much) == ()
    change(baked_from_much)
    assert words in _reasons(baked_from_much)


@pytest.fixture
def baked_with_deformers(shaken, add_empty):
    """A bake of a cloth with a shape key, a lattice and a path of the crate, a hinge and a wind."""
    crate, ground = bpy.data.objects["crate"], bpy.data.objects["ground"]
    cage = bpy.data.objects.new("cage", bpy.data.lattices.new("cage"))
    way = bpy.data.objects.new("way", bpy.data.curves.new("way", "CURVE"))
    way.data.splines.new("POLY").points.add(3)
    for obj in (cage, way):
        shaken.collection.objects.link(obj)
    crate.modifiers.new("cage", "LATTICE").object = cage
    crate.constraints.new("FOLLOW_PATH").target = way
    ground.modifiers.new("cloth", "CLOTH")
    ground.shape_key_add(name="Basis")
    ground.shape_key_add(name="Bent")
    bpy.ops.object.effector_add(type="WIND")
    bpy.context.object.name = "wind"
    bpy.context.view_layer.objects.active = add_empty("hinge", (0, 0, 0), None)
    bpy.ops.rigidbody.world_add()
    bpy.ops.rigidbody.constraint_add(type="HINGE")
    bpy.ops.haptic.bake()
    return shaken


def _cage(scene):
    bpy.data.objects["cage"].data.points[0].co_deform.x += 0.1


def _way(scene):
    bpy.data.objects["way"].data.splines[0].points[1].co = (1, 0, 0, 1)


def _bent(scene):
    bpy.data.objects["ground"].data.shape_keys.key_blocks["Bent"].data[0].co.z += 0.1


def _stiffness(scene):
    bpy.data.objects["ground"].modifiers["cloth"].settings.tension_stiffness = 40


def _distance(scene):
    bpy.data.objects["ground"].modifiers["cloth"].collision_settings.distance_min = 0.03


def _wind(scene):
    bpy.data.objects["wind"].field.strength = 8


def _hinge(scene):
    bpy.data.objects["hinge"].rigid_body_constraint.use_limit_ang_z = True


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_cage, "'cage': what deforms it changed"),
        (_way, "'way': what deforms it changed"),
        (_bent, "'ground': what deforms it changed"),
        (_stiffness, "'ground': what deforms it changed"),
        (_distance, "'ground': what deforms it changed"),
        (_wind, "rigid body constraints or force fields changed"),
        (_hinge, "rigid body constraints or force fields changed"),
    ],
)
def test_what_deforms_and_drives_is_named(baked_with_deformers, change, words):
    for frame in (1, 3, 14):
        baked_with_deformers.frame_set(frame)
        assert _reasons(baked_with_deformers) == ()
    change(baked_with_deformers)
    assert words in _reasons(baked_with_deformers)


def test_animated_settings_are_not_changes(shaken):
    for frame, value in ((1, 0.001), (20, 0.1)):
        shaken.haptics.minimum_energy = value
        shaken.haptics.keyframe_insert("minimum_energy", frame=frame)
    bpy.ops.haptic.bake()
    for frame in (1, 9, 20):
        shaken.frame_set(frame)
        assert _reasons(shaken) == ()


def test_other_gains_are_noticed_whatever_their_cause(baked, settle):
    """A node group in a modifier, whose nodes are not compared, takes the crate's mesh away."""
    group = bpy.data.node_groups.new("Away", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    away = group.nodes.new("GeometryNodeTransform")
    group.links.new(start.outputs[0], away.inputs["Geometry"])
    group.links.new(away.outputs[0], end.inputs[0])
    bpy.data.objects["crate"].modifiers.new("Away", "NODES").node_group = group
    bpy.ops.haptic.bake()
    baked.frame_set(9)
    assert playback.stale_reasons(baked) == ()
    assert settle(lambda: playback.known_stale_reasons(baked)) == ()
    assert playback.fitting_track(baked, 1, 24) is not None
    away.inputs["Translation"].default_value = (0, 0, 5)
    bpy.context.view_layer.update()
    assert playback.stale_reasons(baked) == ()  # nothing in the datablocks that are compared
    assert settle(lambda: playback.known_stale_reasons(baked)) == (
        "in frame 9 other gains are traced than were baked",
    )
    assert playback.fitting_track(baked, 1, 24) is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (_move, "'ground': it was moved, turned or scaled"),
        (_kappa, "'crate': its haptic settings changed"),
        (_mute, "'shaker': its haptic settings changed"),
        (_key, "'crate': its animation changed"),
        (_mesh, "'crate': its shape changed"),
        (_parent, "'foot': its parent, constraints or modifiers changed"),
        (_add, "'other' was added"),
        (_remove, "'hand' was removed"),
        (_least_energy, "minimum energy was 0.0, is 0.01"),
        (_rate, "the frame rate changed"),
        (_gravity, "gravity changed"),
        (_range, "frames 1 to 99 are played, 1 to 24 were baked"),
    ],
)
def test_every_change_is_named(baked, change, words):
    change(baked)
    assert _reasons(baked) == (words,)
    bpy.ops.haptic.bake()
    assert _reasons(baked) == ()


def test_selecting_cameras_and_colours_changes_nothing(baked):
    bpy.data.objects["crate"].select_set(True)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    baked.collection.objects.link(camera)
    bpy.data.objects["crate"].color = (1, 0, 0, 1)
    baked.haptics.show_labels = not baked.haptics.show_labels
    assert _reasons(baked) == ()


def test_many_changes_are_a_short_list(baked):
    for number in range(20):
        obj = bpy.data.objects["crate"].copy()
        obj.name = f"copy {number}"
        baked.collection.objects.link(obj)
    reasons = _reasons(baked)
    assert len(reasons) == 7
    assert reasons[-1] == "and 14 more"


def test_a_strange_digest_is_stale_not_an_error(baked):
    for strange in ({}, {"objects": 3, "settings": []}, {"objects": {"crate": None}}):
        assert changes(strange, digest_of(baked))


def test_a_draw_compares_nothing_but_has_it_done_after_the_redraw(baked, monkeypatch):
    bpy.context.view_layer.update()
    compare = playback.compare
    monkeypatch.setattr(
        playback, "compare", lambda *_: pytest.fail("a draw compares the scene with its track")
    )
    assert playback.known_stale_reasons(baked) is None
    assert bpy.app.timers.is_registered(playback._compare_shown)
    monkeypatch.setattr(playback, "compare", compare)
    playback._compare_shown()
    assert playback.known_stale_reasons(baked) == ()
    _kappa(baked)
    assert playback.known_stale_reasons(baked) == (), (
        "what was known, until the comparison is made again"
    )
    playback._compare_shown()
    assert playback.known_stale_reasons(baked) == ("'crate': its haptic settings changed",)
