"""DualSense and DualSense Edge: rumble emulated by the pad's firmware on two voice coils, or
samples over Bluetooth.

Layout: Linux ``hid-playstation.c`` and SDL's PS5 driver agree on it; the drivers' common block of
47 bytes starts at byte 1 (USB) or 3 (Bluetooth). Only the flags of the vibration are set, so lights
and triggers stay as the game or the system left them.

Samples without a cable are experimental. The layout of report 0x32 was determined by the SAxense
project (egormanga/SAxense): two packets, one that counts and one with 32 frames of 8-bit samples,
left and right in turn, at 3 kHz.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..report import Report, Tones, Transport, unsigned8, with_crc
from .family import HidDevice, Interface, RumbleFamily, StreamFamily

SONY = 0x054C
PRODUCT, EDGE = 0x0CE6, 0x0DF2

_COMPATIBLE_VIBRATION = 0x01
_HAPTICS_SELECT = 0x02
_COMPATIBLE_VIBRATION_2 = 0x04

_FIRMWARE_INFO = 0x20
# SDL's threshold; the kernel's is lower (0x0215), and pads between the two still understand the old
# flags.
_SECOND_GENERATION = 0x0224


def _report(
    transport: Transport, sequence: int, flag0: int, flag2: int, left: int, right: int
) -> Report:
    """An output report of the controller.

    Args:
        transport: by which it is connected.
        sequence: number of the report; four bits count.
        flag0: first byte of flags, which say what of the report is valid.
        flag2: third byte of flags.
        left: amplitude of the left motor, 0 to 255.
        right: amplitude of the right motor, 0 to 255.
    """
    block = bytearray(47)
    block[0], block[2], block[3], block[38] = flag0, right, left, flag2
    if transport == "usb":
        return Report(bytes([0x02]) + block)
    body = bytes([0x31, (sequence & 0x0F) << 4, 0x10]) + block
    return Report(with_crc(body.ljust(74, b"\0")))


def _encode(flag0: int, flag2: int, drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned8, drive.amplitudes)
    return _report(transport, sequence, flag0, flag2, left, right)


def release(transport: Transport, sequence: int) -> tuple[Report, ...]:
    """All flags 0: gives the voice coils back to the audio path."""
    return (_report(transport, sequence, 0, 0, 0, 0),)


def _prepare(
    device: HidDevice, interface: Interface, write: Callable[[Report], bool]
) -> RumbleFamily | None:
    """The first generation's reports for an old firmware; an unreadable version counts as new, as
    in SDL."""
    if interface.product == EDGE:
        return None
    try:
        info = bytes(device.get_feature_report(_FIRMWARE_INFO, 64))
    except OSError:
        return None
    known = len(info) >= 46
    return (
        DUALSENSE_FIRST_GENERATION
        if known and int.from_bytes(info[44:46], "little") < _SECOND_GENERATION
        else None
    )


DUALSENSE = RumbleFamily(
    name="dualsense",
    title="DualSense",
    ids=frozenset({(SONY, PRODUCT), (SONY, EDGE)}),
    minimum_interval={"usb": 0.010, "bt": 0.010},
    release=release,
    encode=partial(_encode, _HAPTICS_SELECT, _COMPATIBLE_VIBRATION_2),
    prepare=_prepare,
)

DUALSENSE_FIRST_GENERATION = replace(
    DUALSENSE, encode=partial(_encode, _COMPATIBLE_VIBRATION | _HAPTICS_SELECT, 0), prepare=None
)

FRAMES = 32
RATE = 3000


def _encode_samples(samples: NDArray[np.int8], sequence: int) -> Report:
    if samples.shape != (2, FRAMES):
        raise ValueError(f"samples has the shape {samples.shape}, not (2, {FRAMES})")
    # The pad accepts a constant sequence nibble; it follows the counter inside the first packet.
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
    encode=_encode_samples,
)
