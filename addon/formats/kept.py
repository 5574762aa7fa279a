"""What an imported file says that Blender's own properties can't: kept as JSON in the .blend beside them.

The text may come from a stranger's .blend file: it is checked as a file would be.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from ...core.contacts.shapes import Shape, shape_from_dict
from ...core.formats.strict_json import parse_json
from ...core.scene import Pose, SourceKind, Vector
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
    """Of a source: ``signal`` counts where the source's signal is the imported one, the rest always."""

    signal: Signal | None = None
    kind: SourceKind = SourceKind.PERSISTENT
    onset: float = 0.0
    second_object: str | None = None
    second_position: Vector | None = None
    position: Vector | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class KeptListener:
    """Of a listener."""

    position: Vector | None = None
    extras: Mapping[str, Any] = field(default_factory=dict)


def text_of(**parts: Any) -> str:
    """The text that keeps ``parts``, "" where there is nothing to keep."""
    used = {key: value for key, value in parts.items() if value not in (None, {})}
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
    if value is None:
        return None
    x, y, z = (_number(v, -1e9) for v in value)
    return x, y, z


def _number(value: Any, least: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= 1e9:
        raise ValueError(f"{value!r} is out of range")
    return float(value)


def _damaged(error: Exception) -> ValueError:
    return ValueError(f"what was imported with it is damaged: import it again ({error})")
