"""DualShock 4, both models and Sony's USB adaptor: a strong motor on the left, a weak one on the right.

Layout: Linux ``hid-playstation.c`` and SDL's PS4 driver. Only Sony's own numbers are driven: licensed pads want other flags.
"""

from __future__ import annotations

from ..report import Report, Tones, Transport, unsigned8, with_crc
from .family import RumbleFamily

_MOTORS = 0x01
_HID_WITH_CRC = 0xC0


def dualshock4_report(drive: Tones, transport: Transport, poll_ms: int = 0) -> Report:
    """Report 0x05 or, over Bluetooth, 0x11.

    poll_ms: 1..62 also sets the interval of the pad's input reports over Bluetooth; 0 leaves it. Raises ValueError outside 0..62.
    """
    if not 0 <= poll_ms <= 0x3E:
        raise ValueError(f"poll_ms {poll_ms} is not in 0..62")
    left, right = map(unsigned8, drive.amplitudes)
    motors = bytes([_MOTORS, 0, 0, right, left])
    if transport == "usb":
        return Report((b"\x05" + motors).ljust(32, b"\0"))
    return Report(with_crc((bytes([0x11, _HID_WITH_CRC | poll_ms, 0]) + motors).ljust(74, b"\0")))


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    return dualshock4_report(drive, transport)


DUALSHOCK4 = RumbleFamily(
    name="dualshock4",
    title="DualShock 4",
    ids=frozenset({(0x054C, 0x05C4), (0x054C, 0x09CC), (0x054C, 0x0BA0)}),
    transports=("usb", "bt"),
    minimum_interval={"usb": 0.010, "bt": 0.010},
    encode=_encode,
)
