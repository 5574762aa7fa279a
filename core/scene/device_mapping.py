"""The devices of a scene, and which listeners their actuators play."""

from __future__ import annotations

from dataclasses import field

from ..declaration import Declared, extras, name_of, number, part
from ..forms import Form
from ..frozen import frozen


@frozen
class ActuatorMapping(Declared):
    """An actuator, by its name in the device's profile, and what it plays."""

    actuator: str = field(metadata=name_of("Name of the actuator").metadata)
    listener: str = field(metadata=name_of("Name of the listener that it plays").metadata)
    gain: float = number(1.0, "", "Factor of what it plays", 0.0)


@frozen
class DeviceMapping(Declared):
    """A device of the scene; ``profile``: name of its profile (see `core.devices.profiles`)."""

    name: str = field(metadata=name_of("Name, unique among devices").metadata)
    profile: str = field(metadata=name_of("Name of a known device, or any other name").metadata)
    actuators: tuple[ActuatorMapping, ...] = part(
        (), "actuator", "What its actuators play; others are silent", 1000
    )
    extras: Form = extras()
