"""What an imported file says that Blender's own properties can't: kept as JSON in the .blend beside them.

The text may come from a stranger's .blend file: it is checked as a file would be.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

from ...core.contacts.shapes import Shape, shape_from_dict
from ...core.formats.strict_json import parse_json
from ...core.scene import Contact, Pose, SourceKind, Vector
from ...core.signals import Signal, signal_from_dict

NEAR = 1e-5
"""What was moved by less (metres, or parts of a quaternion) stands where the file put it: Blender rounds to single precision."""


@dataclass(frozen=True, slots=True)
class KeptObject:
    """Of a haptic object."""

    shape: Shape | None = None
    mass: float | None = None
    pose: Pose | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class KeptSource:
    """Of a source: ``signal`` counts where the source's signal is the imported one, ``amplitude`` where it differs by rounding alone."""

    signal: Signal | None = None
    kind: SourceKind = SourceKind.PERSISTENT
    onset: float = 0.0
    second_object: str | None = None
    second_position: Vector | None = None
    position: Vector | None = None
    amplitude: float | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class KeptListener:
    """Of a listener."""

    position: Vector | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class KeptContact:
    """Of a contact: where it was, in numbers of double precision."""

    objects: tuple[str, str]
    positions: tuple[Vector, Vector]
    normal: Vector
    area: float
    depth: float
    extras: Mapping[str, Any]

    @classmethod
    def of(cls, contact: Contact) -> KeptContact:
        """What is kept of a contact."""
        return cls(contact.objects, contact.positions, contact.normal, contact.area, contact.depth, contact.extras)

    def to_list(self) -> list[Any]:
        """For `kept_contacts` to read again."""
        return [list(self.objects), list(map(list, self.positions)), list(self.normal), self.area, self.depth, dict(self.extras)]

    def written(self, found: Contact) -> Contact:
        """The contact that was found, with the kept numbers."""
        return replace(
            found,
            objects=self.objects,
            positions=self.positions,
            normal=self.normal,
            area=self.area,
            depth=self.depth,
            extras=dict(self.extras),
        )


def text_of(**parts: Any) -> str:
    """The text that keeps ``parts``, "" where there is nothing to keep."""
    used = {key: value for key, value in parts.items() if value not in (None, {}, [])}
    return json.dumps(used, ensure_ascii=False, allow_nan=False, separators=(",", ":")) if used else ""


@lru_cache(maxsize=4096)
def kept_object(text: str) -> KeptObject:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        shape, pose = form.get("shape"), form.get("pose")
        return KeptObject(
            shape=None if shape is None else shape_from_dict(shape),
            mass=None if form.get("mass") is None else _number(form["mass"], 0.0),
            pose=None if pose is None else Pose(tuple(pose["position"]), tuple(pose["rotation"])),
            extras=_mapping(form.get("extras", {})),
        )
    except (ValueError, TypeError, KeyError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=4096)
def kept_source(text: str) -> KeptSource:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        second = form.get("second_object")
        return KeptSource(
            signal=signal_from_dict(form["signal"]) if "signal" in form else None,
            kind=SourceKind(form.get("kind", "persistent")),
            onset=_number(form.get("onset", 0.0), 0.0),
            second_object=second if second is None else str(second),
            second_position=_vector(form.get("second_position")),
            position=_vector(form.get("position")),
            amplitude=None if form.get("amplitude") is None else _number(form["amplitude"], 0.0),
            extras=_mapping(form.get("extras", {})),
        )
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


@lru_cache(maxsize=4096)
def kept_listener(text: str) -> KeptListener:
    """Raises ValueError in words where the text is damaged."""
    try:
        form = _document(text)
        return KeptListener(_vector(form.get("position")), _mapping(form.get("extras", {})))
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


def kept_scene(text: str) -> Mapping[str, Any]:
    """The extras of a scene. Raises ValueError in words where the text is damaged."""
    return _mapping(_document(text).get("extras", {}))


@lru_cache(maxsize=8)
def kept_contacts(text: str) -> Mapping[tuple[str, str], tuple[KeptContact, ...]]:
    """The contacts of a scene by their objects, in alphabetical order. Raises ValueError in words where the text is damaged."""
    try:
        contacts: dict[tuple[str, str], tuple[KeptContact, ...]] = {}
        for (a, b), (at_a, at_b), normal, area, depth, extras in _document(text).get("contacts", []):
            item = KeptContact(
                (str(a), str(b)),
                (_place(at_a), _place(at_b)),
                _place(normal),
                _number(area, 0.0),
                _number(depth, -1e9),
                _mapping(extras),
            )
            pair = (item.objects[0], item.objects[1]) if item.objects[0] < item.objects[1] else (item.objects[1], item.objects[0])
            contacts[pair] = (*contacts.get(pair, ()), item)
        return contacts
    except (ValueError, TypeError) as error:
        raise _damaged(error) from None


def near(kept: Vector, position: Vector) -> bool:
    """Whether a place is the kept one, but for rounding."""
    return math.dist(kept, position) <= NEAR * max(1.0, *map(abs, kept))


def same_pose(kept: Pose, pose: Pose) -> bool:
    """Whether a pose is the kept one, but for rounding."""
    turned = min(math.dist(kept.rotation, [sign * v for v in pose.rotation]) for sign in (1, -1))
    return near(kept.position, pose.position) and turned <= NEAR


def _document(text: str) -> Mapping[str, Any]:
    return _mapping(parse_json(text.encode("utf-8", "surrogatepass"), "imported")) if text else {}


def _mapping(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("must be an object")
    return value


def _vector(value: Any) -> Vector | None:
    return None if value is None else _place(value)


def _place(value: Any) -> Vector:
    x, y, z = (_number(v, -1e9) for v in value)
    return x, y, z


def _number(value: Any, least: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= 1e9:
        raise ValueError(f"{value!r} is out of range")
    return float(value)


def _damaged(error: Exception) -> ValueError:
    return ValueError(f"what was imported with it is damaged: import it again ({error})")
