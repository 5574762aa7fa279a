"""The command that saves a sample as a Blender file, in a process of its own."""

import bpy
import haptic_tracing
import pytest
from haptic_tracing.command_line import main
from program import run


@pytest.mark.slow
def test_saved_file_has_its_rigid_bodies_baked(tmp_path):
    answer = run("sample", "domino_wall", "--count", "8", "--output", "few.blend", cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert "wrote few.blend" in answer.stdout
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "few.blend"))
    scene = bpy.context.scene
    assert scene.name == "Wall of Dominoes"
    assert scene.rigidbody_world.point_cache.is_baked
    # A jump to the end shows the fallen dominoes, without the frames between.
    scene.frame_set(scene.frame_end)
    dominoes = [obj for obj in scene.objects if obj.name.startswith("Domino")]
    assert len(dominoes) == 8
    assert all(obj.matrix_world[2][2] < 0.9 for obj in dominoes)
    assert all(obj.haptics.enabled for obj in dominoes)


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("pyramid",), "invalid choice: 'pyramid'"),
        (("pile", "--output", "pile.txt"), "ends in .blend"),
        (("pile", "--output", "nowhere/pile.blend"), "there is no folder"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(arguments, reason, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["sample", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert reason in said
    assert list(tmp_path.iterdir()) == []


def test_a_count_where_there_is_none_to_choose_is_said_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    haptic_tracing.unregister()  # the command registers properties itself
    try:
        assert main(["sample", "rails", "--count", "3"]) == 2
    finally:
        haptic_tracing.register()
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "give no count" in said
    assert list(tmp_path.iterdir()) == []


def test_help_lists_every_sample(capsys):
    from haptic_tracing.sample_scenes import SAMPLES

    assert main(["sample", "--help"]) == 0
    text = capsys.readouterr().out
    assert all(sample.name in text and sample.description in text for sample in SAMPLES.values())
