"""Draws the small pictures of samples, materials and signals in menus: ``python
docs/pictures/draw_thumbnails.py``, with bpy 5.2, Pillow and the package installed. Takes a minute.

A sample is its scene in the liveliest frame of its first two seconds; a material the gain over two
metres of it, at 100 Hz, 40 dB high; a signal its first tenth of a second.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from unittest import mock

import bpy
import haptic_tracing
import numpy as np
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.addon.view import overlay
from haptic_tracing.addon.view.colour_map import AmplitudeScale
from haptic_tracing.command_line.playing import play
from haptic_tracing.core.scene.functions import HapticTracing
from haptic_tracing.core.scene.materials import MATERIALS
from haptic_tracing.core.signals import Noise, Pulse, Sine
from haptic_tracing.pictures import picture
from haptic_tracing.pictures.shown import shown_options
from haptic_tracing.sample_scenes import SAMPLES, build_sample
from PIL import Image

FOLDER = Path(__file__).parents[2] / "addon" / "thumbnails"
SIZE, SMALL = 128, 64
BACKGROUND = (38, 39, 43)
SIGNALS = {"SINE": Sine(60.0), "PULSE": Pulse(45.0), "NOISE": Noise()}


def keep(kind: str, name: str, pixels: np.ndarray) -> None:
    Image.fromarray(pixels).quantize(96).save(FOLDER / f"{kind}-{name}.png", optimize=True)


def sample(name: str) -> np.ndarray:
    scene = build_sample(name)
    bpy.context.window.scene = scene
    result = play(
        scene, scene.frame_start, min(scene.frame_end, scene.frame_start + 2 * scene.render.fps)
    ).liveliest
    scene.frame_set(result.number)
    with suspended(), mock.patch.object(overlay, "draw_annotations"):
        wide = picture.viewport_picture(scene, result, (4 * SIZE, 3 * SIZE), shown_options(scene))
    return np.asarray(
        Image.fromarray(wide[:, SIZE // 2 : 7 * SIZE // 2]).resize(
            (SIZE, SIZE), Image.Resampling.LANCZOS
        )
    )


def columns(low: np.ndarray, high: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """A picture of columns (SMALL,), each from ``low`` to ``high`` (0 to 1, upwards) in its
    ``colour`` (SMALL, 3), edges smoothed."""
    rows = 1 - (np.arange(4 * SMALL) + 0.5) / (4 * SMALL)
    cover = (
        ((rows[:, None] >= low) & (rows[:, None] <= high))
        .reshape(SMALL, 4, SMALL)
        .mean(axis=1)[..., None]
    )
    return np.rint(cover * colour * 255 + (1 - cover) * np.array(BACKGROUND)).astype(np.uint8)


def material(name: str) -> np.ndarray:
    own = MATERIALS[name]
    distance = np.linspace(0, 2, SMALL)
    gain = HapticTracing().gain(distance, own.kappa, own.rho, 0.1) * np.exp(
        -own.absorption * distance
    )
    scale = AmplitudeScale(-40.0)
    return columns(np.zeros(SMALL), 0.04 + 0.9 * scale.place(gain), scale.colour(gain))


def signal(kind: str) -> np.ndarray:
    samples = SIGNALS[kind].sample(0, 800, 8000.0)
    edges = np.linspace(0, len(samples) - 1, SMALL + 1).astype(int)
    low, high = (
        np.array([way(samples[a : b + 1]) for a, b in pairwise(edges)]) for way in (np.min, np.max)
    )
    return columns(
        0.48 + 0.42 * low,
        0.52 + 0.42 * high,
        np.full((SMALL, 3), AmplitudeScale(-60.0).colour(np.array(0.05))),
    )


def main() -> None:
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    haptic_tracing.register()
    if not picture.starts_gpu():
        raise SystemExit(
            "nothing can be drawn off-screen here: this needs bpy 5.2 and Mesa (libegl1, "
            "libgl1-mesa-dri)"
        )
    FOLDER.mkdir(exist_ok=True)
    for name in MATERIALS:
        keep("material", name, material(name))
    for kind in SIGNALS:
        keep("signal", kind, signal(kind))
    for name in SAMPLES:
        keep("sample", name, sample(name))
    haptic_tracing.unregister()


if __name__ == "__main__":
    main()
