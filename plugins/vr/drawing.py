"""The hands over the 3D viewport."""

from __future__ import annotations

from ...addon.view import touching_shape
from . import controllers
from .hands import SHAPE

_WIDTH = 2.0  # pixels
_AT_REST = (0.2, 0.9, 1.0)
_FULL = (1.0, 0.6, 0.1)


def draw() -> None:
    """Draw callback: the edges of the hands, the more orange the more they feel."""
    hands = controllers.hands()
    if hands is None or hands.felt is None:
        return
    for transform, level in zip(hands.felt.transforms, hands.felt.levels.tolist(), strict=True):
        share = min(level, 1.0) ** 0.5
        red, green, blue = (
            rest + share * (full - rest) for rest, full in zip(_AT_REST, _FULL, strict=True)
        )
        touching_shape.draw_edges(SHAPE, transform, (red, green, blue, 0.9), _WIDTH, False)
