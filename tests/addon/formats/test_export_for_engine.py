"""*Export for an Engine*: the glTF file has the objects of the haptic scene, where they are and as
they move; the baked pack, played by the C# client, gives the levels of the bake."""

import json
import re
import struct
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import bpy
import haptic_tracing as ht
import numpy as np
import pytest
from haptic_tracing.addon.session import session, timeline
from haptic_tracing.core.formats.haptic_scene import read_export

CSHARP = Path(__file__).parents[3] / "clients" / "csharp"
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


def test_all_three_files_say_where_they_come_from(exported):
    _, folder, gltf = exported
    scene = json.loads((folder / "bench.json").read_text("utf-8"))
    origin = scene["extras"]["provenance"]
    assert (origin["program"], origin["version"]) == ("Haptic Tracing", ht.__version__)
    assert origin["scene"] == read_export(folder / "bench.json").provenance["scene"]
    assert json.loads((folder / "bench.pack.json").read_text("utf-8"))["provenance"] == origin
    assert gltf["asset"]["extras"]["haptic_tracing"] == origin


def test_the_scene_has_the_gains_of_blender(exported):
    scene, folder, _ = exported
    scene.frame_set(1)
    result = session.result_of(scene)
    gains = ht.load(folder / "bench.json").gains()
    row = [item.name for item in result.sources].index("Motor")
    assert gains["Motor", "Hand"] == pytest.approx(result.propagation.gain[row, 0], rel=1e-6)


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Mono is installed on Linux only")
def test_the_pack_gives_the_levels_of_the_bake(exported, tmp_path):
    scene, folder, _ = exported
    pack = json.loads((folder / "bench.pack.json").read_text())
    assert pack["difference"] < 0.1 and len(pack["limits"]) == 3
    assert [sorted(blow["objects"]) for blow in pack["blows"]][:1] == [["Crate.001", "Ground"]]
    assert [shot["source"] for shot in pack["one_shots"]] == ["Bell", "Bell"]
    assert all("Hand" in shot["felt"] for shot in pack["one_shots"])
    with closing(timeline.steps(scene, 1, FRAMES)) as steps:
        blocks = [step.result.block for step in steps][1:]
    samples, rate = np.concatenate(blocks, axis=1), scene.render.fps / scene.render.fps_base
    program = tmp_path / "alone.exe"
    sources = [CSHARP / name for name in ("HapticTracing.cs", "HapticPack.cs", "Alone.cs")]
    command = ["mcs", "-warnaserror", f"-out:{program}", "-r:System.Net.Http", *sources]
    assert subprocess.run(command, timeout=120).returncode == 0
    command = ["mono", str(program), str(folder / "bench.pack.json"), str(rate), str(FRAMES - 1)]
    played = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout
    levels = [float(value) for value in re.findall(r"Hand=(\S+)", played)]
    ends = np.cumsum([block.shape[1] for block in blocks])
    expected = [samples[0, max(end - 2000, 0) : end] for end in ends]
    assert len(levels) == len(expected) == FRAMES - 1
    felt = [
        20 * np.log10(part.std()) if part.any() else np.nan
        for part in expected
        if len(part) == 2000
    ]
    assert np.nanmax(felt) - np.nanmin(felt) > 10  # the blow is among them
    assert levels[-len(felt) :] == pytest.approx(felt, abs=0.1, nan_ok=True)


def test_a_scene_without_listeners_says_that_it_has_no_pack(scene, add_box, tmp_path):
    add_box("Ground", (0, 0, -0.5), (10, 10, 1))
    with pytest.raises(RuntimeError, match="at least two frames with a listener"):
        bpy.ops.export_scene.haptic_engine(
            filepath=str(tmp_path / "bench.glb"), frame_start=1, frame_end=2
        )
    assert list(tmp_path.iterdir()) == []
    assert bpy.ops.export_scene.haptic_engine(
        filepath=str(tmp_path / "bench.glb"), frame_start=1, frame_end=2, packed=False
    ) == {"FINISHED"}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bench.glb", "bench.json"]
