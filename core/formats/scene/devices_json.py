"""The devices of a haptic scene file: which actuator plays which listener."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...scene.values import HapticScene
from ..io.error import FormatError


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


def device_to_dict(device: DeviceMapping) -> dict[str, Any]:
    """A device as the file has it."""
    form: dict[str, Any] = {
        "name": device.name,
        "profile": device.profile,
        "actuators": [{"actuator": item.actuator, "listener": item.listener, "gain": item.gain} for item in device.actuators],
    }
    return {**form, "extras": dict(device.extras)} if device.extras else form


def devices_from_dict(document: Mapping[str, Any], scene: HapticScene, file: str | Path) -> tuple[DeviceMapping, ...]:
    """The devices of a validated document. Raises FormatError."""
    return tuple(_devices(document.get("devices", []), {item.name for item in scene.listeners}, file))


def _devices(forms: list[Mapping[str, Any]], listeners: set[str], file: str | Path) -> Iterator[DeviceMapping]:
    names: set[str] = set()
    for i, form in enumerate(forms):
        if form["name"] in names:
            raise FormatError(file, f"/devices/{i}/name", f"there is a device {form['name']!r} already")
        names.add(form["name"])
        for k, item in enumerate(form.get("actuators", [])):
            if item["listener"] not in listeners:
                raise FormatError(file, f"/devices/{i}/actuators/{k}/listener", f"there is no listener {item['listener']!r}")
        actuators = tuple(ActuatorMapping(a["actuator"], a["listener"], a.get("gain", 1.0)) for a in form.get("actuators", []))
        yield DeviceMapping(form["name"], form["profile"], actuators, form.get("extras", {}))
