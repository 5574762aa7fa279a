"""Steam Deck: two linear resonant actuators behind the trackpads, by feature report (Linux ``hid-steam.c``, SDL).

Steam itself writes to them: drive them only while Steam is closed.
"""

from __future__ import annotations

from ..report import Report, Tones, Transport, unsigned16
from .family import Interface, RumbleFamily

VALVE = 0x28DE

_RUMBLE = 0xEB
_PAYLOAD = 9
_GAIN_DB = bytes([2, 0])
_KEYBOARD, _MOUSE = (0x01, 0x06), (0x01, 0x02)


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = (unsigned16(amplitude).to_bytes(2, "little") for amplitude in drive.amplitudes)
    command = bytes([0x00, _RUMBLE, _PAYLOAD, 0, 0, 0]) + left + right + _GAIN_DB
    return Report(command.ljust(65, b"\0"), feature=True)


def _not_keyboard_or_mouse(interface: Interface) -> bool:
    return (interface.usage_page, interface.usage) not in (_KEYBOARD, _MOUSE)


STEAM_DECK = RumbleFamily(
    name="steam-deck",
    title="Steam Deck",
    ids=frozenset({(VALVE, 0x1205)}),
    transports=("usb",),
    minimum_interval={"usb": 0.010},
    picks=_not_keyboard_or_mouse,
    probe_input=True,
    encode=_encode,
)
