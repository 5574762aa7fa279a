"""The C# client, compiled and run by Mono, against the server."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "clients" / "csharp"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="Mono is installed on Linux only"
    ),
]


def test_the_sample_feels_the_crate_land(tmp_path):
    assert shutil.which("mcs"), "Mono is missing: packaging/system_packages test"
    program = tmp_path / "fall.exe"
    sources = [CLIENT / "HapticTracing.cs", CLIENT / "Fall.cs"]
    compiled = subprocess.run(
        ["mcs", "-warnaserror", f"-out:{program}", "-r:System.Net.Http", *sources],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert compiled.returncode == 0, compiled.stdout + compiled.stderr
    command = [
        sys.executable,
        "-m",
        "haptic_tracing",
        "serve",
        str(CLIENT / "scene.json"),
        "--listen",
        "127.0.0.1:0",
    ]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        url = re.search(r"ws://\S+(?=,)", server.stderr.readline())[0]
        done = subprocess.run(
            ["mono", str(program), url], capture_output=True, text=True, timeout=120
        )
    finally:
        server.terminate()
        server.wait(20)
        server.stderr.close()
    assert done.returncode == 0, done.stdout + done.stderr
    energy, time = map(
        float, re.search(r"ground and crate: ([\d.]+) J at ([\d.]+) s", done.stdout).groups()
    )
    assert energy == pytest.approx(5 * 9.81 * 1.5, rel=0.01)
    assert time == pytest.approx(math.sqrt(2 * 1.5 / 9.81), abs=2e-3)
    assert re.search(
        r"90 frames, 1 blows, hand at -\d+\.\d\d dB, then: /poses/moon: there is no object 'moon'",
        done.stdout,
    ), done.stdout
