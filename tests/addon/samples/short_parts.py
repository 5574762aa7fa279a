"""Short parts of the samples, and what is stored of them: gains and levels by `level_reference`,
what touches and strikes as it was found.

They are played with the paper's functions, whose closed forms `level_reference` knows; those of
measured materials have tests of their own.

Run it with an interpreter that has bpy, and PYTHONPATH=tests/references, to store the values anew:
only where a change of them is meant.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import level_reference
import numpy as np

STORED = Path(__file__).with_name("stored_values.json")

PARTS: dict[str, tuple[int, int, int | None]] = {
    "jackhammer_bench": (1, 30, None),
    "hammer_nail": (1, 24, None),
    "fireplace": (1, 6, None),
    "dishwasher_kitchen": (1, 6, None),
    "rails": (1, 6, None),
    "domino_wall": (1, 45, 16),
    "pile": (1, 24, 12),
    "air_blast": (28, 31, None),
    "sliding_and_rolling": (1, 14, None),
    "kart": (1, 18, None),
    "kitchen": (1, 6, None),
    "boardwalk": (1, 15, None),
    "robot_cell": (30, 42, None),
    "mine_ride": (62, 72, None),
}
"""First and last frame, and how many things where that can be chosen. Simulations end before one
collision leads to another, from where on the last bit would decide."""


def use_paper(scene: Any) -> None:
    """Give a sample the paper's functions and contacts, with the default strategy."""
    import bpy

    with bpy.context.temp_override(scene=scene):
        bpy.ops.haptic.set_model(model="PAPER")
    scene.haptics.strategy = "best_path"
    for obj in scene.objects:
        obj.haptics.listener.limiter = False  # it comes late by what it looks ahead
    if scene.name.startswith("Rails"):  # too many objects on the way
        for obj in scene.objects:
            obj.haptics.function, obj.haptics.alpha = "exponential", 0.05


def played(name: str, scene: Any) -> list[Any]:
    """The traced frames of a sample's short part, with the paper's functions."""
    from haptic_tracing.addon.session import timeline

    use_paper(scene)
    first, last, _ = PARTS[name]
    with closing(timeline.steps(scene, first, last)) as steps:
        return [step.result for step in steps]


def shown(results: list[Any]) -> list[Any]:
    """The frames whose gains are stored: the last, and those in which something strikes."""
    return [result for result in results if result.impacts or result is results[-1]]


def digest(scene: Any, results: list[Any]) -> dict[str, Any]:
    """What is stored of a sample, as the product computes it: impacts, the level (RMS) at each
    listener, gains."""
    blocks = [result.block for result in results if result.block is not None]
    return {
        **_touched(scene, results),
        "levels": np.sqrt((np.concatenate(blocks, axis=1) ** 2).mean(axis=1)).tolist(),
        "gains": _rows(results, {result.number: result.amplitudes for result in results}),
    }


def reference(scene: Any, results: list[Any]) -> dict[str, Any]:
    """The same with gains and levels of `level_reference`."""
    found = {result.number: level_reference.gains(scene, result) for result in results}
    amplified = {
        r.number: found[r.number][0] * np.array([s.amplitude for s in r.sources]).reshape(-1, 1)
        for r in shown(results)
    }
    return {
        **_touched(scene, results),
        "levels": level_reference.levels(results, found).round(7).tolist(),
        "gains": _rows(results, amplified),
    }


def _touched(scene: Any, results: list[Any]) -> dict[str, Any]:
    from haptic_tracing.addon.session import session

    bodies = session.of(scene).reading.bodies
    return {
        "listeners": [item.body_part for item in results[-1].listeners],
        "contacts": len(results[-1].contacts),
        "impacts": [
            [r.number, *sorted(bodies[k].name for k in i.objects), round(i.energy, 4)]
            for r in results
            for i in r.impacts
        ],
    }


def _rows(results: list[Any], gains: Mapping[int, np.ndarray]) -> dict[str, list[Any]]:
    return {
        str(r.number): [
            [source.object, *row]
            for source, row in zip(r.sources, gains[r.number].round(7).tolist(), strict=True)
        ]
        for r in shown(results)
    }


def store() -> None:
    """Write the values of all samples."""
    import bpy
    import haptic_tracing
    from haptic_tracing.addon.changes.suspension import suspended
    from haptic_tracing.sample_scenes import build_sample

    values = {}
    for name, (_, _, count) in PARTS.items():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        haptic_tracing.register()
        with suspended():
            scene = build_sample(name, count)
        values[name] = reference(scene, played(name, scene))
        haptic_tracing.unregister()
        print(
            f"{name}: {len(values[name]['impacts'])} impacts, frames "
            f"{', '.join(values[name]['gains'])}",
            file=sys.stderr,
        )
    lines = [f' "{name}": {json.dumps(value)}' for name, value in values.items()]
    STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    store()
