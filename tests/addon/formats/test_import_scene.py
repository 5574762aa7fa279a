"""Haptic scenes into Blender and out again: the same bytes, the same gains."""

import json

import bpy
import numpy as np
import pytest
from haptic_tracing.core.contacts.shapes import (
    Box,
    Capsule,
    Compound,
    Cone,
    ConvexHull,
    Cylinder,
    Mesh,
    Sphere,
)
from haptic_tracing.core.formats.export import Export
from haptic_tracing.core.formats.haptic_scene import read_export, write_export
from haptic_tracing.core.formats.scene.recording import traced as traced_again
from haptic_tracing.core.formats.scene.scene_json import read_scene
from haptic_tracing.core.graph.haptic_graph import build_graph
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import function_from_dict
from haptic_tracing.core.scene.values import (
    Contact,
    HapticObject,
    HapticScene,
    Listener,
    Pose,
    Settings,
    Source,
    SourceKind,
)
from haptic_tracing.core.signals import Adsr, Decay, Gain, Loop, Noise, Pulse, Sampled, Sine
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scene_files import exported

FEW = settings(
    max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)


def empty_file():
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    for collection in list(bpy.data.collections):
        bpy.data.collections.remove(collection)
    for mesh in list(bpy.data.meshes):
        bpy.data.meshes.remove(mesh)
    bpy.context.scene.haptics.imported = bpy.context.scene.haptics.imported_contacts = ""


def imported(path):
    empty_file()
    assert bpy.ops.import_scene.haptic_scene(filepath=str(path)) == {"FINISHED"}


def gains_of(scene):
    """By the core alone, from what the file says."""
    from haptic_tracing.core.contacts.contact_set import ContactSet
    from haptic_tracing.core.graph.haptic_graph import ObjectTable

    table = ObjectTable.of(scene.objects, scene.settings.epsilon)
    contacts = ContactSet.from_contacts(scene.contacts, table.index())
    graph = build_graph(table, contacts, scene.sources, scene.listeners)
    gains = propagate(graph, scene.settings).gain * np.array(
        [source.amplitude for source in scene.sources]
    ).reshape(-1, 1)
    return {
        (source.name, listener.name): gains[s, i]
        for s, source in enumerate(scene.sources)
        for i, listener in enumerate(scene.listeners)
    }


def gains_in_blender(traced):
    result = traced()
    return {
        (source.name, listener.name): source.amplitude * result.propagation.gain[s, i]
        for s, source in enumerate(result.sources)
        for i, listener in enumerate(result.listeners)
    }


@pytest.fixture
def workshop(add_box, add_empty):
    """Bodies of every kind, turned, scaled, parented; sources and listeners on them."""
    scene = bpy.context.scene
    floor = add_box("floor", (0, 0, -0.5), (12, 12, 1), body="PASSIVE")
    floor.haptics.source.enabled = True
    floor.haptics.source.signal, floor.haptics.source.frequency = "PULSE", 23.4
    kinds = ("BOX", "SPHERE", "CAPSULE", "CYLINDER", "CONE", "CONVEX_HULL", "MESH")
    for number, kind in enumerate(kinds):
        thing = add_box(
            kind.title(),
            (number - 3.3, 0.7, 0.3),
            (0.61, 0.61, 0.6),
            body="ACTIVE",
            mass=1.7 + number,
        )
        thing.rigid_body.collision_shape = kind
        thing.rotation_euler = (0, 0, 0.37 * number)
        thing.haptics.kappa = 0.05 * number
    plank = add_box("plank", (-1.2, 0.71, 0.63), (6.3, 0.31, 0.07))
    plank.rotation_euler = (0.01, 0.002, 0.03)
    plank.haptics.function, plank.haptics.alpha = "exponential", 0.31
    plank.haptics.wave_speed = 1234.5
    plank.haptics.listener.enabled = True
    plank.haptics.listener.mixing = "power"
    plank.haptics.material.name = "old oak"
    plank.haptics.material.use_bands, plank.haptics.material.band_decays = (
        True,
        (0, 0.01, 0.02, 0.05, 0.1, 0.2),
    )
    hand = add_empty("hand", (0.11, 0.02, 0.49), parent=plank)
    hand.haptics.listener.enabled = True
    hand.haptics.listener.body_part, hand.haptics.listener.gain = "hand.R", 0.7
    drill = add_empty("drill", (0.3, 0.1, 0.5), parent=plank)
    drill.haptics.source.enabled = True
    drill.haptics.source.amplitude, drill.haptics.source.priority = 0.3, 2.5
    scene.haptics.strategy, scene.haptics.epsilon, scene.haptics.contact_tolerance = (
        "all_paths",
        0.07,
        0.02,
    )
    bpy.context.view_layer.update()
    return scene


def test_export_import_export_gives_the_same_bytes(workshop, traced, tmp_path):
    before = gains_in_blender(traced)
    first = exported(tmp_path / "a.json")
    scene = read_scene(tmp_path / "a.json")
    assert {type(item.shape).type for item in scene.objects} == {
        "box", "sphere", "capsule", "cylinder", "cone", "convex_hull", "mesh"
    }  # fmt: skip
    assert scene.contacts
    by_core = gains_of(scene)
    imported(tmp_path / "a.json")
    assert bpy.context.scene.haptics.materials.items["old oak"].kappa == pytest.approx(0.1)
    assert exported(tmp_path / "b.json") == first
    after = gains_in_blender(traced)
    assert before.keys() == by_core.keys() == after.keys()
    for pair, gain in before.items():
        assert by_core[pair] == pytest.approx(gain, rel=1e-12), pair
        assert after[pair] == pytest.approx(gain, rel=1e-5, abs=1e-9), pair
    assert max(before.values()) > 0.1


def test_it_survives_saving_and_loading(workshop, tmp_path):
    first = exported(tmp_path / "a.json")
    imported(tmp_path / "a.json")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert exported(tmp_path / "b.json") == first


def test_what_is_moved_or_scaled_afterwards_counts(workshop, tmp_path):
    exported(tmp_path / "a.json")
    imported(tmp_path / "a.json")
    box, cone = bpy.data.objects["Box"], bpy.data.objects["Cone"]
    box.location.x += 0.5
    cone.scale = (2, 2, 2)
    moved = json.loads(exported(tmp_path / "b.json"))
    was = {item["name"]: item for item in json.loads((tmp_path / "a.json").read_bytes())["objects"]}
    now = {item["name"]: item for item in moved["objects"]}
    assert now["Box"]["pose"]["position"][0] == pytest.approx(
        was["Box"]["pose"]["position"][0] + 0.5, abs=1e-6
    )
    assert now["Cone"]["shape"]["type"] == "convex_hull" and now["Capsule"] == was["Capsule"]


@pytest.mark.slow
def test_a_frame_of_the_demo_with_its_impacts(tmp_path, traced):
    """The study's scene in the midst of its crates' impacts."""
    from haptic_tracing.sample_scenes import jackhammer_bench

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    jackhammer_bench.build(bpy.context.scene)
    scene = bpy.context.scene
    for frame in range(scene.frame_start, scene.frame_start + 60):
        scene.frame_set(frame)
        from haptic_tracing.addon.session import session

        result = session.result_of(scene)
        if any(source.kind is SourceKind.TEMPORARY for source in result.sources):
            break
    before = {
        (source.name, listener.name): result.amplitudes[s, i]
        for s, source in enumerate(result.sources)
        for i, listener in enumerate(result.listeners)
    }
    first = exported(tmp_path / "a.json")
    written = read_scene(tmp_path / "a.json")
    assert any(
        source.kind is SourceKind.TEMPORARY and source.second_object for source in written.sources
    )
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    imported(tmp_path / "a.json")
    assert bpy.context.scene.frame_current == 1 != frame
    bpy.context.scene.frame_set(frame)
    assert exported(tmp_path / "b.json") == first
    by_core, after = gains_of(written), gains_in_blender(traced)
    assert before.keys() == by_core.keys() == after.keys()
    for pair, gain in before.items():
        assert by_core[pair] == pytest.approx(gain, rel=1e-12), pair
        # Poses in single precision may move the centre of a patch that is hardly more than a point
        # by a millimetre.
        assert after[pair] == pytest.approx(by_core[pair], rel=1e-3), pair


numbers = st.floats(0, 1, allow_nan=False).map(lambda v: round(v, 4))
lengths = st.floats(0.05, 2).map(lambda v: round(v, 3))
places = st.tuples(*[st.floats(-20, 20)] * 3)
rotations = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: sum(v * v for v in q) > 0.01)
poses = st.builds(Pose, places, rotations)
shapes = st.one_of(
    st.builds(
        lambda x, y, z, r: Box((x, y, z), rounding=r),
        lengths,
        lengths,
        lengths,
        st.sampled_from([0.0, 0.01]),
    ),
    st.builds(Sphere, lengths, st.sampled_from([0.0, 0.02])),
    st.builds(Capsule, lengths, lengths),
    st.builds(Cylinder, lengths, lengths),
    st.builds(Cone, lengths, lengths),
    st.just(ConvexHull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.1, 0.1, 0.1]])),
    st.just(Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2], [0, 1, 3]])),
    st.just(Compound.of(((Sphere(0.5), Pose((1, 0, 0))), (Box((1, 1, 1)), Pose())))),
)
functions = st.sampled_from(
    [
        {"function": "haptic_tracing"},
        {"function": "exponential", "alpha": 0.123},
        {"function": "linear", "range": 7.5},
        {"function": "constant", "gain": 0.3},
        {"function": "identity", "wave_speed": 340.0},
        {"function": "expression", "expression": "x * exp(-kappa * d)"},
    ]
).map(function_from_dict)
signals = st.sampled_from(
    [
        None, Sine(60.0), Sine(123.456789), Pulse(25.0), Pulse(20.0, phase=0.25), Noise(), Noise(0.5, seed=3),
        Loop(Sampled([0.1, -0.3, 0.2])), Gain(Sine(200.0) * Decay(0.3), 0.5), Sine(80.0) * Adsr(),
    ]
)  # fmt: skip
names = (
    st.text(st.characters(exclude_categories=["C"]), min_size=1, max_size=12)
    .map(str.strip)
    .filter(bool)
)


@st.composite
def scenes(draw):
    """Scenes as other tools may write them."""
    called = draw(st.lists(names, min_size=1, max_size=6, unique=True))
    extras = st.dictionaries(
        names, st.sampled_from([1, "two", [3.5, None], {"four": True}]), max_size=2
    )
    objects = tuple(
        HapticObject(
            name, draw(numbers), draw(numbers), draw(functions), draw(st.one_of(shapes, st.none())), draw(st.one_of(poses, st.none())),
            draw(st.sampled_from([None, 2.5])), draw(st.booleans()), draw(extras),
        )
        for name in called
    )  # fmt: skip
    sources = tuple(
        Source(
            name, draw(st.sampled_from(called)), draw(places), draw(numbers), draw(st.sampled_from(SourceKind)), draw(signals),
            onset=draw(st.sampled_from([0.0, 1.25])), extras=draw(extras),
        )
        for name in draw(st.lists(names, max_size=3, unique=True))
    )  # fmt: skip
    listeners = tuple(
        Listener(
            name, draw(st.sampled_from(called)), draw(places), draw(st.sampled_from(["", "hand.L", "tail"])), radius=draw(lengths),
            gain=draw(numbers), mixing=draw(st.sampled_from(["cumulative", "weighted", "strongest", "power"])),
            s_max=draw(st.sampled_from([1.0, 0.5])), extras=draw(extras),
        )
        for name in draw(st.lists(names, max_size=3, unique=True))
    )  # fmt: skip
    contacts = tuple(
        Contact((called[k], called[k + 1]), ((k, 0, 0), (k, 0, 0))) for k in range(len(called) - 1)
    )
    wanted = Settings(
        mode=draw(st.sampled_from(["HT", "MD"])),
        threshold=draw(numbers),
        max_connections=draw(st.sampled_from([None, 7])),
    )
    return HapticScene(objects, contacts, sources, listeners, wanted, draw(extras))


@pytest.mark.slow
@FEW
@given(scene=scenes())
def test_generated_scenes_come_back_the_same(tmp_path_factory, scene):
    folder = tmp_path_factory.mktemp("generated")
    write_export(Export("given", scene), folder / "given.json")
    imported(folder / "given.json")
    first = exported(folder / "a.json")
    imported(folder / "a.json")
    assert exported(folder / "b.json") == first
    taken = {item.name: item for item in read_scene(folder / "a.json").objects}
    for item in scene.objects:
        if item.name in taken and item.shape is not None:
            other = taken[item.name]
            assert (other.shape, other.mass, other.medium, other.extras) == (
                item.shape,
                item.mass,
                item.medium,
                item.extras,
            )
            assert other.pose == (item.pose or Pose()) and other.kappa == pytest.approx(
                item.kappa, abs=1e-7
            )


def test_signals_come_back_as_they_were(tmp_path, traced):
    """The properties where they can make the signal, else the signal itself, kept with the file."""
    kinds = {
        "a": (Sine(60.0), "SINE"), "b": (Pulse(25.0), "PULSE"), "c": (Noise(), "NOISE"), "d": (Sine(123.456789), "KEPT"),
        "e": (Loop(Sampled([0.1, -0.3, 0.2])), "KEPT"), "f": (Gain(Sine(200.0) * Decay(0.3), 0.5), "KEPT"),
    }  # fmt: skip
    sources = tuple(
        Source(name, "box", (0, 0, 0.4), signal=signal) for name, (signal, _) in kinds.items()
    )
    write_export(
        Export(
            "s", HapticScene((HapticObject("box", 0.1, 0.9, shape=Box((1, 1, 1))),), (), sources)
        ),
        tmp_path / "s.json",
    )
    imported(tmp_path / "s.json")
    for source in traced().sources:
        signal, kind = kinds[source.name]
        assert (
            source.signal == signal and bpy.data.objects[source.name].haptics.source.signal == kind
        )


@pytest.mark.slow
def test_frames_become_keyframes(workshop, tmp_path, traced):
    """A range, imported, moves as it did: what is traced in Blender is what the core traces from
    the file."""
    plank, floor = bpy.data.objects["plank"], bpy.data.objects["floor"]
    for obj in workshop.objects:
        if obj.rigid_body is not None:
            obj.rigid_body.kinematic = True
    workshop.render.fps, workshop.render.fps_base = 30, 1.001
    for frame, z, kappa, amplitude in (
        (1, 0.63, 0.1, 1.0),
        (6, 0.63, 0.1, 1.0),
        (9, 0.8, 0.4, 0.5),
    ):
        plank.location.z, plank.haptics.kappa, floor.haptics.source.amplitude = z, kappa, amplitude
        plank.haptics.listener.gain = amplitude
        plank.keyframe_insert("haptics.listener.gain", frame=frame)
        plank.keyframe_insert("location", frame=frame)
        plank.keyframe_insert("haptics.kappa", frame=frame)
        floor.keyframe_insert("haptics.source.amplitude", frame=frame)
    bpy.ops.export_scene.haptic_scene(
        filepath=str(tmp_path / "a.json"), frames="RANGE", frame_start=1, frame_end=12
    )
    export = read_export(tmp_path / "a.json")
    expected = list(traced_again(export.scene, export.recording))
    bpy.context.scene.frame_set(7)
    imported(tmp_path / "a.json")
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end, scene.frame_current) == (1, 12, 7)
    assert scene.render.fps / scene.render.fps_base == pytest.approx(30 / 1.001, rel=1e-6)
    for result in expected:
        scene.frame_set(result.number)
        now = traced()
        assert [item.name for item in now.sources] == sorted(item.name for item in result.sources)
        louder = {item.name: item.gain for item in result.listeners}
        assert {item.name: item.gain for item in now.listeners} == pytest.approx(louder, rel=1e-5)
        by_name = {
            item.name: row for item, row in zip(result.sources, result.amplitudes, strict=True)
        }
        columns = [
            [item.name for item in result.listeners].index(item.name) for item in now.listeners
        ]
        for source, gains in zip(now.sources, now.amplitudes, strict=True):
            np.testing.assert_allclose(gains, by_name[source.name][columns], rtol=2e-3, atol=1e-4)
    curves = bpy.data.objects["Box"].animation_data
    assert curves is None  # what did not move has no keyframes


def test_impacts_of_a_range_come_from_the_file(tmp_path, add_box):
    scene = bpy.context.scene
    scene.frame_end = 20
    add_box("ground", (0, 0, -0.5), (5, 5, 1)).haptics.listener.enabled = True
    stone = add_box("stone", (0, 0, 2.5), (1, 1, 1), mass=40)
    for frame, z in ((1, 2.5), (8, 0.5), (20, 0.5)):
        stone.location.z = z
        stone.keyframe_insert("location", frame=frame)
    with bpy.context.temp_override(object=stone, active_object=stone, selected_objects=[stone]):
        bpy.ops.rigidbody.object_add(type="ACTIVE")
    stone.rigid_body.kinematic, stone.rigid_body.mass = True, 40.0
    path = tmp_path / "a.json"
    bpy.ops.export_scene.haptic_scene(
        filepath=str(path), frames="RANGE", frame_start=1, frame_end=20, tracks="inline"
    )
    first = read_export(path)
    begun = [source for frame in first.recording.frames for source in frame.sources]
    assert len(begun) == 1 and begun[0].second_object
    bpy.ops.rigidbody.world_remove()
    imported(path)
    assert not bpy.context.scene.haptics.impacts
    bpy.ops.export_scene.haptic_scene(
        filepath=str(tmp_path / "b.json"),
        frames="RANGE",
        frame_start=1,
        frame_end=20,
        tracks="inline",
    )
    again = read_export(tmp_path / "b.json")
    (source,) = [source for frame in again.recording.frames for source in frame.sources]
    assert source.name == begun[0].name and source.onset == begun[0].onset
    np.testing.assert_allclose(source.position, begun[0].position, atol=1e-3)
    np.testing.assert_allclose(again.tracks.samples, first.tracks.samples, atol=2e-3)
    assert np.abs(again.tracks.samples).max() > 0.05


def test_a_file_from_elsewhere_without_shapes(tmp_path, traced):
    """Contacts alone say where objects are: boxes stand there, and everything is reached."""
    document = {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": [
            {"name": "ground", "kappa": 0.2, "rho": 0.9},
            {"name": "bench", "kappa": 0.1, "rho": 0.8},
        ],
        "contacts": [{"objects": ["ground", "bench"], "positions": [[1, 0, 0], [1, 0, 0]]}],
        "sources": [{"name": "jackhammer", "object": "ground", "position": [0, 0, 0]}],
        "listeners": [{"name": "seat", "object": "bench", "position": [1.2, 0, 0.4]}],
    }
    (tmp_path / "a.json").write_text(json.dumps(document))
    imported(tmp_path / "a.json")
    assert traced().amplitudes[0, 0] > 0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[]", "not a haptic scene"),
        (
            '{"format": "haptic-scene", "version": "1.1", "objects": [{"name": "a", "kappa": 2, '
            '"rho": 1}]}',
            "/objects/0/kappa: must be",
        ),
        ('{"format": "haptic-scene", "version": "9.0", "objects": []}', "/version"),
        ("{", "not JSON"),
    ],
)
def test_what_is_wrong_is_said_and_makes_nothing(tmp_path, text, reason):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(RuntimeError, match=reason):
        bpy.ops.import_scene.haptic_scene(filepath=str(tmp_path / "a.json"))
    assert not bpy.data.objects and not bpy.data.collections


def test_an_import_that_fails_on_the_way_leaves_nothing(tmp_path, monkeypatch):
    from haptic_tracing.addon.io import scene_builder

    (tmp_path / "a.json").write_text(
        '{"format": "haptic-scene", "version": "1.1", "objects": [{"name": "a", "kappa": 0, '
        '"rho": 1}]}'
    )

    def fail(self):
        raise ValueError("no more")

    monkeypatch.setattr(scene_builder._Builder, "take_settings", fail)
    with pytest.raises(RuntimeError, match="no more"):
        bpy.ops.import_scene.haptic_scene(filepath=str(tmp_path / "a.json"))
    assert not bpy.data.objects and not bpy.data.collections


def test_a_number_too_small_for_blender_counts_until_its_property_is_edited(tmp_path, capfd):
    tiny = {"function": "linear", "range": 1e-300}
    shape = {"type": "box", "size": [1, 1, 1]}
    form = {"name": "a", "kappa": 0, "rho": 1, "propagation": tiny, "shape": shape}
    (tmp_path / "a.json").write_text(
        json.dumps({"format": "haptic-scene", "version": "1.1", "objects": [form]})
    )
    assert bpy.ops.import_scene.haptic_scene(filepath=str(tmp_path / "a.json")) == {"FINISHED"}
    assert "as the file has it" not in capfd.readouterr().out
    haptics = bpy.data.objects["a"].haptics
    assert 0 < haptics.range < 1e-30
    assert json.loads(exported(tmp_path / "b.json"))["objects"][0]["propagation"] == tiny
    haptics.range = 2.5
    assert json.loads(exported(tmp_path / "c.json"))["objects"][0]["propagation"] == {
        "function": "linear",
        "range": 2.5,
    }


def test_damaged_text_in_a_strangers_file_is_a_problem_in_words(add_box, traced):
    from haptic_tracing.addon.session import session

    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = True
    other = add_box("other", (0, 0, 3), (1, 1, 1))
    other.haptics.source.enabled = True
    huge = "1" + 400 * "0"
    for text in (
        "{",
        "[]",
        '{"shape": 3}',
        '{"pose": {"position": [0]}}',
        '{"shape": {"type": "box", "size": [1e999, 1, 1]}}',
        f'{{"numbers": {{"kappa": {huge}}}}}',
        f'{{"mass": {huge}}}',
        f'{{"extras": {{"a": {huge}}}}}',
        '{"numbers": {"kappa": 5}}',
        '{"numbers": {"kappa": true}}',
        "[" * 1000,
    ):
        box.haptics.imported = text
        assert list(traced().objects) == [item.name for item in traced().sources] == ["other"], (
            "the rest goes on"
        )
        (problem,) = session.problems_of(bpy.context.scene)
        assert problem.object == "box" and "import it again" in problem.message
    for text in (
        "{",
        f'{{"numbers": {{"threshold": {huge}}}}}',
        '{"numbers": {"threshold": 2}}',
        f'{{"tolerance": {huge}}}',
    ):
        bpy.context.scene.haptics.imported = text
        assert list(traced().objects) == ["other"]
        assert "import it again" in session.problems_of(bpy.context.scene)[0].message
    bpy.context.scene.haptics.imported = ""
    bpy.data.objects.remove(other)
    box.haptics.imported = ""
    for text in (
        "{",
        '{"signal": 3}',
        '{"onset": "x"}',
        f'{{"onset": {huge}}}',
        '{"kind": "odd"}',
        '{"second_position": [1]}',
    ):
        box.haptics.source.imported = text
        assert not traced().sources
        assert "import it again" in session.problems_of(bpy.context.scene)[0].message
