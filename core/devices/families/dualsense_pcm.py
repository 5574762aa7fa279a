"""DualSense over Bluetooth as a stream of samples, without a cable. Experimental.

The layout of report 0x32 was found by the SAxense project (egormanga/SAxense): two packets, one that counts and one with 32 frames of
8-bit samples, left and right in turn, at 3 kHz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..report import Report, with_crc
from .dualsense import PRODUCT, SONY, release
from .family import StreamFamily

FRAMES = 32
RATE = 3000


def _encode(samples: NDArray[np.int8], sequence: int) -> Report:
    if samples.shape != (2, FRAMES):
        raise ValueError(f"samples has the shape {samples.shape}, not (2, {FRAMES})")
    # The pad accepts a constant sequence nibble; the counter inside the first packet is what it follows.
    counting = bytes([0x91, 7, 0xFE, 0, 0, 0, 0, 0xFF, sequence & 0xFF])
    sounding = bytes([0x92, 2 * FRAMES]) + samples.T.tobytes()
    return Report(with_crc((bytes([0x32, 0x00]) + counting + sounding).ljust(137, b"\0")))


DUALSENSE_PCM = StreamFamily(
    name="dualsense-pcm",
    title="DualSense (samples over Bluetooth, experimental)",
    ids=frozenset({(SONY, PRODUCT)}),
    minimum_interval={"bt": FRAMES / RATE},
    release=release,
    rate=RATE,
    frames=FRAMES,
    encode=_encode,
)
