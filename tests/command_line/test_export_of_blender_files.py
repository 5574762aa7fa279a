"""``export`` and ``trace`` of Blender files as they are typed, against what the add-on exports of the
same file."""

import bpy
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.command_line.setting import assign
from haptic_tracing.core.formats.haptic_scene import read_export
from program import run

FRAMES = "1:30"


@pytest.mark.slow
def test_export_equals_that_of_the_add_on_to_the_bit(falling, tmp_path):
    done = run(
        "export",
        falling / "hammer.blend",
        "--frames",
        FRAMES,
        "--to",
        "wav,scene",
        "--out",
        tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert [line for line in done.stdout.splitlines() if line.startswith("wrote")] == [
        f"wrote {tmp_path / name}" for name in ("hammer.wav", "hammer.wav.json", "hammer.json")
    ]
    assert "not in wav: the scene itself" in done.stdout
    assert (tmp_path / "hammer.wav").read_bytes() == (falling / "addon.wav").read_bytes()
    assert len(read_export(tmp_path / "hammer.json").recording.frames) > 1


@pytest.mark.slow
def test_modes_and_settings(falling, command, tmp_path):
    settings = [
        "--set",
        "scene.haptics.minimum_energy=0",
        "--set",
        'objects["Hammer"].haptics.kappa=1',
    ]
    assert (
        command(
            "export",
            falling / "hammer.blend",
            "--frames",
            FRAMES,
            "--modes",
            "HT,SD",
            "--out",
            tmp_path,
            *settings,
        )
        == 0
    )
    assert {path.name for path in tmp_path.iterdir()} == {
        f"hammer.{mode}.wav{more}" for mode in ("HT", "SD") for more in ("", ".json")
    }
    assert (tmp_path / "hammer.HT.wav").read_bytes() != (tmp_path / "hammer.SD.wav").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--modes", "HT,XX"], "--modes: must be some of HT, SD, MD, MN, not XX"),
        (["--to", "midi"], "format 'midi' is unknown"),
        (["--frames", "9:2"], "must be FIRST:LAST"),
    ],
)
def test_bad_arguments_are_one_line_and_write_nothing(tmp_path, capsys, arguments, said):
    assert (
        main(["export", str(tmp_path / "hammer.blend"), "--out", str(tmp_path / "out"), *arguments])
        == 2
    )
    message = capsys.readouterr().err
    assert said in message and message.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_property_that_is_not_in_the_file_is_one_line_and_writes_nothing(
    falling, command, tmp_path, capsys
):
    assert (
        command(
            "export",
            falling / "hammer.blend",
            "--out",
            tmp_path / "out",
            "--set",
            'objects["Gone"].haptics.kappa=1',
        )
        == 2
    )
    said = capsys.readouterr().err
    assert 'there is no objects["Gone"].haptics.kappa' in said and "Traceback" not in said
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("scene.haptics.minimum_energy=-2", "must be "),
        ("scene.haptics.minimum_energy", "expected PATH=VALUE"),
        ("scene.haptics.minimum_energy=much", "must be a number"),
        ("scene.haptics.mode=XX", "enum"),
        ("scene.haptics=1", "only single values"),
        ("scene.frame_end=0.5", "must be a number"),
        ("__import__('os').system('true')=1", "there is no __import__"),
        ('objects["Cube"].location=1', "only single values"),
        ('objects["Cube"].pass_index=7', "is animated"),
    ],
)
def test_settings_that_cannot_be_made(registered, setting, said):
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object
    cube.keyframe_insert("pass_index", frame=1)
    with pytest.raises(ValueError, match=said):
        assign(bpy.context.scene, setting)


@pytest.fixture(scope="module")
def eighth(falling):
    """What ``trace`` says and writes of the eighth frame, before the blow."""
    done = run(
        "trace", falling / "hammer.blend", "--end", "8", "--no-picture", "--out", falling / "last"
    )
    return done.stdout, falling / "last" / "hammer.json"


@pytest.mark.slow
def test_trace_writes_all_frames_where_asked_and_says_which(
    falling, eighth, command, tmp_path, capsys
):
    said, last = eighth
    assert f"wrote {last} (frame 8)" in said
    assert read_export(last).recording is None
    command(
        "trace",
        falling / "hammer.blend",
        "--end",
        "8",
        "--no-picture",
        "--whole",
        "--out",
        tmp_path / "whole",
    )
    assert f"wrote {tmp_path / 'whole' / 'hammer.json'} (frames 1 to 8)" in capsys.readouterr().out
    assert read_export(tmp_path / "whole" / "hammer.json").recording.frames[-1].number <= 9


@pytest.mark.slow
def test_export_of_a_silent_scene_says_why(eighth, tmp_path, capsys):
    assert (
        main(["export", str(eighth[1]), "--to", "wav", "--out", str(tmp_path), "--seconds", "0.2"])
        == 0
    )
    assert "feels nothing: there is no source" in capsys.readouterr().err


@pytest.mark.slow
def test_trace_without_a_camera_writes_all_but_the_picture(registered, tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_cube_add()
    cube = bpy.context.object.haptics
    cube.enabled = cube.source.enabled = cube.listener.enabled = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "cube.blend"))
    done = run("trace", tmp_path / "cube.blend", "--end", "2", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "no picture: scene 'Scene' has no camera" in done.stdout
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"cube.json", "cube.wav"}
