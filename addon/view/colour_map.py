"""A perceptually uniform colour map for amplitudes, and its scale in decibels.

Lightness rises evenly from blue-violet to yellow, so that the order of amplitudes is seen by
colour-blind people and in grey print. The hues are those of viridis, by Stéfan van der Walt and
Nathaniel Smith for matplotlib, dedicated to the public domain (CC0); they start lighter, because
the viewport is dark. Colours are interpolated in Oklab (Björn Ottosson, "A perceptual color space
for image processing", 2020); `tests/references/oklab.py` computes the table.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np

from ...core.arrays import FloatArray
from ...core.frozen import frozen

STEPS = 256


def linear(srgb: FloatArray) -> FloatArray:
    """Display values (sRGB, 0 to 1) as linear light (IEC 61966-2-1)."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def hex_colour(code: str) -> FloatArray:
    """``#rrggbb`` as display values (3,)."""
    return np.array([int(code[i : i + 2], 16) / 255 for i in (1, 3, 5)])


@cache
def colour_table() -> FloatArray:
    """(256, 3) display values, of `colours.json`: at even distances along the line in Oklab."""
    table = np.array(json.loads(Path(__file__).with_name("colours.json").read_text("utf-8")))
    table.setflags(write=False)
    return table


def decibels(amplitude: FloatArray) -> FloatArray:
    """20 log10 of amplitudes; minus infinity for 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(20 * np.log10(amplitude))


@frozen
class AmplitudeScale:
    """Colours from ``floor`` [dB, negative] to 0 dB; weaker amplitudes have the first colour,
    stronger ones the last."""

    floor: float = -60.0

    def place(self, amplitude: FloatArray) -> FloatArray:
        """Place of amplitudes on the scale, 0 to 1."""
        return np.clip(1 - decibels(np.maximum(amplitude, 1e-300)) / self.floor, 0.0, 1.0)

    def colour(self, amplitude: FloatArray) -> FloatArray:
        """(..., 3) display values of amplitudes."""
        return colour_table()[np.rint(self.place(amplitude) * (STEPS - 1)).astype(np.int64)]

    def ticks(self) -> tuple[int, ...]:
        """Round values in dB for a legend, 3 to 7 of them, ascending to 0."""
        step = next(s for s in (2, 5, 10, 20) if -self.floor / s < 6.5)
        return tuple(range(-step * int(-self.floor // step), 1, step))
