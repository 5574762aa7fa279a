"""Duration of a redraw of the timeline of touch, the lane over Timeline and Dope Sheet.

    python -m benchmarks.bench_lane [--frames 3600] [--listeners 10] [--redraws 200]

Frames are 24 a second; listeners feel noise, and every tenth frame has an impact. The region has
1600 x 400 pixels and shows all frames, a hundred of them, or one. `nothing changed` is a redraw by
itself, `view moves` one that shows other frames than the one before, `next frame` one after a frame
that was played, as an unbaked scene has them. Milliseconds of processor time of the main thread,
without the graphics driver. The waves of a baked track are computed once, on the worker.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from types import SimpleNamespace
from typing import cast
from unittest import mock

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.core.render.integers import FULL_SCALE
from haptic_tracing.pictures import picture
from haptic_tracing.plugins.timeline import lane
from haptic_tracing.plugins.timeline.waves import Waves

from .report import publish, table

GOAL = 4.0
SIZE = (1600, 400)
RATE, FRAMES_PER_SECOND = 8000, 24
SHOWN = (("all", None), ("100 frames", 100.0), ("1 frame", 1.0))
CHANGES = ("nothing changed", "view moves", "next frame")


@dataclass(frozen=True, slots=True)
class Row:
    """One way of redrawing. Milliseconds: median and 95 %."""

    shown: str
    change: str
    median: float
    high: float


def noise(frames: int, listeners: int) -> tuple[Waves, float]:
    """The waves of a scene, and how long the worker takes for them [s]."""
    random = np.random.default_rng(1)
    samples = np.rint(
        random.normal(0, 0.1 * FULL_SCALE, (listeners, frames * RATE // FRAMES_PER_SECOND))
    ).astype(np.int16)
    started = time.process_time()
    waves = Waves(
        [f"listener {k}" for k in range(listeners)],
        1.0,
        RATE / FRAMES_PER_SECOND,
        samples,
        filled=True,
    )
    waves.find_levels(RATE)
    waves.add_impacts(
        np.arange(5.0, frames, 10.0),
        random.uniform(0.01, 1, (len(np.arange(5.0, frames, 10.0)), listeners)),
    )
    return waves, time.process_time() - started


def rows(waves: Waves, redraws: int) -> Iterator[Row]:
    """Every change of every view."""
    from gpu.types import GPUOffScreen

    block = np.random.default_rng(2).normal(
        0, 0.1, (len(waves.listeners), RATE // FRAMES_PER_SECOND)
    )
    system, themes = SimpleNamespace(ui_scale=1.0), bpy.context.preferences.themes
    context = SimpleNamespace(preferences=SimpleNamespace(system=system, themes=themes))
    buffer = GPUOffScreen(*SIZE)
    with (
        buffer.bind(),
        mock.patch.object(lane, "draw_flat"),
        mock.patch.object(lane, "watched", lambda scene: waves.listeners[0]),
        mock.patch.object(lane, "active_name", lambda: ""),
    ):
        for title, frames in SHOWN:
            wide = frames or float(len(waves.filled))
            for change in CHANGES:
                spent = []
                for number in range(redraws + 5):
                    left = 1.0 + 0.01 * wide * number if change == "view moves" else 1.0
                    edges = {0: (left, 0), SIZE[0]: (left + wide, 0)}
                    view = SimpleNamespace(region_to_view=lambda x, y, edges=edges: edges[x])
                    context.region = SimpleNamespace(
                        width=SIZE[0], height=SIZE[1], view2d=view, as_pointer=lambda: 1
                    )
                    if change == "next frame":
                        still = np.zeros(len(block))
                        waves.write(number * block.shape[1], block, still, still)
                    started = time.thread_time()
                    lane._draw_lane(
                        cast(bpy.types.Context, context),
                        bpy.context.scene,
                        (waves,),
                        number if change == "next frame" else 0,
                    )
                    spent.append(1000 * (time.thread_time() - started))
                yield Row(title, change, *np.percentile(spent[5:], (50, 95)).tolist())
    buffer.free()


def main() -> None:
    """Print the table and keep it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=3600)
    parser.add_argument("--listeners", type=int, default=10)
    parser.add_argument("--redraws", type=int, default=200)
    options = parser.parse_args()
    haptic_tracing.register()
    if not picture.starts_gpu():
        raise SystemExit("this Blender can't draw off-screen: 5.2 or later with EGL is needed")
    waves, seconds = noise(options.frames, options.listeners)
    found = list(rows(waves, options.redraws))
    haptic_tracing.unregister()
    text = table(
        ("shown", "redraw", "median ms", "95 % ms"),
        [(r.shown, r.change, f"{r.median:.2f}", f"{r.high:.2f}") for r in found],
    )
    size = f"{options.frames} frames, {options.listeners} listeners"
    words = f"{size}. The worker computes the waves of a track of that size in {seconds:.2f} s. "
    publish(
        "lane",
        "A redraw of the timeline of touch",
        f"{words}The goal is {GOAL:g} ms.\n\n{text}",
        [asdict(row) for row in found],
    )


if __name__ == "__main__":
    main()
