"""Xbox One S and Series controllers over Bluetooth, and Amazon's Luna Controller, which takes the same packet.

Layout: the pad's own descriptor (physical interface device page, "set effect"), SDL and xpadneo. Over USB or the wireless adaptor these
pads are not HID devices and can't be reached this way.
"""

from __future__ import annotations

from ..report import Report, Tones, Transport, percent
from .family import RumbleFamily

MICROSOFT = 0x045E

_MAIN_MOTORS = 0x03
_ALL_MOTORS = 0x0F
# The drivers' way: 255 x 10 ms, repeated 235 times.
_MINUTES = (0xFF, 0x00, 0xEB)
# Our way while playing: 250 ms once, so that a pad whose program died goes quiet.
_QUARTER_SECOND = (25, 0x00, 0x00)


def xbox_report(left: float, right: float, motors: int, duration: tuple[int, int, int]) -> Report:
    """Report 0x03. motors: bit mask of those addressed; duration: sustain and delay in units of 10 ms, repeats."""
    return Report(bytes([0x03, motors, 0, 0, percent(left), percent(right), *duration]))


def lasting(drive: Tones, transport: Transport, sequence: int) -> Report:
    """Vibration that goes on for ten minutes, all four motors addressed."""
    left, right = drive.amplitudes
    return xbox_report(left, right, _ALL_MOTORS, _MINUTES)


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = drive.amplitudes
    # Zero addresses all motors, so that it ends whatever another program started.
    return xbox_report(left, right, _MAIN_MOTORS, _QUARTER_SECOND) if any(drive.amplitudes) else lasting(drive, transport, sequence)


XBOX = RumbleFamily(
    name="xbox",
    title="Xbox Wireless Controller (Bluetooth)",
    ids=frozenset((MICROSOFT, product) for product in (0x02E0, 0x02FD, 0x0B20, 0x0B05, 0x0B22, 0x0B13)),
    transports=("bt",),
    # Faster than 50 ms the firmware of BLE pads is known to crash.
    minimum_interval={"bt": 0.050},
    refresh_interval=0.100,
    encode=_encode,
)

LUNA = RumbleFamily(
    name="luna",
    title="Luna Controller (Bluetooth)",
    ids=frozenset({(0x0171, 0x0419)}),
    transports=("bt",),
    minimum_interval={"bt": 0.050},
    encode=lasting,
)
