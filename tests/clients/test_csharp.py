"""The C# client, compiled and run by Mono, against the server, and what is beside it."""

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
HERE = Path(__file__).parent
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not sys.platform.startswith("linux"), reason="Mono is installed on Linux only"
    ),
]


def compiled(program, *sources, options=()):
    """The program of some sources."""
    assert shutil.which("mcs"), "Mono is missing: packaging/system_packages test"
    done = subprocess.run(
        ["mcs", "-warnaserror", *options, f"-out:{program}", *sources],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return program


def test_components_of_unity_compile(tmp_path):
    """Against declarations of what they use of it."""
    names = ("Tracing", "TracingBehaviour", "Tracer", "Object", "Source", "Listener")
    compiled(
        tmp_path / "components.dll",
        *(CLIENT / f"Haptic{name}.cs" for name in names),
        HERE / "UnityEngine.cs",
        # Unity sets what its inspector shows.
        options=(
            "-target:library", "-langversion:7", "-nowarn:649", "-d:ENABLE_INPUT_SYSTEM",
            "-r:System.Net.Http",
        ),
    )  # fmt: skip


def test_a_tracer_that_is_made_in_code(tmp_path):
    """Without a file gains are those of the functions, and what parts or goes is silent."""
    program = compiled(tmp_path / "made.exe", CLIENT / "HapticTracer.cs", HERE / "MadeInCode.cs")
    done = subprocess.run(["mono", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    touching, parted, struck, removed = (
        [float(word) for word in line.split()] for line in done.stdout.splitlines()
    )
    # The tone is 2 m above the contact, the ball of the listener ends 2.5 m beside it.
    gain = math.exp(-0.3 * 2) * 0.4 * math.exp(-0.4 * 2.5)
    assert touching[0] == pytest.approx(gain, rel=1e-9)
    assert touching[1] == pytest.approx(20 * math.log10(gain * 0.5 / math.sqrt(2)), abs=1e-3)
    assert touching[2] == 2
    assert parted[0] == 0 and math.isnan(parted[1]) and parted[2] == 0
    assert struck[0] == pytest.approx(4 * 5**2 / 2 / 100)
    assert struck[1] == pytest.approx(0.4 * math.exp(-0.4 * 2.5), rel=1e-9)
    assert not math.isnan(struck[2])
    assert removed[:2] == [1, 0] and math.isnan(removed[2])


def test_the_sample_feels_the_crate_land(tmp_path):
    program = compiled(
        tmp_path / "fall.exe",
        CLIENT / "HapticTracing.cs",
        CLIENT / "Fall.cs",
        options=("-r:System.Net.Http",),
    )
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
