"""8BitDo pads with the firmware that SDL drives. Experimental: one driver is the only source."""

from __future__ import annotations

from ..report import Report, Tones, Transport, levels, unsigned8
from .family import RumbleFamily


def _encode(drive: Tones, transport: Transport, sequence: int) -> Report:
    left, right = map(unsigned8, drive.amplitudes)
    return Report(bytes([0x05, left, right, 0, 0]))


EIGHTBITDO = RumbleFamily(
    name="8bitdo",
    title="8BitDo controller",
    ids=frozenset((0x2DC8, product) for product in (0x6001, 0x6101, 0x6000, 0x6100, 0x6003, 0x6006, 0x6009, 0x6012)),
    transports=("usb", "bt"),
    channels=("left", "right"),
    minimum_interval={"usb": 0.020, "bt": 0.020},
    ends_by_itself=False,
    after_kill="goes on at the last level until it is unplugged or switched off",
    encode=_encode,
    rumble=levels,
)
