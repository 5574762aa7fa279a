"""Shapes and texts in the pixels of a viewport, on the GPU; a texture atlas holds all texts, so that they take a single draw call and
Blender draws a text only once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import blf
import gpu
import numpy as np
from gpu.types import GPUFrameBuffer, GPUTexture
from mathutils import Matrix

from . import shader
from .hud import Text
from .render_data import Lines, Shape

SIZE = (2048, 1024)
_PAD = 2  # pixels around a text
_ABOVE, _BELOW = 1.0, 0.35  # of the size, over and under the baseline


def draw_flat(batch: Any, size: tuple[float, float], scale: float) -> None:
    """One draw call in pixels of a viewport of ``size``; ``batch`` may be None."""
    if batch is None:
        return
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_test_set("NONE")
    shader.draw(batch, pixels_to_clip(size), size, pixels_per_point=scale, texts=shared_atlas().texture)
    gpu.state.blend_set("NONE")


@cache
def shared_atlas() -> TextAtlas:
    """The texture of all texts that are drawn over viewports."""
    return TextAtlas()


def free_texts() -> None:
    """Free the texture of texts."""
    if shared_atlas.cache_info().currsize:
        shared_atlas().free()


@dataclass(slots=True)
class TextAtlas:
    """Texts by their words and size. ``generation``: number of times it was cleared; batches of another generation are invalid."""

    generation: int = 0
    _texture: Any = None
    _surface: Any = None
    _cells: dict[tuple[str, float], tuple[int, int, int, int]] = field(default_factory=dict)
    _pen: tuple[int, int, int] = (0, 0, 0)  # left and bottom of the next cell, height of its row

    @property
    def texture(self) -> GPUTexture:
        """The coverage of all texts."""
        self._frame_buffer()
        return self._texture

    def lines(self, texts: Sequence[Text]) -> Lines:
        """Texts as shapes for the shader; missing ones are drawn into the texture, which is cleared first if it is full."""
        if not self._add(texts):
            self.clear()
            self._add(texts)
        cells = [(text, self._cells[text.words, text.size]) for text in texts if (text.words, text.size) in self._cells]
        position = np.zeros((len(cells), 2, 3), dtype=np.float32)
        colour = np.ones((len(cells), 2, 4), dtype=np.float32)
        for k, (text, (left, bottom, width, height)) in enumerate(cells):
            corner = round(text.position[0]) - _PAD, round(text.position[1]) - _below(text.size)
            position[k, :, :2] = corner, (corner[0] + width, corner[1] + height)
            colour[k, 0, :3] = text.colour
            colour[k, 1] = left / SIZE[0], bottom / SIZE[1], (left + width) / SIZE[0], (bottom + height) / SIZE[1]
        count = len(cells)
        return Lines(
            position, colour, np.zeros(count, dtype=np.float32), np.full((count, 2), -1, dtype=np.float32),
            np.full(count, Shape.TEXT, dtype=np.float32),
        )  # fmt: skip

    def clear(self) -> None:
        """Clear the atlas."""
        self._cells.clear()
        self._pen = (0, 0, 0)
        self.generation += 1
        if self._surface is not None:
            with self._surface.bind():
                self._surface.clear(color=(0.0, 0.0, 0.0, 0.0))

    def free(self) -> None:
        """Free the texture."""
        self._texture = self._surface = None
        self.clear()

    def _frame_buffer(self) -> GPUFrameBuffer:
        # Not a GPUOffScreen: making one inside a draw handler takes the viewport's own frame buffer away.
        if self._surface is None:
            self._texture = GPUTexture(SIZE, format="RGBA8")
            self._surface = GPUFrameBuffer(color_slots=self._texture)
            with self._surface.bind():
                self._surface.clear(color=(0.0, 0.0, 0.0, 0.0))
        return self._surface

    def _add(self, texts: Iterable[Text]) -> bool:
        """Draw missing texts. Returns False if they do not all fit."""
        missing = dict.fromkeys((text.words, text.size) for text in texts if (text.words, text.size) not in self._cells)
        if not missing:
            return True
        surface = self._frame_buffer()
        complete = True
        with surface.bind(), gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.matrix.load_matrix(Matrix.Identity(4))
            gpu.matrix.load_projection_matrix(pixels_to_clip(SIZE))
            blf.color(0, 1.0, 1.0, 1.0, 1.0)
            for words, size in missing:
                blf.size(0, size)
                cell = self._cell(math.ceil(blf.dimensions(0, words)[0]) + 2 * _PAD, size)
                if cell is None:
                    complete = False
                    continue
                self._cells[words, size] = cell
                blf.position(0, cell[0] + _PAD, cell[1] + _below(size), 0.0)
                blf.draw(0, words)
        return complete

    def _cell(self, width: int, size: float) -> tuple[int, int, int, int] | None:
        height = _below(size) + math.ceil(_ABOVE * size) + _PAD
        left, bottom, row = self._pen
        if left + width > SIZE[0]:
            left, bottom, row = 0, bottom + row, 0
        if width > SIZE[0] or bottom + height > SIZE[1]:
            return None
        self._pen = (left + width, bottom, max(row, height))
        return left, bottom, width, height


def _below(size: float) -> int:
    return math.ceil(_BELOW * size) + _PAD


def pixels_to_clip(size: tuple[float, float]) -> Matrix:
    """From pixels of a viewport to clip space."""
    return Matrix(((2 / size[0], 0, 0, -1), (0, 2 / size[1], 0, -1), (0, 0, 1, 0), (0, 0, 0, 1)))
