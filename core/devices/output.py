"""Live output: what goes to a device or a sound card, driven by the guard process."""

from __future__ import annotations

from functools import partial

from .connection import HidModule
from .guard import GuardedOutput
from .profiles import Adjustment, Profile
from .sound_card import SoundCard, SoundCardWriter
from .writer import SAMPLE_RATE, DeviceWriter


class DeviceOutput(GuardedOutput):
    """One device that is fed with blocks of samples, one row per actuator of its profile."""

    def __init__(
        self,
        profile: Profile,
        *,
        rate: int = SAMPLE_RATE,
        serial: str = "",
        adjustment: Adjustment | None = None,
        hid: HidModule | None = None,
    ) -> None:
        """rate: samples per second of the blocks. serial: of one device among several alike. adjustment: the user's settings.
        hid: in place of cython-hidapi; it is pickled.

        Raises ValueError for a rate out of range, or a calibration of an unknown actuator.
        """
        super().__init__(profile, partial(DeviceWriter, profile, rate=rate, serial=serial, adjustment=adjustment, hid=hid))


class SoundCardOutput(GuardedOutput):
    """A sound card that is fed with blocks of samples, one row per actuator; used like `DeviceOutput`."""

    def __init__(self, card: SoundCard, *, rate: int = SAMPLE_RATE, adjustment: Adjustment | None = None) -> None:
        """rate: samples per second of the blocks."""
        super().__init__(card, partial(SoundCardWriter, card, rate=rate, adjustment=adjustment))
