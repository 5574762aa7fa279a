"""The C# client, compiled and run by Mono, against the server."""

from __future__ import annotations

import base64
import json
import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
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


PACK_PROGRAM = """
using System;
using System.Globalization;
using System.IO;
using HapticTracing;
static class Program
{
    static void Main(string[] arguments)
    {
        CultureInfo.CurrentCulture = CultureInfo.InvariantCulture;
        var pack = new Pack(File.ReadAllText(arguments[0]));
        pack.SetMaterial("barrel", "wood");
        pack.SetMaterial("cloud", "air");
        var here = new double[] { 0, 0, 0 };
        Console.WriteLine(pack.Hit("cloud", "floor", 10, here, 0) + " " + pack.Play("drum", 0));
        Show(pack, 0.002);
        Console.WriteLine(pack.Hit("floor", "barrel", 5, here, 0.003) + " " + pack.Play("bell", 0.003));
        Show(pack, 0.006);
        Console.WriteLine(pack.Hit("crate", "floor", 1000, new double[] { 9, 0, 0 }, 0));
        Show(pack, 0.008);
    }
    static void Show(Pack pack, double time)
    {
        Console.WriteLine(string.Join(" ", pack.Advance(time)["hand"]));
    }
}
"""


def test_a_pack_plays_its_table_by_objects_then_by_materials(tmp_path):
    """By hand, at 1,000 samples a second: a blow of half the full energy is played twice as loud by
    one of full energy, the nearest of two by place; the sum is clipped at 1."""

    def packed(*samples):
        return {"hand": base64.b64encode(np.array(samples, "<f4").tobytes()).decode()}

    def blow(x, *samples):
        return {"objects": ["crate", "floor"], "time": 0.0, "position": [x, 0, 0], "energy": 5,
                "full_energy": 10, "felt": packed(*samples)}  # fmt: skip

    pack = {
        "format": "haptic-pack", "version": "1.0", "limits": ["none"], "sample_rate": 1000,
        "materials": {"crate": "wood", "floor": "stone"}, "samples": 3, "tracks": packed(0.125, 0.25, 0.375),
        "listeners": [{"name": "hand", "body_part": "", "s_max": 1.0}],
        "blows": [blow(1, 0.25, -0.25), blow(8, 0.75, 0.5)],
        "one_shots": [{"source": "bell", "time": 0.0, "felt": packed(0, 0.5)}],
    }  # fmt: skip
    (tmp_path / "a.pack.json").write_text(json.dumps(pack))
    (tmp_path / "Program.cs").write_text(PACK_PROGRAM)
    program = tmp_path / "program.exe"
    sources = [CLIENT / "HapticTracing.cs", CLIENT / "HapticPack.cs", tmp_path / "Program.cs"]
    compiled = subprocess.run(
        ["mcs", "-warnaserror", f"-out:{program}", "-r:System.Net.Http", *sources],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert compiled.returncode == 0, compiled.stdout + compiled.stderr
    command = ["mono", str(program), str(tmp_path / "a.pack.json")]
    lines = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout.splitlines()
    assert lines == [
        "False False",
        "0.125 0.25",
        "True True",
        "0.375 0.25 0.25 0",  # the blow at the place of the first one, as strong as in the bake
        "True",
        "1 1",  # 1.5 and 1, clipped
    ]
