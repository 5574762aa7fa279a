"""Shapes and texts in the pixels of a viewport: shapes on the GPU, kept between redraws, and texts
by Blender's own font."""

from __future__ import annotations

from typing import Any, NamedTuple

import blf
import bpy
import gpu
from gpu.types import GPUBatch
from mathutils import Matrix

from . import shader
from .hud import Hud, PlacedText
from .quads import quads_of
from .render_data import Size


class Recent(dict[Any, Any]):
    """The last few values by key; ``most``: their number."""

    def __init__(self, most: int = 16) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Any, value: Any) -> None:
        super().__setitem__(key, value)
        while len(self) > self._most:
            del self[next(iter(self))]


class Uploaded(NamedTuple):
    """Plates, lines and symbols on the GPU, None if there are none, and the texts over them."""

    batch: GPUBatch | None
    texts: tuple[PlacedText, ...]


def is_light() -> bool:
    """Whether the menus of the theme in use are light."""
    return sum(bpy.context.preferences.themes[0].user_interface.wcol_menu_back.inner[:3]) > 1.5


def in_theme(items: Hud) -> Hud:
    """For the theme in use."""
    return items.on_light() if is_light() else items


def uploaded(items: Hud) -> Uploaded:
    """Everything that is drawn over a viewport."""
    return Uploaded(shader.upload(quads_of(items.lines)), items.texts)


def draw_flat(shown: Uploaded, size: Size, scale: float) -> None:
    """Draw in pixels of a viewport of ``size``."""
    pixels = pixels_to_clip(size)
    gpu.state.depth_test_set("NONE")
    if shown.batch is not None:
        gpu.state.blend_set("ALPHA_PREMULT")
        shader.draw(shown.batch, pixels, size, pixels_per_point=scale)
        gpu.state.blend_set("NONE")
    with gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
        gpu.matrix.load_matrix(Matrix.Identity(4))
        gpu.matrix.load_projection_matrix(pixels)
        for text in shown.texts:
            blf.size(0, text.size)
            blf.color(0, *text.colour, 1.0)
            blf.position(0, round(text.position[0]), round(text.position[1]), 0.0)
            blf.draw(0, text.words)


def pixels_to_clip(size: Size) -> Matrix:
    """From pixels of a viewport to clip space."""
    return Matrix(((2 / size[0], 0, 0, -1), (0, 2 / size[1], 0, -1), (0, 0, 1, 0), (0, 0, 0, 1)))
