"""The time of a step of the tracers in engines: walls of bricks on a ground, ten listeners, four
sources; all contacts move at every step, and all samples are mixed.

python benchmarks/tracers.py [BODIES ...]      needs Mono and Node
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import haptic_tracing as ht
import numpy as np
from haptic_tracing.core.forms import JsonObject
from haptic_tracing.plugins.engine import tables

ROOT = Path(__file__).parents[1]
MATERIALS = ("steel", "hardwood", "concrete", "brick")
WIDE = 10
"""Bricks in a row of a wall, and rows."""


def walls(count: int) -> ht.Scene:
    """``count`` objects: a ground, and walls on it in which each brick lies on two."""
    objects: list[JsonObject] = [
        {
            "name": "ground",
            "material": "concrete",
            "shape": {"type": "box", "size": [4 * WIDE, 2 + count / WIDE**2, 1]},
            "pose": {"position": [0, 0, -0.5]},
            "motion": "static",
        }
    ]
    for k in range(count - 1):
        wall, place = divmod(k, WIDE**2)
        row, column = divmod(place, WIDE)
        position = [
            1.05 * (column - WIDE / 2) + 0.5 * (row % 2),
            wall - count // WIDE**2 / 2,
            0.5 * row + 0.25,
        ]
        objects.append(
            {
                "name": f"brick {k}",
                "material": MATERIALS[k % len(MATERIALS)],
                "shape": {"type": "box", "size": [1, 0.5, 0.5]},
                "pose": {"position": position},
                "mass": 5,
            }
        )
    far = np.linspace(1, count - 1, 14).round().astype(int).tolist()
    ends = [
        {"name": f"end {k}", "object": item["name"], "position": item["pose"]["position"]}
        for k, item in enumerate(objects[number] for number in far)
    ]
    signals = [{"signal": "sine", "frequency": f} for f in (40, 80, 160, 250)]
    sources = [{**end, "signal": signal} for end, signal in zip(ends[::4], signals, strict=False)]
    return ht.Scene(objects=objects, sources=sources, listeners=ends[4:])


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "speed.exe"
        sources = ROOT / "clients/csharp/HapticTracer.cs", ROOT / "benchmarks/TracerSpeed.cs"
        subprocess.run(["mcs", "-optimize", f"-out:{program}", *sources], check=True)
        script = ROOT / "benchmarks/tracer_speed.mjs"
        print("with bodies contacts heard least median processor [ms] collections")
        for count in map(int, sys.argv[1:] or ("100", "1000")):
            scene = walls(count)
            path = tables.write(scene.content, Path(folder) / "walls.tracer.json")
            found = scene.contacts_found()
            places = found.positions[:, 0][:, [0, 2, 1]] * (1, 1, -1)
            normals = found.normal[:, [0, 2, 1]] * (1, 1, -1)
            rows = np.column_stack([found.pairs, places, normals, found.area])
            lines = "\n".join(" ".join(map(str, row)) for row in rows.tolist())
            for command in (["mono", "-O=all", str(program)], ["node", str(script)]):
                print(command[0], end=" ", flush=True)
                subprocess.run([*command, path], input=lines, text=True, check=True)


if __name__ == "__main__":
    main()
