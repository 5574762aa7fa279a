"""Contact area of two overlapping bodies whose surfaces consist of many small faces, from a section
through the overlap.

Round bodies are given by hulls of many faces, of which any two that face each other are slivers.
Where the bodies overlap, the plane across the normal, midway between their deepest points, cuts
both; the area of what lies in both cuts is that of the contact. From the point between the deepest
ones it is seen in directions all around, so the area is a continuous function of the poses and the
normal. The normal of overlapping polyhedra jumps where they are equally deep in each other along
two directions.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray
from .cores import CoreTable, Kind
from .frames import SIDES, added, dot, turned_back

_ANGLES = 2 * np.pi * np.arange(24) / 24
_POLE = np.array([[0.36], [0.48], [0.8]])
"""Opposite of the only normal near which the directions around it change quickly; no face of usual
shapes has it."""
_ACROSS = np.array([[0.8], [-0.6], [0.0]])
_AROUND = _ACROSS * np.cos(_ANGLES) + np.cross(_POLE, _ACROSS, axis=0) * np.sin(_ANGLES)
"""Unit vectors (3, k) around the pole."""
_CLOSED = 4
"""Least number of faces of a hull with an inside; a flat hull has two."""

_AT_ONCE = 1 << 14
"""Elements per array that are computed at a time: few enough for the processor's cache."""

_LEAST = 1e-12
"""Least distance of a face from the point [m], and least rate at which a direction approaches a
face: smaller ones are replaced by it, so that quotients are finite."""


def directions(normal: FloatArray) -> FloatArray:
    """Unit vectors (3, k, n) all around each unit normal (3, n)."""
    # The mirror that maps the pole to the opposite of a normal maps what is around the one to what
    # is around the other.
    mirror = normal + _POLE
    mirror = mirror / np.sqrt(np.maximum(dot(mirror, mirror), 1e-12))
    return np.asarray(
        _AROUND[:, :, None] - 2 * mirror[:, None] * dot(_AROUND[:, :, None], mirror[:, None])
    )


def section_area(one: FloatArray, other: FloatArray) -> FloatArray:
    """Area (n,) of what two sections have in common that reach so far (k, n) [m] around a point in
    both: that of the polygon of the places reached, so never more than there is."""
    both = np.minimum(one, other)
    return np.asarray(
        added(both * np.concatenate([both[-1:], both[:-1]])) * (np.sin(_ANGLES[1]) / 2)
    )


def reach(
    table: CoreTable,
    core: IntArray,
    rotation: FloatArray,
    centre: FloatArray,
    point: FloatArray,
    around: FloatArray,
) -> FloatArray:
    """How far (k, n) [m] boxes and hulls, grown by their radii, reach from points in them; 0 for a
    point outside.

    Args:
        table: the cores of all bodies.
        core: numbers of boxes or hulls (n,).
        rotation: of the cores (3, 3, n).
        centre: of the cores (3, n) [m].
        point: one in each (3, n) [m].
        around: the directions (3, k, n).
    """
    local = turned_back(rotation, point - centre)
    ways = turned_back(rotation, around)
    result = np.zeros(ways.shape[1:])
    boxes = np.flatnonzero(table.kind[core] == Kind.BOX)
    if len(boxes):
        half = table.outline[:, core[boxes]]
        result[:, boxes] = _reach(
            SIDES, np.concatenate([half, half]), local[:, boxes], ways[..., boxes]
        )
    alike: dict[tuple[int, float], list[int]] = {}
    for row in np.flatnonzero(table.kind[core] == Kind.HULL).tolist():
        item = table.cores[int(core[row])]
        alike.setdefault((id(item.hull), item.radius[0]), []).append(row)
    for rows in alike.values():
        item = table.cores[int(core[rows[0]])]
        assert item.hull is not None
        normals, offsets = item.hull.planes()
        if len(normals) < _CLOSED:
            continue
        size = max(1, _AT_ONCE // len(normals))
        for some in (rows[first : first + size] for first in range(0, len(rows), size)):
            result[:, some] = _reach(
                normals, (offsets + item.radius[0])[:, None], local[:, some], ways[..., some]
            )
    return result


def _reach(
    normals: FloatArray, offsets: FloatArray, point: FloatArray, ways: FloatArray
) -> FloatArray:
    """`reach` of n bodies with the same normals (f, 3) of faces, at ``offsets`` (f, n), in
    directions ``ways``; the second half of these is the negative of the first."""
    x, y, z = normals.T[:, :, None]
    room = np.maximum(offsets - (x * point[0] + y * point[1] + z * point[2]), _LEAST)
    half = np.ascontiguousarray(ways[:, : ways.shape[1] // 2].T)
    # How much nearer the next face comes per metre, in parts of the room to it.
    slope = half @ (normals.T / room.T[:, None])
    nearer = np.concatenate([slope.max(axis=2), -slope.min(axis=2)], axis=1).T
    return np.asarray(1.0 / np.maximum(nearer, _LEAST))
