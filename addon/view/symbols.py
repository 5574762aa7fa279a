"""The symbols of contacts, sources, listeners and impacts, as shader, meshes and painter draw
them."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum

import numpy as np

from ...core.arrays import FloatArray
from ...core.frozen import frozen
from .colour_map import hex_colour

HALO_COLOUR = hex_colour("#101012")
LIGHT_COLOUR = hex_colour("#f7f7f7")


class Symbol(IntEnum):
    """The form of a point or line, see `shader`."""

    LINE = 0
    CONTACT = 1
    SOURCE = 2
    LISTENER = 3
    IMPACT = 4
    PLATE = 5


@frozen(eq=False)
class Look:
    """How a symbol looks.

    Attributes:
        size: diameter in pixels at a user interface scale of 1.
        layers: from the outside in: inset [pixels], colour (None: that of the point) and opacity.
        distance: function in ``quads.frag.glsl`` that is the distance to its outline.
        radius: of that outline at angles [rad], where that of the symbol is 1.
        corners: number of them in a mesh.
    """

    size: float
    layers: tuple[tuple[float, FloatArray | None, float], ...]
    distance: str
    radius: Callable[[FloatArray], FloatArray]
    corners: int

    def coloured(self, colour: FloatArray) -> list[tuple[float, FloatArray, float]]:
        """The layers of a symbol of this ``colour``."""
        return [
            (inset, colour if own is None else own, opacity) for inset, own, opacity in self.layers
        ]

    def ring(self) -> FloatArray:
        """The corners (n, 2), counterclockwise."""
        angle = np.linspace(0, 2 * np.pi, self.corners, endpoint=False)
        return self.radius(angle)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def _diamond(angle: FloatArray) -> FloatArray:
    """A square on its corner."""
    return np.asarray(0.871126 / (np.abs(np.cos(angle)) + np.abs(np.sin(angle))))


def _burst(angle: FloatArray) -> FloatArray:
    """Eight rays."""
    return np.asarray(0.55 + 0.9 * np.abs(angle * 8 / (2 * np.pi) % 1 - 0.5))


LOOKS = {
    Symbol.CONTACT: Look(
        9.0, ((0.0, HALO_COLOUR, 0.9), (1.3, None, 1.0)), "disc", np.ones_like, 16
    ),
    Symbol.LISTENER: Look(
        21.0,
        ((0.0, HALO_COLOUR, 0.92), (1.9, LIGHT_COLOUR, 1.0), (4.7, None, 1.0)),
        "diamond",
        _diamond,
        4,
    ),
    Symbol.SOURCE: Look(
        26.0,
        (
            (0.0, HALO_COLOUR, 0.92),
            (1.5, None, 1.0),
            (3.7, HALO_COLOUR, 1.0),
            (5.4, LIGHT_COLOUR, 1.0),
            (7.0, None, 1.0),
        ),
        "disc",
        np.ones_like,
        48,
    ),
    Symbol.IMPACT: Look(
        22.0,
        ((0.0, HALO_COLOUR, 0.92), (1.8, LIGHT_COLOUR, 1.0), (4.0, None, 1.0)),
        "burst",
        _burst,
        48,
    ),
}
"""From those that lie lowest on."""
