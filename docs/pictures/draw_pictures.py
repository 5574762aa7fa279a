"""Draws the pictures of the documentation: ``python docs/pictures/draw_pictures.py``, with bpy 5.2
and the package installed.

Takes a minute or two: one of them is rendered by Cycles.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.session import session
from haptic_tracing.command_line.playing import play
from haptic_tracing.pictures import cycles_picture, picture
from haptic_tracing.pictures.png import write_png
from haptic_tracing.pictures.shown import shown_options
from haptic_tracing.sample_scenes import build_sample

FOLDER = Path(__file__).parent
SIZE = (1280, 720)


def main() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    scene = build_sample("jackhammer_bench")
    bpy.context.window.scene = scene
    played = play(scene, scene.frame_start, scene.frame_end)
    result = played.liveliest
    scene.frame_set(result.number)
    if not picture.starts_gpu():
        raise SystemExit(
            "nothing can be drawn off-screen here: this needs bpy 5.2 and Mesa (libegl1, "
            "libgl1-mesa-dri)"
        )
    with suspended():
        everything = shown_options(scene)
        ear = replace(everything, listeners=frozenset({result.listeners[0].name}))
        write_png(
            FOLDER / "overlay.png", picture.viewport_picture(scene, result, SIZE, meters=True)
        )
        write_png(
            FOLDER / "overlay-selected-listener.png",
            picture.viewport_picture(scene, result, SIZE, ear),
        )
        session.of(scene).result = result
        bpy.ops.haptic.graph_to_geometry()
        pixels = cycles_picture.rendered(scene, SIZE, 48, denoise=True)[::-1, :, :3]
        write_png(FOLDER / "graph-to-geometry.png", np.rint(pixels * 255).astype(np.uint8))
    haptic_tracing.unregister()


if __name__ == "__main__":
    main()
