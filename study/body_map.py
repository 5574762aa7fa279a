"""The actuators on a figure seen from behind, as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ..addon.view.colour_map import colour_table
from ..core.arrays import FloatArray
from ..core.scene.body_map import figure
from .body_svg import BOX, line

FLOOR = -46.0
"""Decibels of full scale at the dark end of the colours."""


def shades() -> list[str]:
    """Colours from `FLOOR` to 0 dB, the first for silence."""
    table = np.round(255 * colour_table()[::4]).astype(int)
    return ["#2a2b31", *("#{:02x}{:02x}{:02x}".format(*row) for row in table)]


def shade_numbers(level: FloatArray) -> np.ndarray:
    """Which of the `shades` each level (any shape, 1: full scale) has."""
    last = len(shades()) - 1
    decibels = 20 * np.log10(np.maximum(level, 1e-9))
    steps = 1 + np.floor((decibels - FLOOR) / -FLOOR * (last - 1) + 0.5)
    return np.where(decibels < FLOOR, 0, np.clip(steps, 1, last)).astype(np.uint8)


def body_map(listeners: Sequence[str], level: FloatArray | None = None) -> str:
    """An SVG element of the body from behind with a stroke per listener that has a place on it,
    coloured by ``level`` (l,)."""
    colours, limbs = shades(), {limb.part: limb for limb in figure("back")}
    numbers = np.zeros(len(listeners), dtype=np.uint8) if level is None else shade_numbers(level)
    strokes = [line(limb, 'class="limb"') for part, limb in limbs.items() if part not in listeners]
    for listener, number in zip(listeners, numbers, strict=True):
        if listener in limbs:
            title = f"<title>{escape(listener.replace('_', ' '))}</title>"
            strokes.append(line(limbs[listener], f'class="disc" stroke="{colours[number]}"', title))
    return f'<svg class="body" viewBox="{BOX}" role="img">{"".join(strokes)}</svg>'
