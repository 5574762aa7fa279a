"""Lines and points as quads that the shader turns to the viewer, in one vertex array.

Every line or point is four vertices, each with all attributes and its corner. A point is a line of
length 0, so that lines of any width, points of any shape and their order take a single draw call.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...core.frozen import frozen
from .render_data import Drawn, Lines, RenderData, halos, joined

CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=np.float32)
ATTRIBUTES = (
    ("start", 3),
    ("end", 3),
    ("colour_start", 4),
    ("colour_end", 4),
    ("style", 4),
    ("arc_length", 2),
)
"""``style``: width [pixels], shape, and the corner: -1 or 1 along and across the line."""


@frozen
class Quads:
    """``attributes`` by name, (4 n, k) each; ``triangles`` (2 n, 3)."""

    attributes: dict[str, Drawn]
    triangles: NDArray[np.uint32]

    @property
    def count(self) -> int:
        """Number of quads."""
        return len(self.triangles) // 2


def quads(data: RenderData) -> Quads:
    """The graph of a frame, in the order in which it is painted."""
    return quads_of(joined(data.tree, data.highlight, halos(data.paths), data.paths, data.points))


def quads_of(lines: Lines) -> Quads:
    """Lines and points in their order."""
    count = len(lines.width)
    per_quad = {
        "start": lines.position[:, 0],
        "end": lines.position[:, 1],
        "colour_start": lines.colour[:, 0],
        "colour_end": lines.colour[:, 1],
        "arc_length": lines.arc_length,
    }
    attributes = {name: np.repeat(values, 4, axis=0) for name, values in per_quad.items()}
    style = np.empty((count, 4, 4), dtype=np.float32)
    style[:, :, 0] = lines.width[:, None]
    style[:, :, 1] = lines.shape[:, None]
    style[:, :, 2:] = CORNERS
    attributes["style"] = style.reshape(-1, 4)
    corners = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32)
    triangles = (4 * np.arange(count, dtype=np.uint32)[:, None, None] + corners).reshape(-1, 3)
    return Quads(attributes, triangles)
