"""Stadia Controller: two motors with 16-bit levels (Linux ``hid-google-stadiaff.c`` and SDL).

Over Bluetooth on Windows the report is not in the pad's descriptor and writes fail.
"""

from __future__ import annotations

from ..report import Report, Tones, Transport, unsigned16
from .family import RumbleFamily


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = drive.amplitudes
    return Report(b"\x05" + unsigned16(left).to_bytes(2, "little") + unsigned16(right).to_bytes(2, "little"))


STADIA = RumbleFamily(
    name="stadia",
    title="Stadia Controller",
    ids=frozenset({(0x18D1, 0x9400)}),
    transports=("usb", "bt"),
    minimum_interval={"usb": 0.010, "bt": 0.020},
    encode=_encode,
)
