"""Wooden crates."""

from __future__ import annotations

from bpy.types import Material

from .geometry import Geometry, box, joined
from .materials import surface


def crate_shape(edge: float) -> Geometry:
    """Boards behind a frame along all twelve edges of a cube about the origin."""
    bar = 0.11 * edge
    inset = 0.03 * edge
    frame = []
    for axis in range(3):
        for a in (-1, 1):
            for b in (-1, 1):
                size, centre = [bar] * 3, [0.0] * 3
                size[axis] = edge
                centre[(axis + 1) % 3] = a * (edge - bar) / 2
                centre[(axis + 2) % 3] = b * (edge - bar) / 2
                frame.append(box((size[0], size[1], size[2]), 0.008).moved(*centre).painted(1))
    return joined([box((edge - 2 * inset, edge - 2 * inset, edge - 2 * inset)), *frame])


def crate_materials() -> tuple[Material, Material]:
    """Of the boards and of the frame."""
    return surface("Crate Board", "#c99a5b", 0.7, mottle=0.3, mottle_scale=8.0), surface(
        "Crate Frame", "#9a6a36", 0.7
    )
