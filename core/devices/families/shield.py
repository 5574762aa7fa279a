"""NVIDIA SHIELD controllers of 2017 and 2015 (SDL). Experimental: one driver is the only source."""

from __future__ import annotations

from ..report import Report, Tones, Transport, unsigned8, unsigned16
from .family import RumbleFamily

NVIDIA = 0x0955


def _encode_2017(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = (unsigned16(amplitude) >> 11 for amplitude in drive.amplitudes)
    return Report(bytes([0x04, 0x39, sequence & 0xFF, 0x01, left, right]).ljust(33, b"\0"))


def _encode_2015(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned8, drive.amplitudes)
    return Report(bytes([0x01, 0x00, left, 0x00, right, 0x00, 0x00]))


SHIELD_2017 = RumbleFamily(
    name="shield-2017",
    title="SHIELD Controller (2017)",
    ids=frozenset({(NVIDIA, 0x7214)}),
    transports=("usb", "bt"),
    # The pad acknowledges each command before it takes the next; this leaves it time without waiting for the answer.
    minimum_interval={"usb": 0.100, "bt": 0.100},
    refresh_interval=0.500,
    encode=_encode_2017,
)

SHIELD_2015 = RumbleFamily(
    name="shield-2015",
    title="SHIELD Controller (2015)",
    ids=frozenset({(NVIDIA, 0x7210)}),
    transports=("usb",),
    minimum_interval={"usb": 0.020},
    encode=_encode_2015,
)
