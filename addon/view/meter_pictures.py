"""The scope and the body map as pictures in the panel, with the numbers and colours of the meters
in the viewport."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...core.arrays import FloatArray
from ...core.scene.body_map import HALF_WIDTH, HEIGHT, figure
from .levels import Level
from .meter_layout import SCOPE_COLOUR, VIEWS, Scope, colour_of, full_scale, spans
from .panel_picture import SIZE, Colour, Picture, Pixels, blank, tint

_MARGIN = 6
_FAINT = 0.22
_UNIT = (SIZE - 2 * _MARGIN) / (4 * HALF_WIDTH)  # pixels: both figures side by side

_scope, _body = Picture(), Picture()


def scope_icon(scope: Scope, ink: Colour) -> int:
    """The identifier of the icon with the scope."""
    return _scope.icon(
        (scope.samples.tobytes(), scope.sample_rate, ink), lambda: scope_picture(scope, ink)
    )


def body_icon(levels: Sequence[Level], ink: Colour) -> int:
    """The identifier of the icon with the body."""
    parts = {level.body_part: colour_of(level)[:3] for level in levels if level.body_part}
    return _body.icon((tuple(parts.items()), ink), lambda: body_picture(parts, ink))


def scope_picture(scope: Scope, ink: Colour) -> Pixels:
    """The last second as pixels (SIZE, SIZE, 4), the latest at the right: for every column the
    range between its lowest and highest sample. Lines at quarters of the second and at silence."""
    pixels = blank()
    inside = slice(_MARGIN, SIZE - _MARGIN)
    middle, half = SIZE // 2, SIZE / 2 - _MARGIN
    for part in np.linspace(_MARGIN, SIZE - _MARGIN - 1, 5).round().astype(int).tolist():
        tint(pixels[inside, part], ink, 0.2)
    tint(pixels[middle, inside], ink, 0.5)
    columns, least, greatest = spans(scope, SIZE - 2 * _MARGIN)
    full = full_scale(scope)
    rows = np.arange(SIZE)[:, None]
    below, above = middle + half / full * least - rows, rows - middle - half / full * greatest
    chosen = pixels[:, _MARGIN + columns]
    tint(chosen, wave_colour(ink), np.clip(1.8 - np.maximum(below, above), 0.0, 1.0))
    pixels[:, _MARGIN + columns] = chosen
    return pixels


def wave_colour(ink: Colour) -> Colour:
    """The colour of the scope in the viewport, darker on a light theme."""
    red, green, blue = (part * (1.0 if sum(ink) > 1.5 else 0.55) for part in SCOPE_COLOUR[:3])
    return red, green, blue


def body_picture(parts: Mapping[str, Sequence[float]], ink: Colour) -> Pixels:
    """Two figures as pixels (SIZE, SIZE, 4), from the front and from behind: ``parts`` in their
    colours, all others faint."""
    names, number, cover = _limbs()
    colour = np.array(
        [(*parts[name], 1.0) if name in parts else (*ink, _FAINT) for name in names],
        dtype=np.float32,
    )
    opacity = cover * colour[number, 3]
    return np.concatenate(
        [colour[number, :3] * opacity[..., None], opacity[..., None]], axis=2
    ).astype(np.float32)


@cache
def _limbs() -> tuple[tuple[str, ...], NDArray[np.intp], FloatArray]:
    """The body part of each limb; for each pixel the nearest limb and its coverage of the pixel, 0
    to 1."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5
    bottom = (SIZE - HEIGHT * _UNIT) / 2
    names, distances = [], []
    for place, view in enumerate(VIEWS):
        middle = _MARGIN + (2 * place + 1) * HALF_WIDTH * _UNIT
        for limb in figure(view):
            start, end = (
                np.array((middle + at[0] * _UNIT, bottom + at[1] * _UNIT))
                for at in (limb.start, limb.end)
            )
            along = end - start
            part = np.clip(
                ((x - start[0]) * along[0] + (y - start[1]) * along[1])
                / max(float(along @ along), 1e-12),
                0,
                1,
            )
            distances.append(
                np.hypot(x - start[0] - part * along[0], y - start[1] - part * along[1])
                - limb.width * _UNIT / 2
            )
            names.append(limb.part)
    every = np.array(distances)
    return tuple(names), every.argmin(axis=0), np.clip(0.5 - every.min(axis=0), 0, 1)
