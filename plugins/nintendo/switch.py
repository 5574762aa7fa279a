"""Switch Pro Controller and Joy-Con: linear resonant actuators, each driven by two tones.

Formulas: dekuNukem's notes and Linux ``hid-nintendo.c``; lengths and intervals: SDL. The published
tables are steps of 1/32 octave, and for amplitudes of 1/32, 1/16 and 1/4 octave.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from ...core.devices.families.family import (
    HidDevice,
    Interface,
    RumbleFamily,
    answer_of,
    is_gamepad,
)
from ...core.devices.report import Report, Tones, Transport, checked_amplitude

NINTENDO = 0x057E
PRO, LEFT, RIGHT, GRIP = 0x2009, 0x2006, 0x2007, 0x200E

LOW_HZ, HIGH_HZ = 160.0, 320.0
"""The two tones at rest, near the actuators' two resonances."""

# Table index of amplitude 1.0; higher ones can damage the actuators.
SAFE_INDEX = 100

_LENGTH: dict[Transport, int] = {"usb": 64, "bt": 49}
_VIBRATION_ON = bytes([0x48, 0x01])
_HANDSHAKE, _FAST, _KEEP_USB, _LEAVE_USB = 2, 3, 4, 5
_ATTEMPTS = 2


def frequency_code(frequency: float) -> int:
    """Steps of 1/32 octave above 10 Hz, rounded. Raises ValueError unless frequency is positive and
    finite."""
    if not (math.isfinite(frequency) and frequency > 0.0):
        raise ValueError(f"frequency {frequency} is not a positive number of Hz")
    return round(32.0 * math.log2(frequency / 10.0))


def amplitude_index(amplitude: float) -> int:
    """Row 0..100 of the published amplitude table nearest on its logarithmic scale. amplitude: in
    [0, 1]."""
    if checked_amplitude(amplitude) < 0.0039:
        return 0
    # Each formula holds only in its own part of the table: below, it is negative and would wrap to
    # a strong vibration.
    if amplitude >= 0.2299:
        index = round(32.0 * math.log2(8.7 * amplitude))
    elif amplitude >= 0.11747:
        index = round(16.0 * math.log2(17.0 * amplitude))
    else:
        index = max(1, round(4.0 * math.log2(119.6 * amplitude)))
    return min(index, SAFE_INDEX)


def actuator_word(low_hz: float, low: float, high_hz: float, high: float) -> bytes:
    """Four bytes for one actuator. Frequencies in Hz are clamped to 40.9..626.3 (low) and
    81.8..1252.6 (high); amplitudes in [0, 1]."""
    high_code = 4 * (min(max(frequency_code(high_hz), 0x61), 0xDF) - 0x60)
    low_code = min(max(frequency_code(low_hz), 0x41), 0xBF) - 0x40
    high_index = amplitude_index(high)
    low_index = amplitude_index(low)
    return bytes(
        [
            high_code & 0xFF,
            2 * high_index | high_code >> 8,
            low_code | (low_index & 1) << 7,
            0x40 + low_index // 2,
        ]
    )


_NEUTRAL = 2 * actuator_word(LOW_HZ, 0.0, HIGH_HZ, 0.0)


def _words(drive: Tones) -> bytes:
    (low_l, high_l, low_r, high_r), (low_hz_l, high_hz_l, low_hz_r, high_hz_r) = (
        drive.amplitudes,
        drive.frequencies,
    )
    return actuator_word(low_hz_l, low_l, high_hz_l, high_l) + actuator_word(
        low_hz_r, low_r, high_hz_r, high_r
    )


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    return Report((bytes([0x10, sequence & 0x0F]) + _words(drive)).ljust(_LENGTH[transport], b"\0"))


def _rumble(left: float, right: float) -> Tones:
    """The kernel's rule for a classic pair: both tones of a side at the same amplitude, strong on
    the left."""
    return Tones((left, left, right, right), (LOW_HZ, HIGH_HZ, LOW_HZ, HIGH_HZ))


def usb_command(command: int) -> Report:
    """A command to the bridge between USB and the controller's serial line."""
    return Report(bytes([0x80, command]).ljust(_LENGTH["usb"], b"\0"))


def enable_vibration(transport: Transport, sequence: int) -> Report:
    """Subcommand 0x48: vibration on, with both actuators at rest."""
    return Report(
        (bytes([0x01, sequence & 0x0F]) + _NEUTRAL + _VIBRATION_ON).ljust(_LENGTH[transport], b"\0")
    )


def _prepare(device: HidDevice, interface: Interface, write: Callable[[Report], bool]) -> None:
    """Set up as in SDL: the handshake over USB, then vibration on. Some clones answer only the
    first command, so an unanswered command is repeated once and then ignored."""

    def say(report: Report, is_answer: Callable[[bytes], bool]) -> None:
        for _ in range(_ATTEMPTS):
            if write(report) and answer_of(device, is_answer) is not None:
                return

    if interface.transport == "usb":
        for command in (_HANDSHAKE, _FAST, _HANDSHAKE):
            say(usb_command(command), partial(_acknowledges, command))
        write(usb_command(_KEEP_USB))  # is not acknowledged
    say(enable_vibration(interface.transport, 0), _confirms_vibration)


def _acknowledges(command: int, report: bytes) -> bool:
    return report[:2] == bytes([0x81, command])


def _confirms_vibration(report: bytes) -> bool:
    return (
        len(report) > 14
        and report[0] == 0x21
        and bool(report[13] & 0x80)
        and report[14] == _VIBRATION_ON[0]
    )


def _farewell(transport: Transport, sequence: int) -> tuple[Report, ...]:
    return (usb_command(_LEAVE_USB),) if transport == "usb" else ()


def _in_grip(number: int, interface: Interface) -> bool:
    """Whether the interface is that of a Joy-Con alone, or that of this Joy-Con in the charging
    grip."""
    return is_gamepad(interface) and (interface.product != GRIP or interface.number == number)


def _family(
    name: str, title: str, products: tuple[int, ...], picks: Callable[[Interface], bool]
) -> RumbleFamily:
    return RumbleFamily(
        name=name,
        title=title,
        ids=frozenset((NINTENDO, product) for product in products),
        channels=("left.low", "left.high", "right.low", "right.high"),
        # Faster than 30 ms SDL saw controllers switch off; over Bluetooth the kernel keeps 60 ms.
        minimum_interval={"usb": 0.030, "bt": 0.060}
        if PRO in products
        else {"bt": 0.060, "usb": 0.030},
        refresh_interval=0.050,
        picks=picks,
        prepare=_prepare,
        farewell=_farewell,
        zero_repeats=5,
        encode=_encode,
        rumble=_rumble,
        has_tones=True,
    )


SWITCH_PRO = _family("switch-pro", "Switch Pro Controller", (PRO,), is_gamepad)
JOYCON_LEFT = _family("joycon-left", "Joy-Con (L)", (LEFT, GRIP), partial(_in_grip, 1))
JOYCON_RIGHT = _family("joycon-right", "Joy-Con (R)", (RIGHT, GRIP), partial(_in_grip, 0))
FAMILIES = SWITCH_PRO, JOYCON_LEFT, JOYCON_RIGHT
