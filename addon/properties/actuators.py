"""The text form of a listener's choice of actuators."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ...core.devices.mapping import Place

AUTOMATIC = ""
"""A listener's choice: the actuators at its body part."""
MUTED = "-"
"""A listener's choice: none."""
_GAIN = re.compile(r"\d{1,10}(\.\d+)?(e-?\d{1,2})?", re.ASCII)


def places_of(choice: str) -> list[Place] | None:
    """The actuators of a choice, as "device/actuator" or "device/actuator*gain" separated by
    semicolons; None for the automatic choice."""
    if choice == AUTOMATIC:
        return None
    places = []
    for text in choice.split(";"):
        device, slash, actuator = text.rpartition("/")
        name, _, gain = actuator.rpartition("*")
        if slash:
            places.append(
                Place(device, name, float(gain))
                if name and _GAIN.fullmatch(gain)
                else Place(device, actuator)
            )
    return places


def choice_of(places: Sequence[Place]) -> str:
    """The text form of actuators."""
    return ";".join(map(_text, places)) or MUTED


def toggled(choice: str, actuator: str) -> str:
    """The choice with the actuator, as "device/actuator", added, or removed if it was chosen."""
    device, _, name = actuator.rpartition("/")
    place = Place(device, name)
    places = places_of(choice) or []
    return choice_of(
        [other for other in places if other != place] if place in places else [*places, place]
    )


def _text(place: Place) -> str:
    plain = place.gain == 1.0 and "*" not in place.actuator
    return (
        f"{place.device}/{place.actuator}"
        if plain
        else f"{place.device}/{place.actuator}*{place.gain!r}"
    )
