"""Draws the pictures of the extension's page at extensions.blender.org into ``listing``: ``python
docs/pictures/draw_listing.py``, with bpy 5.2, Pillow and the package.

``icon.png`` (256 x 256), ``featured.webp`` and a picture of each sample (1920 x 1080).
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy
from haptic_tracing.addon.changes.suspension import suspended
from haptic_tracing.command_line.playing import play
from haptic_tracing.command_line.trace import start_blender
from haptic_tracing.pictures.picture import draw_picture
from haptic_tracing.sample_scenes import build_sample
from PIL import Image, ImageDraw

FOLDER = Path(__file__).parent / "listing"
SIZE = (1920, 1080)
SHOWN = {"featured": "jackhammer_bench", "pile": "pile", "fireplace": "fireplace"}
"""Names of the pictures, and of the sample scene in each."""
LAST = 48
"""Frames that are played of each scene; the liveliest one is shown."""
COLOURS = ("#fde725", "#5ec962", "#21918c", "#3b528b")
"""Of the amplitude from source to listener, as in the overlay."""


def draw_icon(path: Path) -> None:
    """A source and what it reaches through touching objects, ever more faintly."""
    scale = 4
    picture = Image.new("RGBA", (256 * scale, 256 * scale))
    draw = ImageDraw.Draw(picture)
    draw.rounded_rectangle((0, 0, 256 * scale, 256 * scale), 48 * scale, fill="#20242a")
    x, y, radius = 66, 82, 46
    for colour in COLOURS:
        box = [scale * value for value in (x - radius, y - radius, x + radius, y + radius)]
        draw.ellipse(box, fill=colour)
        shrunk = 0.74 * radius
        x, y, radius = x + 0.8 * (radius + shrunk), y + 0.6 * (radius + shrunk), shrunk
    picture.resize((256, 256), Image.Resampling.LANCZOS).save(path, optimize=True)


def main() -> None:
    FOLDER.mkdir(exist_ok=True)
    draw_icon(FOLDER / "icon.png")
    start_blender()
    for name, sample in SHOWN.items():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        build_sample(sample)
        scene = bpy.context.scene
        last = min(scene.frame_end, scene.frame_start + LAST - 1)
        result = play(scene, scene.frame_start, last).liveliest
        with tempfile.TemporaryDirectory() as folder, suspended():
            path = Path(folder, "picture.png")
            scene.frame_set(result.number)
            draw_picture(scene, result, path, SIZE, meters=True)
            with Image.open(path) as picture:
                picture.convert("RGB").save(FOLDER / f"{name}.webp", quality=85, method=6)
        print(f"wrote {FOLDER / name}.webp", flush=True)


if __name__ == "__main__":
    main()
