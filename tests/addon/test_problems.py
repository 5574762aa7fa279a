"""Bad input in a Blender scene: a message that names the object and the cure, and the rest of the
scene goes on."""

import os

import bpy
import pytest
from haptic_tracing.addon.session import session


def _problems():
    return {problem.object: problem.message for problem in session.problems_of(bpy.context.scene)}


@pytest.fixture
def sound(add_box):
    """A box that is source and listener: what goes on whatever else is wrong."""
    box = add_box("sound", (0, 0, 10), (1, 1, 1))
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    return box


def _goes_on(result):
    assert result is not None
    assert result.amplitudes.shape == (1, 1)
    assert result.amplitudes[0, 0] > 0


def test_an_empty_as_source_on_nothing(sound, add_empty, traced):
    add_empty("ghost").haptics.source.enabled = True
    _goes_on(traced())
    assert "parent it to one" in _problems()["ghost"]


def test_a_listener_on_nothing(sound, add_empty, traced):
    add_empty("ghost").haptics.listener.enabled = True
    _goes_on(traced())
    assert "listener is on no haptic object" in _problems()["ghost"]


def test_a_mesh_without_faces(sound, traced):
    mesh = bpy.data.meshes.new("dust")
    obj = bpy.data.objects.new("dust", mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.haptics.enabled = True
    bpy.context.view_layer.update()
    _goes_on(traced())
    assert "no vertices" in _problems()["dust"]


@pytest.mark.parametrize("scale", [(0, 0, 0), (1, 0, 1)])
def test_a_scale_of_zero(sound, add_box, traced, scale):
    add_box("flat", (0, 0, 0), scale)
    bpy.context.view_layer.update()
    _goes_on(traced())
    assert "scale is 0" in _problems()["flat"]


def test_a_mirrored_object_touches_where_it_stands(add_box, traced):
    left, right = add_box("left", (0, 0, 0), (1, 1, 1)), add_box("right", (1, 0, 0), (-1, 1, 1))
    left.haptics.source.enabled = right.haptics.listener.enabled = True
    bpy.context.view_layer.update()
    assert traced().amplitudes[0, 0] > 0
    assert _problems() == {}


def test_a_vertex_that_is_not_a_number(sound, add_box, traced):
    bad = add_box("bad", (0, 0, 0), (1, 1, 1))
    bad.data.vertices[0].co.x = float("nan")
    bad.data.update()
    bpy.context.view_layer.update()
    _goes_on(traced())
    assert "bad" in _problems()


@pytest.mark.parametrize(
    ("formula", "reason"),
    [
        ("exp(", "not a formula"),
        ("open('x')", "'open'"),
        ("x * x", "proportional"),
        ("", "not a formula"),
    ],
)
def test_an_expression_that_is_no_formula(sound, add_box, traced, formula, reason):
    bad = add_box("bad", (0, 0, 0), (1, 1, 1))
    bad.haptics.function, bad.haptics.expression = "expression", formula
    _goes_on(traced())
    assert reason in _problems()["bad"]


def test_an_expression_without_a_finite_gain_names_its_object(add_box, traced):
    bad = add_box("bad", (0, 0, 0), (1, 1, 1))
    bad.haptics.source.enabled = bad.haptics.listener.enabled = True
    bad.haptics.function, bad.haptics.expression = "expression", "x / d"
    result = traced()
    assert result is None or (result.amplitudes == 0).all()
    assert any(
        "bad" in problem.object + problem.message
        for problem in session.problems_of(bpy.context.scene)
    )


def test_a_camera_has_no_surface(sound, traced):
    camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    bpy.context.scene.collection.objects.link(camera)
    camera.haptics.enabled = True
    bpy.context.view_layer.update()
    _goes_on(traced())
    assert "no surface" in _problems()["eye"]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (lambda: bpy.data.armatures.new("x"), "its type, Armature, has no surface"),
        (lambda: bpy.data.lightprobes.new("x", "SPHERE"), "its type, Light Probe, has no"),
        (lambda: None, "its type, Empty, has no surface"),
    ],
)
def test_a_type_without_a_surface_has_its_name_in_blender(sound, traced, data, words):
    thing = bpy.data.objects.new("thing", data())
    bpy.context.scene.collection.objects.link(thing)
    thing.haptics.enabled = True
    _goes_on(traced())
    assert words in _problems()["thing"]


def test_a_rigid_body_without_a_world_is_traced_where_it_stands(add_box, traced):
    box = add_box("box", (0, 0, 0), (1, 1, 1), "ACTIVE")
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    # Else it stops being a rigid body.
    bpy.context.scene.rigidbody_world.collection.objects.unlink(box)
    bpy.ops.rigidbody.world_remove()
    assert box.rigid_body is not None
    assert bpy.context.scene.rigidbody_world is None
    _goes_on(traced())
    assert _problems() == {}


def test_a_missing_recording(sound, traced):
    sound.haptics.source.signal = "FILE"
    traced()
    assert "none is chosen" in _problems()["sound"]
    sound.haptics.source.filepath = "/nowhere/at/all.wav"
    traced()
    assert "all.wav" in _problems()["sound"]


REMOTE = ("\\\\server\\share\\a.wav", "https://example.org/a.wav")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no named pipes among its files")
def test_a_recording_that_is_a_pipe_keeps_nobody_waiting(sound, traced, tmp_path):
    os.mkfifo(tmp_path / "pipe.wav")
    sound.haptics.source.signal = "FILE"
    sound.haptics.source.filepath = str(tmp_path / "pipe.wav")
    traced()
    assert "pipe.wav is not a file" in _problems()["sound"]


@pytest.mark.parametrize("path", REMOTE)
def test_a_recording_on_another_computer_needs_online_access(sound, traced, path):
    """Blender as a module has none; a name of the network could take minutes to be looked up."""
    assert not bpy.app.online_access
    sound.haptics.source.signal = "FILE"
    sound.haptics.source.filepath = path
    traced()
    assert "is on another computer: allow online access" in _problems()["sound"]
    sound.haptics.source.signal = "SOUND"
    sound.haptics.source.sound.filepath = path
    assert "is on another computer" in sound.haptics.source.sound.fault


def test_an_exporter_with_nothing_to_export_says_so(tmp_path):
    with pytest.raises(RuntimeError, match="Nothing is tagged"):
        bpy.ops.export_scene.haptic_scene(filepath=str(tmp_path / "empty.json"))
    assert not (tmp_path / "empty.json").exists()


@pytest.mark.parametrize("body", [None, "BOX", "SPHERE", "CONVEX_HULL", "MESH"])
def test_an_object_without_bounds_stops_only_itself_and_is_named(
    add_box, add_empty, traced, scene, body
):
    first, second = (
        add_box(name, (x, 0, 0), (1, 1, 1)) for name, x in (("first", 0), ("second", 1))
    )
    huge = add_box("huge", (0.5, 0, 0), (1, 1, 1), None if body is None else "PASSIVE")
    if body is not None:
        huge.rigid_body.collision_shape = body
    add_empty("shaker", (0, 0, 0), first).haptics.source.enabled = True
    add_empty("skin", (0, 0, 0), second).haptics.listener.enabled = True
    huge.haptics.enabled = False
    before = traced().amplitudes
    huge.haptics.enabled = True
    for scale, corner in ((1e30, 1.0), (1.0, 1e30)):
        huge.scale, huge.data.vertices[7].co.x = (scale, scale, scale), corner
        huge.data.update()
        bpy.context.view_layer.update()
        result = traced()
        assert result.amplitudes == pytest.approx(before)
        assert result.objects == ("first", "second")
        assert [
            (item.object, "10,000 km" in item.message) for item in session.problems_of(scene)
        ] == [("huge", True)]


def test_listeners_of_an_armature_without_a_body_are_one_problem(sound, scene, add_empty, traced):
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    scene.collection.objects.link(rig)
    for number in range(10):
        add_empty(f"place {number}", (0, 0, number), rig).haptics.listener.enabled = True
    _goes_on(traced())
    (problem,) = session.problems_of(scene)
    assert problem.object == "rig" and "choose its Body" in problem.message


def test_an_armature_whose_body_was_deleted_is_named(sound, scene, add_box, traced):
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    scene.collection.objects.link(rig)
    body = rig.haptics.body = add_box("body", (3, 0, 0), (1, 1, 1))
    rig.haptics.listener.enabled = True
    bpy.context.view_layer.update()
    assert "rig" in [listener.name for listener in traced().listeners]
    body.hide_viewport = True
    bpy.context.view_layer.update()
    traced()
    assert session.problems_of(scene) == ()  # meant to be away
    with bpy.context.temp_override(selected_objects=[body]):
        bpy.ops.object.delete()
    assert rig.haptics.body == body
    bpy.context.view_layer.update()
    _goes_on(traced())
    (problem,) = session.problems_of(scene)
    assert problem.object == "rig" and "choose its Body" in problem.message


@pytest.mark.parametrize("role", ["source", "listener"])
def test_sources_and_listeners_of_a_collection_instance_are_named(
    scene, add_box, add_empty, traced, role
):
    """As an asset is that was dropped as an instance."""
    collection, box = bpy.data.collections.new("rig"), add_box("drum", (0, 0, 0), (1, 1, 1))
    scene.collection.objects.unlink(box)
    collection.objects.link(box)
    box.haptics.surface = "SEEN"
    rig = add_empty("rig here")
    rig.instance_type, rig.instance_collection = "COLLECTION", collection
    assert traced() is not None
    assert session.problems_of(scene) == ()
    getattr(box.haptics, role).enabled = True
    traced()
    (problem,) = session.problems_of(scene)
    assert problem.object == "rig here" and "sources and listeners" in problem.message
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    assert bpy.ops.object.duplicates_make_real() == {"FINISHED"}
    (made,) = [obj for obj in scene.objects if obj.type == "MESH"]
    assert getattr(made.haptics, role).enabled
    traced()
    assert session.problems_of(scene) == ()
