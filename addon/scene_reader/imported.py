"""What an imported file says that Blender's own properties can't: kept as JSON in the .blend beside them.

The text may come from a stranger's .blend file: it is checked as a file would be.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from ...core.contacts.shapes import Shape, shape_from_dict
from ...core.formats.io.strict_json import parse_json
from ...core.formats.scene.recording import pair_of
from ...core.formats.scene.scene_json import FORMAT, VERSION, scene_from_dict
from ...core.formats.scene.values_json import item_to_dict
from ...core.scene.functions import Identity, ModulationFunction, function_from_dict
from ...core.scene.values import Contact, Pose, SourceKind, Vector
from ...core.signals import Signal, signal_from_dict
from ..blender.single_precision import shortest

NEAR = 1e-5
"""What was moved by less (metres, or parts of a rotation) stands where the file put it: Blender rounds to single precision."""

Numbers = Mapping[str, float]
"""By property: what the file says to more digits than single precision has."""
Pair = tuple[str, str]


@dataclass(frozen=True, slots=True)
class ImportedObject:
    """Of a haptic object: ``function`` counts while the properties say the same as far as they can; ``emitters``: where the sources of
    other modalities stand, by modality."""

    shape: Shape | None = None
    mass: float | None = None
    pose: Pose | None = None
    function: ModulationFunction | None = None
    numbers: Numbers = field(default_factory=dict)
    emitters: Mapping[str, Vector] = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ImportedSource:
    """Of a source: ``signal`` counts where the source's signal is the imported one."""

    signal: Signal | None = None
    kind: SourceKind = SourceKind.PERSISTENT
    onset: float = 0.0
    second_object: str | None = None
    second_position: Vector | None = None
    position: Vector | None = None
    numbers: Numbers = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ImportedListener:
    """Of a listener."""

    position: Vector | None = None
    numbers: Numbers = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ImportedScene:
    """Of a scene; ``tolerance`` of sums over paths."""

    tolerance: float | None = None
    numbers: Numbers = field(default_factory=dict)
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ImportedDevice:
    """Of a device."""

    profile: str | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class FileContacts:
    """Of a scene: ``contacts`` by their objects, in alphabetical order, as they are while both stand where the file put them and contacts
    are found by ``tolerance`` and ``patch_points``; ``transmissions``: what is passed on wherever the two touch."""

    contacts: Mapping[Pair, tuple[Contact, ...]] = field(default_factory=dict)
    transmissions: Mapping[Pair, ModulationFunction] = field(default_factory=dict)
    tolerance: float = 0.0
    patch_points: bool = False


def text_of(**parts: Any) -> str:
    """The text that keeps ``parts``, "" where there is nothing to keep."""
    used = {key: value for key, value in parts.items() if value not in (None, {}, [])}
    return json.dumps(used, ensure_ascii=False, allow_nan=False, separators=(",", ":")) if used else ""


def text_of_contacts(contacts: Iterable[Contact], later: Iterable[Contact], tolerance: float, patch_points: bool) -> str:
    """For `file_contacts`; ``later``: those that begin on the way, for what they pass on."""
    forms = [[item_to_dict(item) for item in items] for items in (contacts, later)]
    if not any(forms):
        return ""
    return text_of(contacts=forms[0], later=forms[1], tolerance=tolerance, patch_points=patch_points)


def exact(owner: Any, name: str, numbers: Numbers) -> float:
    """A property's value as the author gave it: the imported number where there is one, else the shortest decimal of the property's single
    precision. Editing the property removes the number; an animated property is only the number in frames where the two agree."""
    number = numbers.get(name)
    if number is None:
        return shortest(getattr(owner, name))
    if owner.id_data.animation_data is None:
        return number
    value = shortest(getattr(owner, name))
    return number if shortest(number) == value else value


def text_with(text: str, emitters: Mapping[str, Vector], numbers: Numbers) -> str:
    """The text of an object with more of these."""
    form = _document(text)
    return text_of(**{**form, "emitters": {**form.get("emitters", {}), **emitters}, "numbers": {**form.get("numbers", {}), **numbers}})


@lru_cache(maxsize=4096)
def imported_object(text: str) -> ImportedObject:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        shape, pose, function = (form.get(key) for key in ("shape", "pose", "function"))
        return ImportedObject(
            shape=None if shape is None else shape_from_dict(shape),
            mass=None if form.get("mass") is None else _number(form["mass"], 0.0),
            pose=None if pose is None else Pose(tuple(pose["position"]), tuple(pose["rotation"])),
            function=None if function is None else function_from_dict(_mapping(function)),
            numbers=_numbers(form),
            emitters={str(name): _place(place) for name, place in _mapping(form.get("emitters", {})).items()},
            extras=_mapping(form.get("extras", {})),
        )
    except (ValueError, TypeError, KeyError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=4096)
def imported_source(text: str) -> ImportedSource:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        second = form.get("second_object")
        return ImportedSource(
            signal=signal_from_dict(form["signal"]) if "signal" in form else None,
            kind=SourceKind(form.get("kind", "persistent")),
            onset=_number(form.get("onset", 0.0), 0.0),
            second_object=second if second is None else str(second),
            second_position=_vector(form.get("second_position")),
            position=_vector(form.get("position")),
            numbers=_numbers(form),
            extras=_mapping(form.get("extras", {})),
        )
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=4096)
def imported_listener(text: str) -> ImportedListener:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        return ImportedListener(_vector(form.get("position")), _numbers(form), _mapping(form.get("extras", {})))
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=8)
def imported_scene(text: str) -> ImportedScene:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        tolerance = None if form.get("tolerance") is None else _number(form["tolerance"], 0.0)
        return ImportedScene(tolerance, _numbers(form), _mapping(form.get("extras", {})))
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


def imported_device(text: str) -> ImportedDevice:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        return ImportedDevice(str(form.get("profile") or "") or None, _mapping(form.get("extras", {})))
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=8)
def file_contacts(text: str) -> FileContacts:
    """Raises ValueError in words where the text is damaged."""
    if not text:
        return FileContacts()
    try:
        form = _document(text)
        found, later = (_contacts(form.get(key, [])) for key in ("contacts", "later"))
        contacts: dict[Pair, tuple[Contact, ...]] = {}
        for item in found:
            contacts[pair_of(item)] = (*contacts.get(pair_of(item), ()), item)
        return FileContacts(
            contacts=contacts,
            transmissions={pair_of(item): item.transmission for item in reversed((*found, *later)) if item.transmission != Identity()},
            tolerance=_number(form.get("tolerance", 0.0), 0.0),
            patch_points=bool(form.get("patch_points", False)),
        )
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


def near(kept: Vector, position: Vector) -> bool:
    """Whether a place is the kept one, but for rounding."""
    return math.dist(kept, position) <= NEAR * max(1.0, *map(abs, kept))


def _contacts(forms: Any) -> tuple[Contact, ...]:
    """Checked as those of a scene file are."""
    names = {name for form in forms for name in form["objects"]}
    objects = [{"name": name, "kappa": 0, "rho": 0} for name in names]
    return scene_from_dict({"format": FORMAT, "version": VERSION, "objects": objects, "contacts": forms}, "imported").contacts


def _document(text: str) -> Mapping[str, Any]:
    return _mapping(parse_json(text.encode("utf-8", "surrogatepass"), "imported")) if text else {}


def _mapping(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("must be an object")
    return value


def _numbers(form: Mapping[str, Any]) -> Numbers:
    return {name: _number(value, -1e9) for name, value in _mapping(form.get("numbers", {})).items()}


def _vector(value: Any) -> Vector | None:
    return None if value is None else _place(value)


def _place(value: Any) -> Vector:
    x, y, z = (_number(v, -1e9) for v in value)
    return x, y, z


def _number(value: Any, least: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= 1e15:
        raise ValueError(f"{value!r} is out of range")
    return float(value)


def _damaged(error: Exception) -> ValueError:
    return ValueError(f"what was imported with it is damaged: import it again ({error})")
