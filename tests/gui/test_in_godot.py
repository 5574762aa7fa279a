"""The Godot add-on in Godot itself, with Jolt, against the server: `make test-godot
GODOT=path/to/godot`."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2] / "clients" / "godot"


@pytest.fixture
def server():
    command = [sys.executable, "-m", "haptic_tracing", "serve", "--listen", "127.0.0.1:0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    yield re.search(r"ws://\S+(?=,)", process.stderr.readline())[0]
    process.terminate()
    process.wait(20)
    process.stderr.close()


def test_the_sample_feels_the_crate_land(server):
    godot = [
        *shlex.split(os.environ["GODOT"]),
        "--headless",
        "--path",
        os.environ.get("GODOT_FOLDER", str(PROJECT)),
    ]
    subprocess.run([*godot, "--import"], capture_output=True, text=True, timeout=120)
    done = subprocess.run([*godot, "--", server], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    energy = float(re.search(r"Ground and Crate: ([\d.]+) J", done.stdout)[1])
    # Jolt's steps of 1/60 s change the height of the fall by up to 5 %.
    assert energy == pytest.approx(5 * 9.81 * 2.0, rel=0.05)
    level = float(re.search(r"1 blows, hand at (-[\d.]+) dB", done.stdout)[1])
    assert -60 < level < 0
