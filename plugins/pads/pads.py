"""Luna and SHIELD pads, and pads that are asked whether they can rumble, as SDL does: those of
8BitDo, and those that speak SInput (HandheldLegend and others)."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress

from ...core.devices.families.family import HidDevice, Interface, answer_of
from ...core.devices.families.pads import pad
from ...core.devices.report import Report

_ULTIMATE_2_WIRELESS, _ULTIMATE_3 = 0x6012, 0x202F
# Reading this feature report switches to the firmware's extended protocol; the Ultimate 3 has
# another one, which includes its capabilities.
_EXTENDED, _ABILITIES = 0x06, 0x30
_ATTEMPTS = 5
# The firmware of the Ultimate 2 Wireless that rumbles sends input reports of this length, earlier
# ones shorter reports.
_LONG_INPUT = 34


def _prepare_8bitdo(
    device: HidDevice, interface: Interface, write: Callable[[Report], bool]
) -> None:
    if not _rumbles(device, interface.product):
        name = interface.title or "8BitDo controller"
        raise OSError(
            f"{name} does not report that it can rumble: update its firmware, or switch it to "
            "another mode"
        )


def _rumbles(device: HidDevice, product: int) -> bool:
    """Whether the pad reports rumble support, queried as in SDL."""
    if product == _ULTIMATE_2_WIRELESS:
        return any(len(device.read(64, 80)) >= _LONG_INPUT for _ in range(3))
    answer = _feature(device, _ABILITIES if product == _ULTIMATE_3 else _EXTENDED)
    if product == _ULTIMATE_3:
        return len(answer) < 4 or answer[3] != 0
    return bool(answer)


def _feature(device: HidDevice, report: int) -> list[int]:
    for _ in range(_ATTEMPTS):
        with suppress(OSError):
            if answer := device.get_feature_report(report, 64):
                return answer
        time.sleep(0.010)
    return []


EIGHTBITDO = pad("8bitdo", __file__, prepare=_prepare_8bitdo)

_ANSWER, _FEATURES = 0x02, 0x02
_ASK_FEATURES = Report(bytes([0x03, _FEATURES]).ljust(48, b"\0"))
# The answer to the query of features: report id, command, version of the protocol (2 bytes),
# capabilities.
_CAPABILITIES, _CAN_RUMBLE = 4, 0x01


def _prepare_sinput(
    device: HidDevice, interface: Interface, write: Callable[[Report], bool]
) -> None:
    """Query the pad's capabilities, as SDL does. A pad that does not answer is driven
    nevertheless."""
    write(_ASK_FEATURES)
    answer = answer_of(device, _describes_features)
    if answer is not None and not answer[_CAPABILITIES] & _CAN_RUMBLE:
        raise OSError(f"{interface.title or 'SInput controller'} reports that it can't rumble")


def _describes_features(report: bytes) -> bool:
    return len(report) > _CAPABILITIES and report[:2] == bytes([_ANSWER, _FEATURES])


SINPUT = pad("sinput", __file__, prepare=_prepare_sinput)

FAMILIES = (
    *(pad(name, __file__) for name in ("luna", "shield-2017", "shield-2015")),
    EIGHTBITDO,
    SINPUT,
)
