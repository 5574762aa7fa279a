"""The Godot add-on in Godot itself: with Jolt against the server, and with an export of Blender: `make test-godot GODOT=path/to/godot`. A Godot that sees other folders: its own
name of `clients/godot` is GODOT_FOLDER, and GODOT_SHARED a folder that has one name for both."""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import subprocess
import sys
import wave
from pathlib import Path

import numpy as np
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


@pytest.fixture(scope="module")
def godot():
    """Runs Godot with these arguments, and returns what it prints."""
    command = [
        *shlex.split(os.environ["GODOT"]),
        "--headless",
        "--path",
        os.environ.get("GODOT_FOLDER", str(PROJECT)),
    ]

    def run(*arguments):
        done = subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run


def test_the_sample_feels_the_crate_land(server, godot):
    printed = godot("--", server)
    energy = float(re.search(r"Ground and Crate: ([\d.]+) J", printed)[1])
    # Jolt's steps of 1/60 s change the height of the fall by up to 5 %.
    assert energy == pytest.approx(5 * 9.81 * 2.0, rel=0.05)
    level = float(re.search(r"1 blows, hand at (-[\d.]+) dB", printed)[1])
    assert -60 < level < 0


FRAMES, RATE = 80, 24


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The sample *Hammer and Nail*, exported for an engine: the path of its files without their
    endings, and the levels of its bake for each frame, by listener, where they are known."""
    shared = os.environ.get("GODOT_SHARED")  # a folder that Godot sees under the same name
    folder = Path(shared) if shared else tmp_path_factory.mktemp("exported")
    file, frames = folder / "hammer.blend", f"1:{FRAMES}"
    for arguments in (
        ("sample", "hammer_nail", "--output", file),
        ("export", file, "--to", "gltf", "--out", folder, "--frames", frames),
        ("export", file, "--out", folder, "--frames", frames, "--to", "wav", "--absolute"),
    ):
        command = [sys.executable, "-m", "haptic_tracing", *map(str, arguments)]
        subprocess.run(command, check=True, capture_output=True, timeout=300)
    with wave.open(str(folder / "hammer.wav")) as wav:
        samples = np.frombuffer(wav.readframes(wav.getnframes()), "<i2").reshape(
            -1, wav.getnchannels()
        )
    tracks = json.loads((folder / "hammer.wav.json").read_text())
    window = round(0.25 * tracks["sample_rate"])
    levels = []
    for frame in range(FRAMES):
        end = math.ceil(frame / RATE * tracks["sample_rate"] - 1e-6)
        rms = samples[max(end - window, 0) : end].std(axis=0) / 32768 if end >= window else []
        levels.append(
            {
                listener["name"]: 20 * math.log10(value)
                for listener, value in zip(tracks["listeners"], rms, strict=False)
                if value > 1e-3  # of 16 bits
            }
        )
    return folder / "hammer", levels


def compare(printed, expected, tolerance):
    """Compare the printed levels of each frame with the known ones."""
    lines = [json.loads(text) for text in re.findall(r"levels: (.*)", printed)]
    assert len(lines) == FRAMES
    compared = 0
    for line, known in zip(lines, expected, strict=True):
        for listener, level in known.items():
            assert line[listener] == pytest.approx(level, abs=tolerance)
            compared += 1
    assert compared > 50


def test_an_export_plays_with_the_levels_of_the_bake(server, godot, exported):
    """Godot imports the glTF file and sends the poses of its animation."""
    path, levels = exported
    printed = godot("sample/exported.tscn", "--", str(path), str(RATE), server)
    compare(printed, levels, 0.5)


def test_an_export_that_is_not_there_is_asked_for(godot):
    with pytest.raises(AssertionError, match="After --, give PATH/NAME"):
        godot("sample/exported.tscn", "--", "nowhere", str(RATE))
