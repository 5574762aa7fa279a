"""The devices of a scene file, with the signals of their actuators, from the choices of listeners.

A listener with the automatic choice is written with the actuators at its body part of all devices
with a known profile, so that readers need not implement the choice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from bpy.types import Object, Scene

from ...core.devices.mapping import Place, map_listeners
from ...core.forms import JsonObject
from ...core.scene.device_mapping import ActuatorMapping, DeviceMapping
from ...core.scene.values import Listener
from ..blender.full_names import object_named
from ..blender.single_precision import shortest
from ..properties.actuators import AUTOMATIC, MUTED, places_of
from ..properties.sound import device_profiles

ADJUSTED = ("gain", "floor", "curve", "ceiling", "offset")
"""Properties of a device that are written to its extras, under `EXTRAS`, if they differ from their
defaults."""
EXTRAS = "blender"


def written_devices(scene: Scene, listeners: Sequence[Listener]) -> tuple[DeviceMapping, ...]:
    """The devices of a scene, ordered by name, with the ``listeners`` that their actuators play."""
    settings = scene.haptics.live_output.devices
    choices = {item.name: _choice(object_named(item.name)) for item in listeners}
    named = {place.device for choice in choices.values() for place in places_of(choice) or ()}
    profiles = {name: profile_name(name) for name in sorted({*settings.keys(), *named} - {""})}
    found = automatic({item.name: item.body_part for item in listeners}, profiles)
    felt = {
        name: found[name] if choice == AUTOMATIC else places_of(choice) or []
        for name, choice in choices.items()
    }
    return tuple(
        DeviceMapping(
            name=name,
            profile=profile,
            actuators=tuple(
                ActuatorMapping(place.actuator, listener, place.gain)
                for listener in sorted(felt)
                for place in sorted(set(felt[listener]), key=lambda place: place.actuator)
                if place.device == name and place.actuator
            ),
            extras=_adjusted(settings.get(name)),
        )
        for name, profile in profiles.items()
    )


def is_muted(obj: Object | None) -> bool:
    """Whether a listener has the choice of no actuator."""
    return _choice(obj) == MUTED


def automatic(parts: Mapping[str, str], profiles: Mapping[str, str]) -> dict[str, list[Place]]:
    """The automatic actuators of listeners (body part by name) on known devices (profile by
    name)."""
    known = {
        name: _profiles()[profile] for name, profile in profiles.items() if profile in _profiles()
    }
    weights = map_listeners(parts, known).weights
    return {
        listener: [
            Place(name, actuator.name)
            for name, profile in known.items()
            for row, actuator in enumerate(profile.actuators)
            if weights[name][row, column]
        ]
        for column, listener in enumerate(parts)
    }


def profile_name(device: str) -> str:
    """The profile of a device, whose name begins with it; without a profile, the name of the
    device."""
    fitting = [name for name in _profiles() if device == name or device.startswith(f"{name} ")]
    return max(fitting, key=len, default=device)


_profiles = cache(device_profiles)
"""The profiles as they were when they were asked for first."""


def _choice(obj: Object | None) -> str:
    return obj.haptics.live_output.actuators if obj is not None else AUTOMATIC


def _adjusted(settings: Any) -> JsonObject:
    if settings is None:
        return {}
    used = {
        key: value
        for key in ADJUSTED
        if (value := shortest(getattr(settings, key)))
        != shortest(settings.bl_rna.properties[key].default)
    }
    return {EXTRAS: used} if used else {}
