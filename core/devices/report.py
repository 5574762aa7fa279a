"""Drive values, encoded reports, and the number formats shared by the pads."""

from __future__ import annotations

import math
import zlib
from typing import Literal

from ..frozen import frozen

Transport = Literal["usb", "bt"]

# Sony's Bluetooth reports end in a CRC-32 that also covers the HID transaction byte for "output
# report".
_OUTPUT_REPORT_SEED = b"\xa2"


@frozen
class Report:
    """One HID report.

    data: bytes exactly as hidapi takes them, report id first.
    feature: sent with ``send_feature_report`` instead of ``write``.
    """

    data: bytes
    feature: bool = False


@frozen
class Tones:
    """Drive of a device that is commanded by amplitude: one entry per channel of its family.

    amplitudes: in [0, 1].
    frequencies: Hz; 0 if the device has a fixed frequency.
    """

    amplitudes: tuple[float, ...]
    frequencies: tuple[float, ...]


def levels(*amplitudes: float) -> Tones:
    """Drive of channels without a frequency. amplitudes: in [0, 1]."""
    return Tones(amplitudes, (0.0,) * len(amplitudes))


def checked_amplitude(value: float) -> float:
    """``value`` if it is a number in [0, 1]; raises ValueError otherwise."""
    if not (math.isfinite(value) and 0.0 <= value <= 1.0):
        raise ValueError(f"amplitude {value} is not in [0, 1]")
    return float(value)


def unsigned16(amplitude: float) -> int:
    """Amplitude in [0, 1] as 0..65535, rounded half up."""
    return int(checked_amplitude(amplitude) * 65535 + 0.5)


def unsigned8(amplitude: float) -> int:
    """Amplitude in [0, 1] as 0..255: the high byte of the 16-bit value, as the drivers do."""
    return unsigned16(amplitude) >> 8


def percent(amplitude: float) -> int:
    """Amplitude in [0, 1] as 0..100: the 16-bit value in steps of 655."""
    return unsigned16(amplitude) // 655


def with_crc(body: bytes) -> bytes:
    """``body`` followed by its CRC-32 for Sony's pads over Bluetooth: seeded with 0xA2,
    little-endian."""
    return body + zlib.crc32(_OUTPUT_REPORT_SEED + body).to_bytes(4, "little")
