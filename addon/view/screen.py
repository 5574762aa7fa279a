"""Shapes and texts in the pixels of a viewport, on the GPU; a texture atlas holds all texts, so
that they take a single draw call and Blender draws a text only once. What is uploaded is kept
between redraws."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import blf
import gpu
import numpy as np
from gpu.types import GPUBatch, GPUFrameBuffer, GPUTexture
from mathutils import Matrix

from . import shader
from .hud import Hud, Text
from .quads import quads_of
from .render_data import Lines, Shape, lines_of

SIZE = (2048, 1024)
_PAD = 2  # pixels around a text
_ABOVE, _BELOW = 1.0, 0.35  # of the size, over and under the baseline


class Recent(dict[Any, Any]):
    """The last few values by key; ``most``: their number."""

    def __init__(self, most: int = 16) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Any, value: Any) -> None:
        super().__setitem__(key, value)
        while len(self) > self._most:
            del self[next(iter(self))]


def uploaded(items: Hud) -> GPUBatch | None:
    """Plates, symbols and texts on the GPU; None if there are none."""
    return shader.upload(quads_of((items.lines, ATLAS.lines(items.texts)), items.points))


def draw_flat(batch: Any, size: tuple[float, float], scale: float) -> None:
    """One draw call in pixels of a viewport of ``size``; ``batch`` may be None."""
    if batch is None:
        return
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_test_set("NONE")
    shader.draw(batch, pixels_to_clip(size), size, pixels_per_point=scale, texts=ATLAS.texture)
    gpu.state.blend_set("NONE")


@dataclass(slots=True)
class TextAtlas:
    """Texts by their words and size. ``generation``: number of times it was cleared; batches of
    another generation are invalid."""

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
        """Texts as shapes for the shader; missing ones are drawn into the texture, which is cleared
        first if it is full."""
        if not self._add(texts):
            self.clear()
            self._add(texts)
        cells = [
            (text, self._cells[text.words, text.size])
            for text in texts
            if (text.words, text.size) in self._cells
        ]
        position = np.zeros((len(cells), 2, 3), dtype=np.float32)
        colour = np.ones((len(cells), 2, 4), dtype=np.float32)
        for k, (text, (left, bottom, width, height)) in enumerate(cells):
            corner = round(text.position[0]) - _PAD, round(text.position[1]) - _below(text.size)
            position[k, :, :2] = corner, (corner[0] + width, corner[1] + height)
            colour[k, 0, :3] = text.colour
            colour[k, 1] = (
                left / SIZE[0],
                bottom / SIZE[1],
                (left + width) / SIZE[0],
                (bottom + height) / SIZE[1],
            )
        return lines_of(position, colour[..., :3], colour[..., 3], 0.0, shape=Shape.TEXT)

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
        # Not a GPUOffScreen: making one inside a draw handler takes the viewport's own frame buffer
        # away.
        if self._surface is None:
            self._texture = GPUTexture(SIZE, format="RGBA8")
            self._surface = GPUFrameBuffer(color_slots=self._texture)
            with self._surface.bind():
                self._surface.clear(color=(0.0, 0.0, 0.0, 0.0))
        return self._surface

    def _add(self, texts: Iterable[Text]) -> bool:
        """Draw missing texts. Returns False if they do not all fit."""
        missing = dict.fromkeys(
            (text.words, text.size) for text in texts if (text.words, text.size) not in self._cells
        )
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


ATLAS = TextAtlas()
"""All texts that are drawn over viewports."""


def _below(size: float) -> int:
    return math.ceil(_BELOW * size) + _PAD


def pixels_to_clip(size: tuple[float, float]) -> Matrix:
    """From pixels of a viewport to clip space."""
    return Matrix(((2 / size[0], 0, 0, -1), (0, 2 / size[1], 0, -1), (0, 0, 1, 0), (0, 0, 0, 1)))
