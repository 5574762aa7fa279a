"""Steam Deck, and Steam Controller of 2026: rumble, or 8-bit samples at 8 kHz to its two internal
actuators.

Layout: SDL's driver, Linux ``hid-steam.c`` and the notes of the steam-controller-stuff and
TritonLib projects. Steam itself writes to the pad: drive it only while Steam is closed.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...core.devices.families.family import AnyFamily, Interface, StreamFamily, is_vendor_defined
from ...core.devices.families.pads import pad
from ...core.devices.report import Report, Transport

VALVE = 0x28DE
WIRED = 0x1302
DONGLES = (0x1304, 0x1305)

FRAMES = 31
RATE = 8000

_BOTH_INTERNAL = 2
_SETUP, _CANCEL = 2, 1
_SIGNED_8_BIT_8_KHZ = 4


def _encode_samples(samples: NDArray[np.int8], sequence: int) -> Report:
    if samples.shape != (2, FRAMES):
        raise ValueError(f"samples has the shape {samples.shape}, not (2, {FRAMES})")
    return Report(bytes([0x88, FRAMES]) + samples.tobytes())


def _stream(command: int, form: int, transport: Transport, sequence: int) -> tuple[Report, ...]:
    return (Report(bytes([0x86, command, _BOTH_INTERNAL, form])),)


_KEYBOARD = (0x01, 0x06)
_MOUSE = (0x01, 0x02)


def _not_keyboard_or_mouse(interface: Interface) -> bool:
    return (interface.usage_page, interface.usage) not in (_KEYBOARD, _MOUSE)


STEAM_DECK = pad("steam-deck", __file__, picks=_not_keyboard_or_mouse, probe_input=True)


def _carries_a_controller(interface: Interface) -> bool:
    """On the wireless adaptor, interfaces 2 to 5 are the controllers paired with it."""
    return is_vendor_defined(interface) and (
        interface.product not in DONGLES or 2 <= interface.number <= 5
    )


STEAM_CONTROLLER = pad("steam-controller", __file__, picks=_carries_a_controller, probe_input=True)

STEAM_CONTROLLER_PCM = StreamFamily(
    name="steam-controller-pcm",
    title="Steam Controller (2026, samples)",
    ids=frozenset((VALVE, product) for product in (WIRED, *DONGLES)),
    minimum_interval={"usb": FRAMES / RATE},
    picks=_carries_a_controller,
    probe_input=True,
    startup=partial(_stream, _SETUP, _SIGNED_8_BIT_8_KHZ),
    release=partial(_stream, _CANCEL, 0),
    rate=RATE,
    frames=FRAMES,
    encode=_encode_samples,
)

FAMILIES: tuple[AnyFamily, ...] = STEAM_DECK, STEAM_CONTROLLER, STEAM_CONTROLLER_PCM
