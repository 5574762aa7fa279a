"""What deforms and drives objects beside what Blender shows as their own properties: the points of
their data, the settings inside their modifiers, constraints of rigid bodies and force fields."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Iterator
from typing import Any

from bpy.types import ID, Armature, Curve, Lattice, Object

from ..blender.arrays import read_array
from .plain_values import PLAIN_TYPES, TRANSFORM, checksum, values_of, writable

_RESULTS = {"rna_type", "solver_result", "point_cache", "particle_system"}
"""Groups inside modifiers that do not deform, or change from frame to frame."""


def deformation_of(obj: Object, animated: Collection[str]) -> str:
    """A checksum of the points of curves, lattices, rest bones and shape keys, and of the settings
    inside modifiers, as cloth and soft bodies have them, that are not ``animated``. Nodes are not
    compared."""
    inside = [_settings_in(item, f'modifiers["{item.name}"].', animated) for item in obj.modifiers]
    points = [zlib.crc32(array) for array in _points_of(obj.data)]
    return checksum([inside, points]) if any(inside) or points else ""


def drives_others(obj: Object) -> bool:
    """Whether an object is a constraint of rigid bodies or a force field."""
    return obj.rigid_body_constraint is not None or (
        obj.field is not None and obj.field.type != "NONE"
    )


def influence_of(obj: Object, animated: Collection[str]) -> list[Any]:
    """Where a constraint of rigid bodies or a force field is, and its values, except those that are
    ``animated``."""
    constraint = obj.rigid_body_constraint
    bodies = [] if constraint is None else [constraint.object1, constraint.object2]
    return [
        obj.name_full,
        values_of(obj, [key for key in TRANSFORM if key not in animated]),
        [
            _values_in(group, key, animated)
            for key, group in (("rigid_body_constraint", constraint), ("field", obj.field))
            if group is not None
        ],
        [body.name_full for body in bodies if body is not None],
    ]


def _settings_in(item: Any, prefix: str, animated: Collection[str]) -> list[Any]:
    """The values of the groups inside a modifier."""
    keys = [p.identifier for p in item.bl_rna.properties if p.type == "POINTER"]
    groups = [(key, getattr(item, key)) for key in keys if key not in _RESULTS]
    return [
        _values_in(group, f"{prefix}{key}", animated)
        for key, group in groups
        if group is not None and not isinstance(group, ID)
    ]


def _values_in(group: Any, path: str, animated: Collection[str]) -> list[Any]:
    keys = writable(group, PLAIN_TYPES)
    return values_of(group, [key for key in keys if f"{path}.{key}" not in animated])


def _points_of(data: Any) -> Iterator[bytes]:
    """Positions of points, as bytes."""
    keys = getattr(data, "shape_keys", None)
    for key in keys.key_blocks if keys is not None else ():
        yield _read(key.data, "co")
    if isinstance(data, Lattice):
        yield _read(data.points, "co_deform")
    elif isinstance(data, Armature):
        yield _read(data.bones, "head_local")
        yield _read(data.bones, "tail_local")
    elif isinstance(data, Curve):
        for spline in data.splines:
            for key in ("co", "handle_left", "handle_right"):
                yield _read(spline.bezier_points, key)
            yield _read(spline.points, "co", 4)


def _read(points: Any, key: str, width: int = 3) -> bytes:
    return read_array(points, key, width).tobytes()
