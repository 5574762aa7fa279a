"""Pads that speak SInput (HandheldLegend and others), as SDL sets them up."""

from __future__ import annotations

from collections.abc import Callable

from ..report import Report
from .family import HidDevice, Interface, answer_of
from .pads import pad

_ANSWER, _FEATURES = 0x02, 0x02
_ASK_FEATURES = Report(bytes([0x03, _FEATURES]).ljust(48, b"\0"))
# The answer to the query of features: report id, command, version of the protocol (2 bytes), capabilities.
_ABILITIES, _CAN_RUMBLE = 4, 0x01


def _prepare(device: HidDevice, interface: Interface, write: Callable[[Report], bool]) -> None:
    """Query the pad's capabilities, as SDL does. A pad that does not answer is driven nevertheless."""
    write(_ASK_FEATURES)
    answer = answer_of(device, _describes_features)
    if answer is not None and not answer[_ABILITIES] & _CAN_RUMBLE:
        raise OSError(f"{interface.title or 'SInput controller'} says that it can't rumble")


def _describes_features(report: bytes) -> bool:
    return len(report) > _ABILITIES and report[:2] == bytes([_ANSWER, _FEATURES])


SINPUT = pad("sinput", prepare=_prepare)
