"""Lists of a haptic scene file beside those of the scene: devices, by which actuators play which
listeners, and the library of materials.

Objects refer to their material in ``material`` and have a copy of its values.
"""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path

from ...forms import Form, JsonObject
from ...scene.device_mapping import DeviceMapping
from ...scene.library import LibraryMaterial
from ...scene.references import require_known, require_unique
from ...scene.values import HapticScene
from ..io.error import errors_in
from .values_json import read_items, read_value


def device_to_dict(device: DeviceMapping) -> JsonObject:
    """The JSON object of a device."""
    return {key: value for key, value in asdict(device).items() if key != "extras" or value}


def devices_from_dict(
    document: Form, scene: HapticScene, file: str | Path
) -> tuple[DeviceMapping, ...]:
    """The devices of a validated document. Raises FormatError."""
    listeners = {item.name for item in scene.listeners}
    with errors_in(file):
        devices = read_items(document, "devices", partial(read_value, DeviceMapping))
        require_unique([device.name for device in devices], "device", "devices")
        for i, device in enumerate(devices):
            for k, item in enumerate(device.actuators):
                place = ("devices", i, "actuators", k, "listener")
                require_known(item.listener, listeners, "listener", place)
    return devices


def materials_from_dict(document: Form, file: str | Path) -> tuple[LibraryMaterial, ...]:
    """The materials of a validated document. Raises FormatError."""
    with errors_in(file):
        materials = read_items(document, "materials", partial(read_value, LibraryMaterial))
        require_unique([material.name for material in materials], "material", "materials")
    return materials
