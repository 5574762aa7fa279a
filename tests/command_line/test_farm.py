"""The Open Job Description of an export, checked and run by the reference implementation of the
specification."""

import os
import subprocess
import sys
from pathlib import Path

import bpy
import haptic_tracing
import pytest
from haptic_tracing.command_line import main
from haptic_tracing.sample_scenes import build_sample

pytest.importorskip("openjd.cli", reason="openjd-cli is not installed")
TEMPLATE = Path(haptic_tracing.__file__).parent / "command_line" / "export.yaml"


def openjd(*arguments, folder=None):
    # The program is found beside this interpreter.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    command = [sys.executable, "-m", "openjd", *map(str, arguments)]
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PATH": path},
        cwd=folder,
    )


@pytest.mark.slow
def test_the_template_is_valid_and_has_a_task_per_part():
    assert "passes validation" in openjd("check", TEMPLATE).stdout
    told = openjd(
        *("summary", TEMPLATE, "-p", "BlendFile=a.blend", "-p", "LastFrame=9", "-p", "Parts=5"),
        *("-p", "OutputFolder=out"),
    ).stdout
    assert "Total steps: 2" in told and "Total tasks: 6" in told


@pytest.mark.parametrize(
    ("given", "left_out"),
    [
        (["a.blend", "--frames", "1:9", "--job-template"], "leave out files frames;"),
        (["--job-template", "--to", "hjif"], "leave out --to hjif;"),
    ],
)
def test_arguments_that_the_template_does_not_take_are_refused(capsys, given, left_out):
    assert main(["export", *given]) == 2
    told = capsys.readouterr()
    assert left_out in told.err and not told.out
    assert main(["export", "--job-template"]) == 0
    assert capsys.readouterr().out == TEMPLATE.read_text("utf-8")


@pytest.mark.slow
def test_an_export_run_as_a_job_is_the_export(tmp_path):
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    try:
        build_sample("hammer_nail")
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "hammer.blend"))
        bpy.ops.export_scene.haptic_tracks(
            filepath=str(tmp_path / "addon.wav"), formats={"wav"}, frame_start=1, frame_end=12
        )
    finally:
        haptic_tracing.unregister()
    job = {
        "BlendFile": tmp_path / "hammer.blend",
        "LastFrame": 12,
        "Parts": 3,
        "PartsInARow": 2,
        "OutputFolder": "out",
    }
    done = openjd(
        "run",
        TEMPLATE,
        *(word for name, value in job.items() for word in ("-p", f"{name}={value}")),
        folder=tmp_path,  # where the user stands is where a relative folder lies
    )
    assert done.returncode == 0, done.stdout + done.stderr
    # Two parts by one Blender, then one, then the merge.
    assert done.stdout.count("Running command") == 3 and "openjd_progress: 100" in done.stdout
    assert (tmp_path / "out" / "hammer.wav").read_bytes() == (tmp_path / "addon.wav").read_bytes()
