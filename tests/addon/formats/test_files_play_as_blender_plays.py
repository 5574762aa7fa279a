"""A sample played in Blender, and by the core from its exported file alone: the same gains, impacts
and rules."""

import json
from dataclasses import replace

import bpy
import pytest
from haptic_tracing.addon.blender.compatibility import fcurves_of
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.session import session
from haptic_tracing.core.formats.haptic_scene import read_export
from haptic_tracing.core.formats.scene.recording import traced
from haptic_tracing.core.graph.haptic_graph import build_graph
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.render.arrival import arriving
from haptic_tracing.core.scene.values import SourceKind
from haptic_tracing.sample_scenes import build_sample
from scene_files import exported

LAST = 60
"""Frame after the first blows of the hammer."""


def gains(result):
    return {
        (source.name, listener.name): gain
        for source, row in zip(result.sources, result.amplitudes, strict=True)
        for listener, gain in zip(result.listeners, row.tolist(), strict=True)
    }


@pytest.fixture
def hammer(scene):
    with suspended():
        built = build_sample("hammer_nail", None)
    built.frame_end = LAST
    return built


@pytest.fixture
def written(hammer, tmp_path):
    """Exports the sample after a change of its properties: the path of the file."""

    def write(**properties):
        for name, value in properties.items():
            setattr(hammer.haptics, name, value)
        exported(
            tmp_path / "hammer.json", frames="RANGE", frame_start=hammer.frame_start, frame_end=LAST
        )
        return tmp_path / "hammer.json"

    return write


def in_blender(scene):
    scene.frame_set(scene.frame_start - 1)
    for frame in range(scene.frame_start, scene.frame_end + 2):  # at which the last one ends
        scene.frame_set(frame)
        yield session.result_of(scene)


def without_contacts(path):
    """The scene and recording of a file from which contacts and impacts are removed: shapes, poses
    and rules are left."""
    document = json.loads(path.read_text())
    document.pop("contacts")
    document["sources"] = [
        source for source in document["sources"] if source.get("kind") != "temporary"
    ]
    for frame in document["frames"]:
        for key in ("contacts", "parted", "sources", "source_positions"):
            frame.pop(key, None)
    path.write_text(json.dumps(document))
    export = read_export(path)
    return export.scene, export.recording


def impacts_of(results):
    return [impact for result in results for impact in result.impacts]


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["as_in_the_paper", "best_path"])
def test_the_core_plays_what_blender_plays(hammer, written, strategy):
    export = read_export(written(strategy=strategy))
    count = 0
    for ours, theirs in zip(
        in_blender(hammer), traced(export.scene, export.recording), strict=True
    ):
        assert ours.number == theirs.number
        # Poses are written to 1e-5 m: how far contacts lie beside the middles of bodies, and so how
        # these carry what stands behind them, differs by that.
        assert gains(theirs) == pytest.approx(gains(ours), rel=1e-8, abs=1e-15)
        graph = build_graph(
            ours.graph.table, ours.contacts, ours.sources, ours.listeners, theirs.graph.frames
        )
        placed = propagate(graph, export.scene.settings, sounding_only=True)
        expected = replace(ours, amplitudes=arriving(ours.sources, placed))
        assert gains(theirs) == pytest.approx(gains(expected), rel=1e-12, abs=1e-15)
        count += sum(source.kind is SourceKind.TEMPORARY for source in ours.sources)
    assert count > 0


def test_impacts_found_outside_blender_follow_the_rules_of_the_file(scene, add_box, tmp_path):
    """A crate that is keyed to fall by a parabola, which poses tell as its curve does."""
    mass, height, (begin, end) = 20.0, 1.5, (6.3, 15.9)
    scene.frame_start, scene.frame_end = 1, 20
    add_box("floor", (0, 0, -0.5), (20, 20, 1), "PASSIVE")
    crate = add_box("crate", (0, 0, 0.2), (0.4, 0.4, 0.4), "ACTIVE", mass=mass)
    crate.rigid_body.kinematic = True
    for frame, place in ((begin, 0.2 + height), (end, 0.2)):
        crate.location.z = place
        crate.keyframe_insert("location", frame=frame)
    for curve in fcurves_of(crate):
        for key in curve.keyframe_points:
            key.interpolation, key.easing = "QUAD", "EASE_IN"
    seconds = (end - begin) / 24
    energy = mass / 2 * (2 * height / seconds) ** 2

    def found(**properties):
        for name, value in properties.items():
            setattr(scene.haptics, name, value)
        exported(tmp_path / "crate.json", frames="RANGE", frame_start=1, frame_end=20)
        return list(traced(*without_contacts(tmp_path / "crate.json")))

    rules = {"minimum_energy": 5.0, "maximum_energy": 1000.0}
    for results in (found(**rules), in_blender(scene)):
        (blow,) = impacts_of(results)
        assert blow.time == pytest.approx((end - 1) / 24, abs=1e-3)
        assert blow.energy == pytest.approx(energy, rel=0.01)
        assert blow.amplitude == pytest.approx(blow.energy / 1000.0)
    assert impacts_of(found(minimum_energy=1000.0, maximum_energy=2000.0)) == []
    results = found(minimum_energy=5.0, impacts=False)
    assert not any(
        source.kind is SourceKind.TEMPORARY for result in results for source in result.sources
    )


def test_what_is_switched_on_and_off_comes_and_goes(scene, add_box, add_empty, tmp_path):
    """A crate with a drill and a hand on it, both objects of Blender, is haptic in some frames
    only, in the file as well."""
    scene.frame_start, scene.frame_end = 1, 12
    floor = add_box("floor", (0, 0, -0.5), (4, 4, 1))
    floor.haptics.source.enabled = True
    foot = add_empty("foot", (0, 1, 0.5), parent=floor)
    crate = add_box("crate", (0, 0, 0.5), (1, 1, 1))
    hand = add_empty("hand", (0, 0, 0.5), parent=crate)
    drill = add_empty("drill", (0.5, 0, 0.5), parent=crate)
    drill.haptics.source.enabled = foot.haptics.listener.enabled = True
    for frame, there in ((1, False), (4, True), (8, False), (10, True)):
        crate.haptics.enabled = hand.haptics.listener.enabled = there
        crate.keyframe_insert("haptics.enabled", frame=frame)
        hand.keyframe_insert("haptics.listener.enabled", frame=frame)
    exported(tmp_path / "crate.json", frames="RANGE", frame_start=1, frame_end=12)
    expected = [gains(result) for result in in_blender(scene)]
    assert sorted({len(each) for each in expected}) == [1, 4]
    export = read_export(tmp_path / "crate.json")
    assert [item.name for item in export.scene.objects] == ["floor"]
    for ours, theirs in zip(expected, traced(export.scene, export.recording), strict=True):
        assert gains(theirs) == pytest.approx(ours, rel=1e-12)


def test_a_listener_on_a_bone_moves_in_the_file_as_its_bone(scene, add_box, tmp_path):
    scene.frame_start, scene.frame_end = 1, 8
    floor = add_box("floor", (0, 0, -0.5), (4, 4, 1))
    floor.haptics.source.enabled = True
    body = add_box("body", (0, 0, 0.5), (1, 1, 1))
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.new("arm").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.haptics.body = body
    hand = bpy.data.objects.new("hand", None)
    scene.collection.objects.link(hand)
    hand.parent, hand.parent_type, hand.parent_bone = rig, "BONE", "arm"
    hand.haptics.listener.enabled = True
    for frame, angle in ((1, 0.0), (8, 1.0)):
        rig.pose.bones["arm"].rotation_mode = "XYZ"
        rig.pose.bones["arm"].rotation_euler.x = angle
        rig.pose.bones["arm"].keyframe_insert("rotation_euler", frame=frame)
    exported(tmp_path / "arm.json", frames="RANGE", frame_start=1, frame_end=8)
    export = read_export(tmp_path / "arm.json")
    felt = set()
    for ours, theirs in zip(in_blender(scene), traced(export.scene, export.recording), strict=True):
        assert gains(theirs) == pytest.approx(gains(ours), rel=1e-12)
        felt.update(gains(ours).values())
    assert len(felt) == 8 and min(felt) > 0
