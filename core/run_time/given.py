"""What the caller gives: values with NumPy's arrays in them, contacts and impacts of a step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..contacts.contact_set import ContactSet
from ..contacts.impacts import Impact
from ..formats.scene.values_json import read_contact
from ..scene.references import Place, PlacedError, require_known
from ..scene.rules import ContactSettings, Motion, full_energy_of
from ..scene.values import Contact, HapticObject

Objects = Mapping[str, HapticObject]
"""The objects of a run by name."""


def plain(value: Any) -> Any:
    """A value of dictionaries and lists, with the arrays and numbers of NumPy in it as lists and
    numbers, as a file has them."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def contact_set(contacts: Sequence[Contact], objects: Iterable[str]) -> ContactSet:
    """Contacts that number ``objects`` by their sorted names. Raises PlacedError for a name that is
    not one of them."""
    index = {name: number for number, name in enumerate(sorted(objects))}
    for number, item in enumerate(contacts):
        for k, name in enumerate(item.objects):
            require_known(name, index, "object", ("contacts", number, "objects", k))
    return ContactSet.from_contacts(contacts, index)


def read_contacts(forms: Sequence[Mapping[str, Any]], objects: Iterable[str]) -> ContactSet:
    """Contacts as in a scene file. Raises PlacedError."""
    return contact_set(
        [read_contact(form, ("contacts", number)) for number, form in enumerate(plain(forms))],
        objects,
    )


def read_impacts(
    forms: Sequence[Mapping[str, Any]],
    numbers: Mapping[str, int],
    objects: Objects,
    rules: ContactSettings,
    interval: tuple[float, float],
    origin: float,
) -> tuple[Impact, ...]:
    """Impacts with at least the least energy of their rules.

    Args:
        forms: ``objects`` (two names), ``position`` [m, world], ``energy`` [J] or ``normal_speed``
            [m/s], and ``time`` [s], by default the end of the interval.
        numbers: of the objects, by name.
        objects: with the masses and materials.
        rules: the limits of impacts.
        interval: the step's beginning and end [s].
        origin: from when on times of impacts are counted [s].

    Raises:
        PlacedError: names the key where a value is not valid.
    """
    found = []
    full = full_energy_of(map(_movable_mass, objects.values()))
    for row, form in enumerate(plain(forms)):
        place: Place = ("impacts", row)
        for key in ("objects", "position"):
            if key not in form:
                raise PlacedError((*place, key), "is required")
        for k, name in enumerate(form["objects"]):
            require_known(name, numbers, "object", (*place, "objects", k))
        first, second = sorted(form["objects"], key=numbers.__getitem__)
        energy = _energy(form, objects[first], objects[second], place)
        limits = rules.impact_limits(*((name, objects[name].material) for name in (first, second)))
        begun, end = interval
        x, y, z = (
            _number(value, (*place, "position", k)) for k, value in enumerate(form["position"])
        )
        if energy >= (limits.least_energy or 0.0):
            found.append(
                Impact(
                    objects=(numbers[first], numbers[second]),
                    time=min(max(_number(form.get("time", end), (*place, "time")), begun), end)
                    - origin,
                    positions=((x, y, z), (x, y, z)),
                    normal=(0.0, 0.0, 1.0),
                    energy=energy,
                    amplitude=min(energy / (limits.full_energy or full), 1.0),
                )
            )
    return tuple(found)


def _energy(
    form: Mapping[str, Any], first: HapticObject, second: HapticObject, place: Place
) -> float:
    """The energy [J] of an impact: as given, or 1/2 mu v^2 with the reduced mass mu; objects that
    can't be moved have no mass in it."""
    if "energy" in form:
        return _number(form["energy"], (*place, "energy"))
    if "normal_speed" not in form:
        raise PlacedError((*place, "energy"), "is required, or normal_speed")
    inverse = sum(1 / mass for mass in map(_movable_mass, (first, second)) if mass)
    speed = _number(form["normal_speed"], (*place, "normal_speed"))
    return speed**2 / (2 * inverse) if inverse else 0.0


def _movable_mass(item: HapticObject) -> float:
    """The mass [kg] of an object that can be moved, 0 of one that can't."""
    return 0.0 if item.motion is Motion.STATIC or item.medium else item.mass or 0.0


def _number(value: Any, place: Place) -> float:
    """A finite number. Raises PlacedError."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise PlacedError(place, f"expected a finite number, got {value!r}")
    return float(value)
