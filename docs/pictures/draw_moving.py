"""Draws the demo as a moving picture, ``moving.webp``: ``python docs/pictures/draw_moving.py``,
with bpy 5.2, Pillow and the package.

The five seconds of the jackhammer beside the bench with graph and meters, twelve frames a second,
over and over.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.session import timeline
from haptic_tracing.command_line.trace import start_blender
from haptic_tracing.pictures.picture import draw_picture
from haptic_tracing.sample_scenes import build_sample
from PIL import Image

FOLDER = Path(__file__).parent
EVERY = 2
"""Frames of the scene from one picture to the next."""
MOST_BYTES = 2_000_000


def main() -> None:
    start_blender()
    build_sample("jackhammer_bench")
    scene = bpy.context.scene
    steps = timeline.steps(scene, scene.frame_start, scene.frame_end)
    shown = [step.result for k, step in enumerate(steps) if k % EVERY == 0]
    pictures = []
    with tempfile.TemporaryDirectory() as name:
        for result in shown:
            path = Path(name, "frame.png")
            with suspended():
                scene.frame_set(result.number)
                draw_picture(scene, result, path, meters=True)
            with Image.open(path) as picture:
                pictures.append(picture.convert("RGB"))
    moving = FOLDER / "moving.webp"
    pictures[0].save(
        moving,
        save_all=True,
        append_images=pictures[1:],
        duration=round(1000 * EVERY / scene.render.fps),
        loop=0,
        quality=70,
        method=6,
    )
    size = moving.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(f"{moving}: has {size:,} bytes, more than {MOST_BYTES:,}")
    print(f"wrote {moving}: {len(pictures)} frames, {size:,} bytes")


if __name__ == "__main__":
    main()
