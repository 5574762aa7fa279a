"""Pads that speak SInput (HandheldLegend and others), commanded as two motors. Experimental: SDL is the only source."""

from __future__ import annotations

from collections.abc import Callable

from ..report import Report, Tones, Transport, unsigned8
from .family import HidDevice, Interface, RumbleFamily, answer_of

_COMMAND, _ANSWER = 0x03, 0x02
_HAPTICS, _FEATURES = 0x01, 0x02
_TWO_MOTORS = 0x02
# Byte 4 of the answer to "features", after its id, the command and the version of the protocol.
_ABILITIES, _CAN_RUMBLE = 4, 0x01


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned8, drive.amplitudes)
    return _command(_HAPTICS, _TWO_MOTORS, left, 0, right, 0)


def _command(*content: int) -> Report:
    return Report(bytes([_COMMAND, *content]).ljust(48, b"\0"))


def _prepare(device: HidDevice, interface: Interface, write: Callable[[Report], bool]) -> None:
    """Ask what the pad can do, as SDL does. One that does not answer is driven all the same."""
    write(_command(_FEATURES))
    answer = answer_of(device, _describes_features)
    if answer is not None and not answer[_ABILITIES] & _CAN_RUMBLE:
        raise OSError(f"{interface.title or 'SInput controller'} says that it can't rumble")


def _describes_features(report: bytes) -> bool:
    return len(report) > _ABILITIES and report[:2] == bytes([_ANSWER, _FEATURES])


SINPUT = RumbleFamily(
    name="sinput",
    title="SInput controller",
    ids=frozenset({*((0x2E8A, product) for product in (0x10C6, 0x10DF, 0x10DD, 0x10E0, 0x10E5)), (0x38D2, 0x1014)}),
    transports=("usb", "bt"),
    minimum_interval={"usb": 0.020, "bt": 0.020},
    prepare=_prepare,
    encode=_encode,
)
