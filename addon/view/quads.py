"""Lines and points as quads that the shader turns to the viewer, in one vertex array.

Every line or point is four vertices, each with all attributes and its corner. A point is a line of
length 0, so that lines of any width, points of any shape and their order take a single draw call.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...core.frozen import frozen
from .render_data import Drawn, Lines, Points, RenderData, halos, joined

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
    return quads_of((data.tree, data.highlight, halos(data.paths), data.paths), data.points)


def quads_of(lines: Sequence[Lines], points: Points) -> Quads:
    """Lines first, points over them."""
    every = joined(lines)
    count = len(every.width) + len(points.size)
    per_quad = {
        "start": np.concatenate([every.position[:, 0], points.position]),
        "end": np.concatenate([every.position[:, 1], points.position]),
        "colour_start": np.concatenate([every.colour[:, 0], points.colour]),
        "colour_end": np.concatenate([every.colour[:, 1], points.colour]),
        "arc_length": np.concatenate(
            [every.arc_length, np.full((len(points.size), 2), -1, dtype=np.float32)]
        ),
    }
    attributes = {name: np.repeat(values, 4, axis=0) for name, values in per_quad.items()}
    style = np.empty((count, 4, 4), dtype=np.float32)
    style[:, :, 0] = np.concatenate([every.width, points.size])[:, None]
    style[:, :, 1] = np.concatenate([every.shape, points.shape])[:, None]
    style[:, :, 2:] = CORNERS
    attributes["style"] = style.reshape(-1, 4)
    corners = np.array([(0, 1, 2), (0, 2, 3)], dtype=np.uint32)
    triangles = (4 * np.arange(count, dtype=np.uint32)[:, None, None] + corners).reshape(-1, 3)
    return Quads(attributes, triangles)
