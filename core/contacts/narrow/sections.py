"""The area that two overlapping bodies have in common where their surfaces are made of many small faces: that of a section through it.

Round bodies are given by hulls of many faces, of which any two that face each other are slivers. Where the bodies overlap, the plane across
the normal, midway between their deepest points, cuts both; the area of what lies in both cuts is that of the contact. From the point
between the deepest ones it is seen in directions all around, so the area is a continuous function of the poses.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray
from .cores import CoreTable, Kind
from .frames import dot, turned_back

_ANGLES = 2 * np.pi * np.arange(16) / 16
_POLE = np.array([[0.36], [0.48], [0.8]])
"""Opposite of the one normal at which the directions around it turn quickly: no usual one."""
_ACROSS = np.array([[0.8], [-0.6], [0.0]])
_AROUND = _ACROSS * np.cos(_ANGLES) + np.cross(_POLE, _ACROSS, axis=0) * np.sin(_ANGLES)
"""Unit vectors (3, k) around the pole."""
_CLOSED = 4
"""Faces from which on a hull has an inside; a flat one has a face of its own to lie on."""

_LEAST = 1e-12
"""Metres and slopes below which a face is at the point, and a direction runs along a face."""


def directions(normal: FloatArray) -> FloatArray:
    """Unit vectors (3, k, n) all around each unit normal (3, n)."""
    # The mirror that maps the pole to the opposite of a normal maps what is around the one to what is around the other.
    mirror = normal + _POLE
    mirror = mirror / np.sqrt(np.maximum(dot(mirror, mirror), 1e-12))
    return np.asarray(_AROUND[:, :, None] - 2 * mirror[:, None] * np.einsum("ik,in->kn", _AROUND, mirror)[None])


def section_area(reaches: Sequence[FloatArray]) -> FloatArray:
    """Area (n,) of what two sections have in common that reach so far (k, n) [m] around a point in both."""
    return np.asarray(np.square(np.minimum(*reaches)).sum(axis=0) * (np.pi / len(_ANGLES)))


def reach(table: CoreTable, core: IntArray, rotation: FloatArray, centre: FloatArray, point: FloatArray, around: FloatArray) -> FloatArray:
    """How far (k, n) [m] boxes and hulls, grown by their radii, reach from points (3, n) in them in the directions ``around`` (3, k, n); 0
    for a point outside. ``rotation``, ``centre``: poses of the cores (n,)."""
    local, ways = turned_back(rotation, point - centre), turned_back(rotation, around)
    result = np.zeros(ways.shape[1:])
    for number in np.unique(core).tolist():
        rows = np.flatnonzero(core == number)
        item = table.cores[number]
        if item.kind is Kind.BOX:
            normals, offsets = np.concatenate([np.eye(3), -np.eye(3)]), np.tile(item.outline, 2)
        else:
            assert item.hull is not None
            normals, offsets = item.hull.planes()
            offsets = offsets + item.radius
            if len(normals) < _CLOSED:
                continue
        x, y, z = normals.T[:, :, None]
        place, way = local[:, rows], ways[..., rows][:, :, None]
        room = np.maximum(offsets[:, None] - (x * place[0] + y * place[1] + z * place[2]), _LEAST)
        # How much nearer the faces come per metre, in parts of the room to them (k, faces, n).
        nearer = x / room * way[0] + y / room * way[1] + z / room * way[2]
        result[:, rows] = 1.0 / np.maximum(nearer.max(axis=1), _LEAST)
    return result
