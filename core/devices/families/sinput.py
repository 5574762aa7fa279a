"""Pads that speak SInput (HandheldLegend and others), commanded as two motors. Experimental: SDL is the only source."""

from __future__ import annotations

from ..report import Report, Tones, Transport, levels, unsigned8
from .family import RumbleFamily

_HAPTICS = 0x01
_TWO_MOTORS = 0x02


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned8, drive.amplitudes)
    return Report(bytes([0x03, _HAPTICS, _TWO_MOTORS, left, 0, right, 0]).ljust(48, b"\0"))


SINPUT = RumbleFamily(
    name="sinput",
    title="SInput controller",
    ids=frozenset((0x2E8A, product) for product in (0x10C6, 0x10DF, 0x10DD, 0x10E0)),
    transports=("usb", "bt"),
    channels=("left", "right"),
    minimum_interval={"usb": 0.020, "bt": 0.020},
    ends_by_itself=False,
    after_kill="goes on at the last level until it is unplugged or switched off",
    encode=_encode,
    rumble=levels,
)
