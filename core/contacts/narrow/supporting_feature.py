"""Supporting features: the face, edge or corner of a core that is farthest in a direction, as a
convex polygon."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, taken
from ..hull import Hull, hull_2d
from .cores import CoreTable, Kind
from .frames import cross, dot, pick, turned, turned_back
from .manifold import UNEVEN, contact_plane

FEW = 4
MANY = 16
"""Corners of a polygon: few for boxes, lines and triangles, many for the ends of round cores and
larger faces."""

_WIDTH = 1e-6
"""Half the width [m] of the strip that stands for a line."""

_ALONG = 0.9998
"""Cosine of the angle between a triangle and an uneven face from which on it belongs to it."""
_REFITS = 3
"""Planes that are fitted to an uneven face, one after the other."""

_ANGLES = (2 * np.pi * np.arange(MANY) / MANY)[:, None]
_WIDER = np.sqrt(2 * np.pi / (MANY * np.sin(2 * np.pi / MANY)))
"""Radius of a polygon of ``MANY`` corners that has the area of a circle of radius 1."""

_SQUARE = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])[:, :, None]
_UP = np.array([[0.0], [0.0], [1.0]])


def polygons(
    table: CoreTable,
    core: IntArray,
    rotation: FloatArray,
    centre: FloatArray,
    direction: FloatArray,
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """The supporting features of cores in the world.

    Args:
        table: the cores of all bodies.
        core: numbers of the cores (n,).
        rotation: of the cores (3, 3, n).
        centre: of the cores (3, n) [m].
        direction: unit vectors along which the features are farthest (3, n).

    Returns:
        Corners (3, ``MANY``, n), the last one repeated; which features have more than ``FEW`` of
        them (n,); which are wider than a line (n,).
    """
    count = len(core)
    corners = np.empty((3, MANY, count))
    many = np.zeros(count, dtype=np.bool_)
    wide = np.ones(count, dtype=np.bool_)
    kind = table.kind[core]
    local = turned_back(rotation, direction)
    for value in sorted(set(kind.tolist())):
        rows = (kind == value).nonzero()[0]
        towards = taken(local, rows)
        outline = taken(table.outline, core[rows])
        match Kind(value):
            case Kind.BOX:
                corners[:, :FEW, rows] = box_face(towards, outline)
            case Kind.SEGMENT:
                corners[:, :FEW, rows] = _line(np.zeros_like(towards), _UP * outline[2], towards)
                wide[rows] = False
            case Kind.CYLINDER:
                flat = np.abs(towards[2]) >= np.hypot(towards[0], towards[1])
                corners[..., rows] = _end(
                    outline, np.where(towards[2] < 0, -1.0, 1.0) * outline[2], towards
                )
                side = _radial(towards) * outline[0]
                corners[:, :FEW, rows[~flat]] = _line(side, _UP * outline[2], towards)[..., ~flat]
                many[rows] = wide[rows] = flat
            case Kind.CONE:
                flat, line = _cone(towards, outline)
                corners[..., rows] = _end(outline, -outline[2], towards)
                corners[:, :FEW, rows[~flat]] = line[..., ~flat]
                many[rows] = wide[rows] = flat
            case Kind.HULL:
                for alike, (normals, faces) in _by_hull(table, core[rows]):
                    face = faces[(normals @ towards[:, alike]).argmax(axis=0)].transpose(2, 1, 0)
                    corners[:, : face.shape[1], rows[alike]] = face
                    many[rows[alike]] = face.shape[1] > FEW
            case _:
                wide[rows] = False
                corners[..., rows] = 0.0
    few = np.flatnonzero(~many)
    corners[:, FEW:, few] = corners[:, FEW - 1 : FEW, few]
    return turned(rotation, corners) + centre[:, None], many, wide


def _by_hull(
    table: CoreTable, cores: IntArray
) -> list[tuple[IntArray, tuple[FloatArray, FloatArray]]]:
    """Rows of hulls that are the same, as equal bodies have them, and normals and corners of their
    faces."""
    alike: dict[Hull, list[int]] = {}
    for row, core in enumerate(cores.tolist()):
        hull = table.cores[core].sharp_hull
        assert hull is not None
        alike.setdefault(hull, []).append(row)
    return [(np.array(rows), merged_faces(hull)) for hull, rows in alike.items()]


@lru_cache(4096)
def merged_faces(hull: Hull) -> tuple[FloatArray, FloatArray]:
    """Outward normals (f, 3) and corners in order (f, k, 3) of a hull's faces; short ones repeat
    their last corner, and k is ``FEW`` or ``MANY``. Shared by all trackers."""
    own = list(_faces(hull))
    normals = np.array([normal for normal, _ in own])
    across = np.cross(
        normals, np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    )
    counts = np.array([len(numbers) for _, numbers in own])
    corners = np.empty((len(own), FEW if counts.max() <= FEW else MANY, 3))
    for count in np.unique(counts).tolist():
        faces = np.flatnonzero(counts == count)
        on = hull.points[np.array([own[face][1] for face in faces])]
        apart = on - on.mean(axis=1, keepdims=True)
        angles = np.arctan2(
            np.einsum("fkc,fc->fk", apart, np.cross(normals, across)[faces]),
            np.einsum("fkc,fc->fk", apart, across[faces]),
        )
        chosen = (
            np.linspace(0, count, MANY, endpoint=False)
            if count > MANY
            else np.minimum(np.arange(corners.shape[1]), count - 1)
        )
        corners[faces] = on[
            np.arange(len(on))[:, None],
            angles.argsort(axis=1, kind="stable")[:, chosen.astype(int)],
        ]
    return normals, corners


def _faces(hull: Hull) -> Iterator[tuple[FloatArray, IntArray]]:
    """The normals (3,) of a hull's faces, and the numbers of their corners. A face consists of the
    triangles that lie nearly along it, less than `UNEVEN` beneath its farthest point, or a tenth
    of the hull's width if that is less: real meshes are uneven."""
    corners = hull.points[hull.triangles]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.sqrt((areas * areas).sum(axis=1))
    unit = areas / np.maximum(sizes, 1e-300)[:, None]
    level = 1e-5 * float(np.max(np.ptp(hull.points, axis=0)))
    left = sizes > 0
    for largest in np.argsort(-sizes, kind="stable").tolist():
        if not left[largest]:
            continue
        normal = unit[largest]
        members = np.array([largest])
        for _ in range(_REFITS):
            along = np.flatnonzero(unit @ normal >= _ALONG)
            if len(along) > 1:
                beneath = hull.points @ normal
                beneath = beneath.max() - beneath
                most = max(level, min(UNEVEN, 0.1 * float(beneath.max())))
                along = along[(beneath[hull.triangles[along]] <= most).all(axis=1)]
            if len(along) <= len(members):
                break
            members = along
            total = areas[members].sum(axis=0)
            normal = total / np.sqrt((total * total).sum())
        left[members] = False
        numbers = np.unique(hull.triangles[members])
        if len(numbers) > 3:
            plane = np.concatenate(contact_plane(normal[:, None]), axis=1)
            numbers = numbers[np.sort(hull_2d(hull.points[numbers] @ plane))]
        yield normal, numbers


def box_face(direction: FloatArray, half: FloatArray) -> FloatArray:
    """Corners (3, ``FEW``, n) of the face of a box with half extents (3, n) that lies in
    ``direction`` (3, n)."""
    axis = np.abs(direction).argmax(axis=0)
    corners = np.empty((3, FEW, len(axis)))
    pair = np.arange(len(axis))
    corners[axis, :, pair] = (np.where(pick(direction, axis) < 0, -1.0, 1.0) * pick(half, axis))[
        :, None
    ]
    for k in (1, 2):
        other = (axis + k) % 3
        corners[other, :, pair] = (pick(half, other) * _SQUARE[k - 1]).T
    return corners


def _line(middle: FloatArray, along: FloatArray, direction: FloatArray) -> FloatArray:
    """A narrow strip from ``middle - along`` to ``middle + along`` that faces ``direction``; a dot
    at its end where it points that way."""
    across = cross(along, direction)
    length = np.sqrt(dot(across, across))
    pointing = length < 1e-3 * np.sqrt(dot(along, along))
    if pointing.any():
        tip = along * np.where(dot(along, direction) < 0, -1.0, 1.0)
        u, v = contact_plane(direction)
        middle = np.where(pointing, middle + tip, middle)
        along = np.where(pointing, u * _WIDTH, along)
        across = np.where(pointing, v, across)
        length = np.where(pointing, 1.0, length)
    across = across * (_WIDTH / np.where(length > 0, length, 1.0))
    return np.stack(
        [
            middle - along - across,
            middle + along - across,
            middle + along + across,
            middle - along + across,
        ],
        axis=1,
    )


def _radial(direction: FloatArray) -> FloatArray:
    flat = direction * np.array([[1.0], [1.0], [0.0]])
    length = np.sqrt(dot(flat, flat))
    return np.where(length > 0, flat / np.where(length > 0, length, 1.0), [[1.0], [0.0], [0.0]])


def _end(half: FloatArray, height: FloatArray, direction: FloatArray) -> FloatArray:
    """The disc at a height: a polygon with a corner at the disc's extreme point along
    ``direction``, or with the disc's area where it is nearly perpendicular to ``direction``."""
    out = _radial(direction)
    tipped = np.hypot(direction[0], direction[1]) * half[0] > UNEVEN
    radius = half[0] * np.where(tipped, 1.0, _WIDER)
    corners = np.empty((3, MANY, half.shape[1]))
    corners[0] = radius * (out[0] * np.cos(_ANGLES) - out[1] * np.sin(_ANGLES))
    corners[1] = radius * (out[1] * np.cos(_ANGLES) + out[0] * np.sin(_ANGLES))
    corners[2] = height
    return corners


def _cone(direction: FloatArray, half: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Whether the base faces ``direction``, and the line from rim to tip that faces it
    otherwise."""
    slant = np.hypot(half[0], 2 * half[2])
    by_slant = (np.hypot(direction[0], direction[1]) * 2 * half[2] + direction[2] * half[0]) / slant
    rim = _radial(direction) * half[0] - _UP * half[2]
    tip = _UP * half[2]
    return -direction[2] >= by_slant, _line((rim + tip) / 2, (tip - rim) / 2, direction)
