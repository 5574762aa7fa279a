"""*Export for an Engine*: the glTF file has the objects of the haptic scene, where they are and as
they move."""

import json
import struct

import bpy
import haptic_tracing as ht
import pytest
from haptic_tracing.addon.session import session
from haptic_tracing.core.formats.haptic_scene import read_export
from program import run

FRAMES = 60


@pytest.fixture
def bench(scene, add_box, add_empty):
    """A crate falls onto the ground, in which a motor hums, and a bell is rung twice."""
    scene.frame_start, scene.frame_end = 1, FRAMES
    add_box("Ground", (0, 0, -0.5), (10, 10, 1), "PASSIVE")
    add_box("Crate.001", (0, 0, 1.5), (1, 1, 1), "ACTIVE", mass=5.0)
    for obj in scene.objects:
        obj.rigid_body.use_margin, obj.rigid_body.collision_margin = True, 0.0
    bell = add_empty("Bell", (0.2, 0, 0.5), parent=scene.objects["Ground"])
    motor = add_empty("Motor", (0.3, 0, 0.5), parent=scene.objects["Ground"])
    for obj in (motor, bell):
        obj.haptics.source.enabled, obj.haptics.source.signal = True, "SINE"
    bell.haptics.source.one_shot, bell.haptics.source.decay = True, 0.2
    motor.haptics.source.amplitude = 0.05
    for frame, value in ((1, 0.0), (40, 1.0), (45, 0.0), (50, 1.0)):
        bell.haptics.source.trigger = value
        bell.keyframe_insert("haptics.source.trigger", frame=frame)
    hand = add_empty("Hand", (0, 0, 0.5), parent=scene.objects["Crate.001"])
    hand.haptics.listener.enabled = True
    bpy.context.view_layer.update()
    return scene


@pytest.fixture
def exported(bench, tmp_path):
    addon = bpy.context.preferences.addons.new()  # where the glTF exporter looks for hooks
    addon.module = ht.__name__
    path = tmp_path / "bench.glb"
    assert bpy.ops.export_scene.haptic_engine(
        filepath=str(path), frame_start=1, frame_end=FRAMES
    ) == {"FINISHED"}
    data = path.read_bytes()
    (count,) = struct.unpack("<I", data[12:16])
    bpy.context.preferences.addons.remove(addon)
    return bench, tmp_path, json.loads(data[20 : 20 + count])


def test_scene_and_gltf_have_the_same_objects_at_the_same_places(exported):
    _, folder, gltf = exported
    nodes = {node["name"]: node for node in gltf["nodes"]}
    haptics = ht.load(folder / "bench.json").content
    assert {item.name for item in haptics.objects} == {"Ground", "Crate.001"} <= nodes.keys()
    assert {item.name for item in haptics.sources} == {"Bell", "Motor"} <= nodes.keys()
    for item in haptics.objects:
        x, y, z = item.pose.position
        assert nodes[item.name]["translation"] == pytest.approx([x, z, -y], abs=1e-6)
    (animation,) = gltf["animations"]
    moved = {gltf["nodes"][channel["target"]["node"]]["name"] for channel in animation["channels"]}
    assert "Crate.001" in moved  # physics included


def test_both_files_say_where_they_come_from(exported):
    _, folder, gltf = exported
    scene = json.loads((folder / "bench.json").read_text("utf-8"))
    origin = scene["extras"]["provenance"]
    assert (origin["program"], origin["version"]) == ("Haptic Tracing", ht.__version__)
    assert origin["scene"] == read_export(folder / "bench.json").provenance["scene"]
    assert gltf["asset"]["extras"]["haptic_tracing"] == origin


def test_the_scene_has_the_gains_of_blender(exported):
    scene, folder, _ = exported
    scene.frame_set(1)
    result = session.result_of(scene)
    gains = ht.load(folder / "bench.json").gains()
    row = [item.name for item in result.sources].index("Motor")
    assert gains["Motor", "Hand"] == pytest.approx(result.propagation.gain[row, 0], rel=1e-6)


@pytest.mark.slow
def test_the_command_writes_what_the_operator_writes(add_box, scene, tmp_path):
    box = add_box("box", (0, 0, 0), (1, 1, 1))
    box.haptics.source.enabled = box.haptics.listener.enabled = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.export_scene.haptic_engine(filepath=str(tmp_path / "a.glb"), frame_start=1, frame_end=3)
    done = run(
        "export", tmp_path / "a.blend", "--to", "gltf", "--frames", "1:3", "--out", tmp_path / "out"
    )
    assert done.returncode == 0, done.stderr
    for name in ("a.glb", "a.json", "a.tracer.json"):
        assert f"wrote {tmp_path / 'out' / name}" in done.stdout
    assert (tmp_path / "out" / "a.json").read_bytes() == (tmp_path / "a.json").read_bytes()
