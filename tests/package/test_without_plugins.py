"""Without the folder `plugins`, the add-on registers, draws, traces, bakes, plays and exports, and
the core reads and writes its own files: their tests pass in a copy that lacks it. `make test-heart`
runs all of them there."""

import os
import re
import subprocess
import sys

import pytest

OF_THE_HEART = (
    "tests/addon/test_registration.py",
    "tests/addon/test_panels.py",
    "tests/addon/test_tracing.py",
    "tests/addon/overlay/test_draw.py",
    "tests/addon/bake/test_bake_against_tracing.py",
    "tests/addon/live_output/test_live_output.py",
    "tests/addon/formats/test_export_operators.py",
    "tests/core/formats",
)


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the copy is made by a script")
def test_the_heart_passes_without_plug_ins(root, tmp_path):
    if not (root / "plugins").is_dir():
        pytest.skip("this is the copy")
    subprocess.run([root / "packaging" / "without_plugins", tmp_path], check=True)
    copy = tmp_path / "haptic_tracing"
    assert not (copy / "plugins").exists()
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-m", "not slow", "-p", "no:xdist", *OF_THE_HEART],
        cwd=copy,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout[-4000:]
    assert int(re.search(r"(\d+) passed", run.stdout)[1]) > 200
