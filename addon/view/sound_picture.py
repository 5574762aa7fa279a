"""Picture in the panel of a sound over its vibration."""

from __future__ import annotations

import numpy as np

from .panel_picture import SIZE, Canvas, Colour, Picture, Pixels

_picture = Picture()


def picture(waves: str, colour: Colour, ink: Colour) -> Pixels:
    """Both waves around the middle of the picture, over its width: the vibration in ``colour``, the
    sound in ``ink`` over it.

    waves: equally many values of the sound and of the vibration, one byte each in hexadecimal, or
    empty.
    """
    builder = Canvas()
    try:
        values = np.frombuffer(bytes.fromhex(waves), dtype=np.uint8) / 255
    except ValueError:
        values = np.zeros(0)
    if len(values) and not len(values) % 2:
        sound, vibration = values.reshape(2, -1)
        for wave, shade in ((vibration, (*colour, 0.8)), (sound, (*ink, 0.5))):
            places = np.interp(np.linspace(0, 1, SIZE), np.linspace(0, 1, len(wave)), wave)
            for x, height in enumerate((places * (SIZE / 2 - 2)).tolist()):
                builder.plate((x, SIZE / 2 - height), (x + 1, SIZE / 2 + height), shade, 0.0)
    return builder.painted()


def icon(waves: str, colour: Colour, ink: Colour) -> int:
    """The identifier of the icon with the waves."""
    return _picture.icon((waves, colour, ink), lambda: picture(waves, colour, ink))
