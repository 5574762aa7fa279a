"""Short parts of the samples, and what is stored of them.

Run it with an interpreter that has bpy to store the values anew: only where a change of them is meant.
"""

from __future__ import annotations

import json
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

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
    "air_blast": (28, 38, None),
    "mine_ride": (62, 72, None),
}
"""First and last frame, and how many things where that can be chosen. Simulations end before one collision leads to another, from where on
the last bit would decide."""


def digest(name: str, scene: Any) -> dict[str, Any]:
    """What is stored of a sample: impacts, the level (RMS) at each listener, gains in the last frame and wherever something strikes."""
    from haptic_tracing.addon.session import timeline

    first, last, _ = PARTS[name]
    impacts: list[list[Any]] = []
    gains: dict[str, list[Any]] = {}
    blocks = []
    with closing(timeline.steps(scene, first, last)) as steps:
        for step in steps:
            result = step.result
            impacts += [[result.number, *sorted(result.objects[k] for k in i.objects), round(i.energy, 4)] for i in result.impacts]
            if result.impacts or result.number == last:
                rows = zip(result.sources, result.gains.round(7).tolist(), strict=True)
                gains[str(result.number)] = [[source.object, *row] for source, row in rows]
            if result.block is not None:
                blocks.append(result.block)
    levels = np.sqrt((np.concatenate(blocks, axis=1) ** 2).mean(axis=1))
    return {
        "listeners": [item.body_part for item in result.listeners],
        "contacts": len(result.contacts),
        "impacts": impacts,
        "levels": levels.round(7).tolist(),
        "gains": gains,
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
        values[name] = digest(name, scene)
        haptic_tracing.unregister()
        print(f"{name}: {len(values[name]['impacts'])} impacts, frames {', '.join(values[name]['gains'])}", file=sys.stderr)
    lines = [f' "{name}": {json.dumps(value)}' for name, value in values.items()]
    STORED.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    store()
