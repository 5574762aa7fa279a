"""What a step costs where little changes: boxes in rows that touch their neighbours and the ground,
of which none, one beside the best paths, one under a hand ("one, held") or all move a little; and
best paths between many sources and listeners.

    python -m benchmarks.bench_little_changes

Times are those of the processor, medians of a run's steps and the best of three propagations.
Objects are of the paper's function, or of concrete and wood. `graph` and `propagate` are stages of
the step, whose time is that which passed.
"""

from __future__ import annotations

import json
import math
import time
from typing import Any

import haptic_tracing as ht
import numpy as np
from haptic_tracing.core.contacts.contact_set import ContactSet
from haptic_tracing.core.graph.haptic_graph import HapticGraph, ObjectTable, build_graph
from haptic_tracing.core.propagation import propagate
from haptic_tracing.core.scene.functions import Exponential, HapticTracing, Identity, Spectrum
from haptic_tracing.core.scene.values import Contact, HapticObject, Listener, Settings, Source

from .report import publish, table
from .timing import best_run

COUNTS = (10, 100, 1024, 10_000)
STEPS, RATE = 24, 60
LISTENERS = 10
PAIRS = (10, 100, 1000)
BANDED = Exponential(alpha=0.3, spectrum=Spectrum(band_gains=(1.0, 0.9, 0.8, 0.7, 0.6, 0.5)))


def place(number: int, side: int) -> tuple[float, float, float]:
    """Where a box stands."""
    return float(number % side), float(number // side), 0.5


def scene_of(count: int, materials: bool) -> dict[str, Any]:
    """``count`` boxes in rows on a ground with a drill, some with hands on them."""
    side = math.isqrt(count)
    own = {"kappa": 0.1, "rho": 0.9}
    ground = {"material": "concrete"} if materials else {}
    wood = {"material": "wood"} if materials else {}
    objects: list[dict[str, Any]] = [
        {
            "name": "ground",
            **own,
            **ground,
            "motion": "static",
            "shape": {"type": "box", "size": [side + 10.0, side + 10.0, 1]},
            "pose": {"position": [side / 2, side / 2, -0.5]},
        }
    ]
    objects += [
        {
            "name": f"box {number}",
            **own,
            **wood,
            "mass": 5,
            "shape": {"type": "box", "size": [1, 1, 1]},
            "pose": {"position": place(number, side)},
        }
        for number in range(count)
    ]
    held = [k * count // LISTENERS for k in range(LISTENERS)]
    return {
        "format": "haptic-scene",
        "version": "1.1",
        "objects": objects,
        "sources": [{"name": "drill", "object": "ground", "position": [0, 0, 0]}],
        "listeners": [
            {"name": f"hand {k}", "object": f"box {k}", "position": place(k, side)} for k in held
        ],
    }


def steps(count: int, moving: int, materials: bool, is_held: bool = False) -> dict[str, float]:
    """Median milliseconds of a step, and of its stages. ``is_held``: a hand is on the one that
    moves."""
    run = ht.open(ht.loads(json.dumps(scene_of(count, materials))), sample_rate=8000)
    side = math.isqrt(count)
    first = 0 if moving == count else count // 2 + (0 if is_held else side // 2)
    spent: dict[str, list[float]] = {"step": [], "graph": [], "propagate": []}
    for step in range(STEPS + 3):
        height = 0.0005 * (1 + math.sin(step))
        poses = {}
        for number in range(first, first + moving):
            x, y, z = place(number, side)
            poses[f"box {number}"] = [x, y, z + height, 1, 0, 0, 0]
        begun = time.process_time()
        answer = run.step(step / RATE, poses)
        used = 1000 * (time.process_time() - begun)
        if step > 2:
            for stage, values in spent.items():
                values.append(used if stage == "step" else answer.milliseconds[stage])
    return {stage: float(np.median(values)) for stage, values in spent.items()}


def graph_of(count: int, banded: bool) -> HapticGraph:
    """``count`` bodies on a ground, each with a source and a listener."""
    random = np.random.default_rng(1)
    function = BANDED if banded else HapticTracing()
    spots = [tuple(spot) for spot in random.uniform(0, 30, (count, 3)).tolist()]
    names = [f"body {k}" for k in range(count)]
    objects = [HapticObject(name, 0.1, 0.9, function) for name in ("ground", *names)]
    ends = list(zip(names, spots, strict=True))
    numbered = ObjectTable.of(objects, 0.1)
    return build_graph(
        numbered,
        ContactSet.from_contacts(
            [Contact(("ground", name), (spot, spot), Identity()) for name, spot in ends],
            numbered.index(),
        ),
        [Source(f"source of {name}", name, (x, y, z + 0.1)) for name, (x, y, z) in ends],
        [Listener(f"hand on {name}", name, (x, y, z + 0.2)) for name, (x, y, z) in ends],
    )


def main() -> None:
    """Print and store both tables."""
    results: dict[str, Any] = {"steps": [], "pairs": []}
    for materials in (False, True):
        for count in COUNTS:
            for moving, is_held in ((0, False), (1, False), (1, True), (count, False)):
                found = steps(count, moving, materials, is_held)
                which = "one, held" if is_held else f"{moving:,}"
                results["steps"].append(
                    {"boxes": count, "moving": which, "materials": materials, **found}
                )
    for banded in (False, True):
        for count in PAIRS:
            graph = graph_of(count, banded)
            seconds, _ = best_run(propagate, graph, Settings(), runs=3)
            results["pairs"].append({"sources": count, "bands": banded, "seconds": seconds})
    rows = [
        [
            f"{row['boxes']:,}",
            row["moving"],
            "yes" if row["materials"] else "no",
            *(f"{row[stage]:.2f}" for stage in ("step", "graph", "propagate")),
        ]
        for row in results["steps"]
    ]
    heads = "boxes", "moving", "materials", "step [ms]", "graph [ms]", "propagate [ms]"
    pairs = [
        [
            f"{row['sources']:,} × {row['sources']:,}",
            "yes" if row["bands"] else "no",
            f"{1000 * row['seconds']:.1f}",
        ]
        for row in results["pairs"]
    ]
    text = f"{table(heads, rows)}\n\n{table(('sources × listeners', 'bands', 'ms'), pairs)}"
    publish("little_changes", "Where little changes", text, results)


if __name__ == "__main__":
    main()
