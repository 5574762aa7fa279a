"""Live outputs to a device or a sound card, driven by the guard process."""

from __future__ import annotations

from functools import partial
from typing import Any

from .guard import GuardedOutput
from .profiles import Adjustment, Profile
from .sound_card import SoundCard, SoundCardWriter
from .writer import DeviceWriter


class DeviceOutput(GuardedOutput):
    """One device that is fed with blocks of samples, one row per actuator of its profile."""

    def __init__(self, profile: Profile, adjustment: Adjustment | None = None, **options: Any) -> None:
        """options: those of `DeviceWriter`; ``hid`` is pickled. Raises ValueError as that does."""
        super().__init__(profile, partial(DeviceWriter, profile, adjustment=adjustment, **options))


class SoundCardOutput(GuardedOutput):
    """A sound card that is fed with blocks of samples, one row per actuator; used like `DeviceOutput`."""

    def __init__(self, card: SoundCard, adjustment: Adjustment | None = None, **options: Any) -> None:
        """options: those of `SoundCardWriter`."""
        super().__init__(card, partial(SoundCardWriter, card, adjustment=adjustment, **options))
