"""Which actuators of which devices play what a listener feels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class ActuatorMapping:
    """``actuator`` by its name in the device's profile; ``gain`` >= 0."""

    actuator: str
    listener: str
    gain: float = 1.0


@dataclass(frozen=True, slots=True)
class DeviceMapping:
    """A device of the scene; ``profile`` is the name of its profile (see `core.devices.profiles`)."""

    name: str
    profile: str
    actuators: tuple[ActuatorMapping, ...] = ()
    extras: Mapping[str, Any] = field(default_factory=dict, hash=False)
