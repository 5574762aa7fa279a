"""Picture in the panel of a sound over its vibration."""

from __future__ import annotations

import numpy as np

from .panel_picture import SIZE, Colour, Picture, Pixels, blank, tint

_picture = Picture()


def picture(waves: str, colour: Colour, ink: Colour) -> Pixels:
    """Both waves around the middle of the picture, over its width: the vibration in ``colour``, the
    sound in ``ink`` over it.

    waves: equally many values of the sound and of the vibration, one byte each in hexadecimal, or
    empty.
    """
    pixels = blank()
    try:
        values = np.frombuffer(bytes.fromhex(waves), dtype=np.uint8)
    except ValueError:
        return pixels
    if not len(values) or len(values) % 2:
        return pixels
    from_middle = np.abs(np.arange(SIZE) - (SIZE - 1) / 2)[:, None]
    for wave, shade, opacity in zip(
        values.reshape(2, -1)[::-1] / 255, (colour, ink), (0.8, 0.5), strict=True
    ):
        heights = np.interp(np.linspace(0, 1, SIZE), np.linspace(0, 1, len(wave)), wave) * (
            SIZE / 2 - 2
        )
        tint(pixels, shade, opacity * np.clip(heights + 0.5 - from_middle, 0.0, 1.0))
    return pixels


def icon(waves: str, colour: Colour, ink: Colour) -> int:
    """The identifier of the icon with the waves."""
    return _picture.icon((waves, colour, ink), lambda: picture(waves, colour, ink))
