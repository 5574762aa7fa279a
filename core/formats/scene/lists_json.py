"""Lists of a haptic scene file beside those of the scene: devices, by which actuators play which
listeners, and the library of materials.

Objects refer to their material in ``material`` and have a copy of its values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from ...scene.device_mapping import ActuatorMapping, DeviceMapping
from ...scene.library import LibraryMaterial
from ...scene.references import Place, require_known, require_unique
from ...scene.values import HapticScene
from ..io.error import errors_in
from .values_json import read_items, read_value


def device_to_dict(device: DeviceMapping) -> dict[str, Any]:
    """The JSON object of a device."""
    return {key: value for key, value in asdict(device).items() if key != "extras" or value}


def devices_from_dict(
    document: Mapping[str, Any], scene: HapticScene, file: str | Path
) -> tuple[DeviceMapping, ...]:
    """The devices of a validated document. Raises FormatError."""
    forms = document.get("devices", [])
    listeners = {item.name for item in scene.listeners}
    with errors_in(file):
        require_unique([form["name"] for form in forms], "device", "devices")
        return tuple(
            DeviceMapping(
                form["name"],
                form["profile"],
                tuple(_actuators(form, listeners, ("devices", i))),
                form.get("extras", {}),
            )
            for i, form in enumerate(forms)
        )


def _actuators(
    form: Mapping[str, Any], listeners: set[str], place: Place
) -> Iterator[ActuatorMapping]:
    for k, item in enumerate(form.get("actuators", [])):
        require_known(item["listener"], listeners, "listener", (*place, "actuators", k, "listener"))
        yield ActuatorMapping(item["actuator"], item["listener"], item.get("gain", 1.0))


def materials_from_dict(
    document: Mapping[str, Any], file: str | Path
) -> tuple[LibraryMaterial, ...]:
    """The materials of a validated document. Raises FormatError."""
    forms = document.get("materials", [])
    with errors_in(file):
        require_unique([form["name"] for form in forms], "material", "materials")
        return read_items(document, "materials", partial(read_value, LibraryMaterial))
