"""The ten actuators on a figure seen from behind, as SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from ..addon.view.colour_map import colour_table
from ..core.arrays import FloatArray

FLOOR = -46.0
"""Decibels of full scale at the dark end of the colours."""

PLACES: Mapping[str, tuple[float, float, float]] = {
    "ear": (11.5, 15.0, 5.0),
    "upper_back": (10.5, 42.0, 7.5),
    "middle_back": (9.5, 60.0, 7.5),
    "hand": (31.0, 81.0, 6.5),
    "upper_leg": (9.5, 92.0, 7.5),
}
"""By part, without its side: distance from the midline, height from above, radius, in a picture of
100 x 128."""

_FIGURE = (
    '<circle cx="50" cy="15" r="11"/><path d="M50 24V34"/>'
    '<path class="trunk" d="M33 34Q50 28 67 34L64 76Q50 82 36 76Z"/>'
    '<path class="limb" d="M32 38L24 60L19 80M68 38L76 60L81 80"/><path class="leg" d="M41 '
    '78V122M59 78V122"/>'
)


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
    """An SVG element with a disc per listener that has a place on the map, coloured by ``level``
    (l,)."""
    colours = shades()
    numbers = np.zeros(len(listeners), dtype=np.uint8) if level is None else shade_numbers(level)
    discs = []
    for listener, number in zip(listeners, numbers, strict=True):
        part, _, side = listener.partition(".")
        if part not in PLACES:
            continue
        reach, y, radius = PLACES[part]
        x = 50 + (reach if side == "R" else -reach)
        title = escape(listener.replace("_", " "))
        discs.append(
            f'<circle class="disc" cx="{x:g}" cy="{y:g}" r="{radius:g}" '
            f'fill="{colours[number]}"><title>{title}</title></circle>'
        )
    return (
        '<svg class="body" viewBox="0 0 100 128" role="img"><g '
        f'class="figure">{_FIGURE}</g>{"".join(discs)}</svg>'
    )
