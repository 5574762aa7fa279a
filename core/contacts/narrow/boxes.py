"""Contacts of pairs of boxes, thousands at a time: separating axes, then the common area of the two
facing faces.

Arrays have the pairs along their last axis, and everything is in the frame of the first box. The
face of the best axis is the rectangle of half edges p and q; the other box's face is a
parallelogram over it. Sums are in a fixed order, so that results do not depend on which pairs are
computed together.
"""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, replace_rows
from ...frozen import frozen
from .box_axes import FIRST_EDGE_AXIS, TURN, best_axes, edge_points
from .frames import dot, pick, turned, turned_back
from .manifold import ROUGHNESS, patch_gap
from .parallelogram import overlap

_FACING = 0.7
"""Cosine of the angle between an edge axis and a face's normal above which the patch is that of the
face (45 degrees)."""

_CERTAIN = 1e-4
"""Metres between a lower and an upper bound on a distance up to which the lower bound counts as the
distance."""

_LEAST_WEIGHT = 1e-3
"""Weight of the nearest points of two edges, or of a sliver, beside corners of either box that are
as near."""

_SLIVER = 0.005
"""Metres of width below which the centre of a patch moves smoothly to the mean of the nearest
corners."""

_BESIDE = 0.02
"""Metres beside the line where two tipped faces touch up to which they count for the place of the
patch along that line, where their gap is at most ``ROUGHNESS``."""

# First rows of the values of two boxes: rotation (9 rows), offset, offset of the first in the frame
# of the second, half extents, 0 and 1.
_OFFSET, _BACK, _HALF_A, _HALF_B, _ZERO, _ONE, _ROWS = 9, 12, 15, 18, 21, 22, 23


def _arrangement(axis: int, facing: int) -> list[int]:
    """The rows of two boxes arranged for a face: ``axis`` 0-2 of the first box, 3-5 of the second,
    under the other box's axis ``facing``.

    The other's directions (2 along its face, then ``facing``) and its place, as the face sees them,
    the face's normal last; half extents of the face's box and of the other; the face's directions
    and its box's place in the frame of the first.
    """
    k = axis % 3
    own = TURN[k + 1 : k + 4].tolist()
    other = TURN[facing + 1 : facing + 4].tolist()
    if axis < 3:
        seen = [3 * m + n for n in other for m in own] + [_OFFSET + m for m in own]
        halves = [_HALF_A + m for m in own] + [_HALF_B + n for n in other]
        return (
            seen + halves + [_ONE if m == c else _ZERO for m in own for c in range(3)] + 3 * [_ZERO]
        )
    seen = [3 * n + m for n in other for m in own] + [_BACK + m for m in own]
    halves = [_HALF_B + m for m in own] + [_HALF_A + n for n in other]
    return (
        seen + halves + [3 * c + m for m in own for c in range(3)] + [_OFFSET + c for c in range(3)]
    )


_ARRANGED = np.array(
    [_arrangement(axis, facing) for axis in range(6) for facing in range(3)]
).T.copy()
_ACROSS = np.array(
    [[3 * k + n for n in range(3)] for k in range(3)]
    + [[3 * n + k for n in range(3)] for k in range(3)]
).T.copy()
"""Rows of the other's three directions along each normal of a face."""

_OUTWARD = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]).T[
    :, :, None
]


_Boxes = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""Pairs of boxes: rotation (3, 3, p) and centre (3, p) of the second in the frame of the first,
half extents (3, p) of both."""


@frozen
class BoxContacts:
    """Per pair: signed ``distance`` (p,), ``normal`` (3, p) from first to second, ``centre`` (3, p)
    of the patch midway between the surfaces, ``area`` (p,), and ``exact`` (p,): False where the
    nearest points are a corner and any point of the other box."""

    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    area: FloatArray
    exact: BoolArray


def box_contacts(
    rotation: FloatArray,
    offset: FloatArray,
    half_a: FloatArray,
    half_b: FloatArray,
    limit: FloatArray,
) -> BoxContacts:
    """Contacts of pairs of boxes.

    Args:
        rotation: of the second box in the frame of the first (3, 3, p).
        offset: its centre there (3, p) [m].
        half_a: half extents of the first (3, p) [m], above 0.
        half_b: half extents of the second (3, p) [m].
        limit: distance beyond which only a lower bound on it is given (p,) [m].
    """
    boxes = rotation, offset, half_a, half_b
    distance, axis = best_axes(*boxes)
    near = (distance <= limit).nonzero()[0]
    count = len(limit)
    if len(near) == count > 0:
        return _near_contacts(distance, axis, boxes)
    result = BoxContacts(
        distance,
        np.zeros((3, count)),
        np.zeros((3, count)),
        np.zeros(count),
        np.ones(count, dtype=np.bool_),
    )
    result.normal[2] = 1.0
    if len(near):
        replace_rows(result, near, _near_contacts(distance[near], axis[near], _rows(near, boxes)))
    return result


def _rows(rows: IntArray, boxes: _Boxes) -> _Boxes:
    """Some of the pairs."""
    rotation, offset, half_a, half_b = boxes
    return (
        rotation.take(rows, axis=2),
        offset.take(rows, axis=1),
        half_a.take(rows, axis=1),
        half_b.take(rows, axis=1),
    )


def _near_contacts(distance: FloatArray, axis: IntArray, boxes: _Boxes) -> BoxContacts:
    """Contacts of boxes from their separation ``distance`` (p,) along their best ``axis`` (p,).
    Where that is across two edges, ``axis`` is replaced by the axis of the face that is nearest to
    it."""
    edges = (axis >= FIRST_EDGE_AXIS).nonzero()[0]
    if len(edges):
        crossing = _rows(edges, boxes)
        points = edge_points(axis[edges], *crossing)
        # Where the faces that the edges belong to are nearly parallel, the patch is theirs.
        alignment = np.abs(np.concatenate([points.normal, turned_back(crossing[0], points.normal)]))
        axis[edges] = face = alignment.argmax(axis=0)
        aligned = pick(alignment, face) > _FACING
    found, thin, lifted = _faces(distance, axis, edges, boxes)
    # Each centre is moved by ``share`` of the way from where the faces overlap to the mean of the
    # nearest corners.
    share = thin * found.exact
    if len(edges):
        patched = aligned & (found.area[edges] > 0)
        # How much the patch of the faces counts: 0 where they overlap elsewhere than at the edges.
        share_of_faces = patched * _nearness(np.abs(lifted[edges]))
        found.exact[edges] = points.within | (found.distance[edges] <= 0)
        share[edges] = np.where(patched, thin[edges], 1.0)
        found.area[edges] *= share_of_faces
        found.normal[:, edges] = points.normal
        middle = (points.first + points.second) / 2
        centre = found.centre[:, edges]
        found.centre[:, edges] = np.where(
            share_of_faces > 0, middle + share_of_faces * (centre - middle), middle
        )
    _move_to_nearest_corners(found, share, boxes)
    return found


def _faces(
    distance: FloatArray, axis: IntArray, edges: IntArray, boxes: _Boxes
) -> tuple[BoxContacts, FloatArray, FloatArray]:
    """Contacts of faces, of the first box where ``axis`` < 3, the parts (p,) by which each is a
    sliver, and how much further apart the faces are than the boxes (p,); where ``edges`` are
    nearest, their distance is left as it is."""
    rotation, offset, half_a, half_b = boxes
    count = len(axis)
    number = np.arange(count)
    rows = np.empty((_ROWS, count))
    np.concatenate(
        [rotation.reshape(9, -1), offset, 0.0 - turned_back(rotation, offset), half_a, half_b],
        out=rows[:_ZERO],
    )
    rows[_ZERO], rows[_ONE] = 0.0, 1.0
    flat = rows.reshape(-1)
    facing = np.abs(flat.take(_ACROSS.take(axis, axis=1) * count + number)).argmax(axis=0)
    arranged = flat.take(_ARRANGED.take(3 * axis + facing, axis=1) * count + number)
    seen = arranged[:12].reshape(4, 3, -1)
    halves = arranged[12:18].reshape(2, 3, -1)
    ways = arranged[18:27].reshape(3, 3, -1)
    face, other = halves
    slope = np.hypot(seen[2, 0], seen[2, 1]) / np.maximum(np.abs(seen[2, 2]), 1e-9)
    side = np.copysign(1.0, seen[3, 2])
    # The other's face in units of the rectangle, each point as (u, v, height above the face).
    seen[:3] *= other[:, None]
    seen[:, :2] /= face[:2]
    seen[:, 2] *= side
    centre = seen[3] - seen[2] * np.copysign(1.0, seen[2, 2])
    centre[2] -= face[2]
    area, place, lowest, found = overlap(centre, seen[:2], patch_gap(slope))
    area *= face[0] * face[1]
    length = np.maximum(halves[:, 0], halves[:, 1])
    thin = np.square(np.maximum(1.0 - area / (2 * _SLIVER * np.minimum(length[0], length[1])), 0.0))
    lifted = lowest[2] - distance
    exact = found & ((lifted <= _CERTAIN) | (distance <= 0))
    rows = ((thin > 0) & exact).nonzero()[0]
    if len(rows):
        tipped = seen[:, :, rows]
        place[:, rows] += thin[rows] * _along_line(
            (centre[:, rows], tipped[:2], lowest[:, rows]),
            np.array([-tipped[2, 1] * face[1, rows], tipped[2, 0] * face[0, rows]]),
            slope[rows],
            face[:2, rows],
            place[:, rows],
        )
    lift = np.maximum(lifted, 0.0) * (exact & (distance > 0))
    lift[edges] = 0.0
    distance = distance + lift
    height = side * (face[2] + distance / 2)
    middle = (
        ways[0] * (place[0] * face[0])
        + ways[1] * (place[1] * face[1])
        + ways[2] * height
        + arranged[27:]
    )
    normal = ways[2] * (side * _OUTWARD.take(axis))
    return BoxContacts(distance, normal, middle, area, exact), thin, lifted


def _along_line(
    other: tuple[FloatArray, FloatArray, FloatArray],
    line: FloatArray,
    slope: FloatArray,
    face: FloatArray,
    place: FloatArray,
) -> FloatArray:
    """The way (2, p) along which the centre of a sliver of contact is moved to that of a broader
    overlap of the two faces, along the line on which they touch. The centre of the sliver itself is
    unstable: it moves by half the sliver's length as the line tilts by 1e-3 rad.

    Args:
        other: face in units of the rectangle, as `overlap` takes it: its centre (3, p), half edges
            (2, 3, p) and lowest point (3, p).
        line: direction of the line over the rectangle (2, p), of any length.
        slope: of the other face over the rectangle (p,).
        face: half edges of the rectangle (2, p) [m].
        place: centre of the sliver, in units of the rectangle (2, p), as is the result.
    """
    within = np.maximum(np.minimum(_BESIDE * slope, ROUGHNESS), patch_gap(slope))
    centre, sides, lowest = other
    broader = overlap(centre, sides, within, lowest)[1]
    along = dot(line, (broader - place) * face) / np.maximum(dot(line, line), 1e-300)
    return line * along / face


def _nearness(excess: FloatArray) -> FloatArray:
    """Weights of points that are ``excess`` metres further apart than the nearest ones: 1 at 0, 0
    from ``ROUGHNESS`` on."""
    return np.minimum(np.maximum(1.0 - excess / ROUGHNESS, 0.0), 1.0)


@frozen
class _Corners:
    """The corners of two boxes, those of the second first: ``place`` (2, 3, 8, p), each in the
    frame of the other box, the way ``across`` from there to the nearest point of the other box, and
    its length ``distance`` (2, 8, p). ``half`` (2, 3, p): of the other boxes."""

    rotation: FloatArray
    offset: FloatArray
    half: FloatArray
    place: FloatArray
    across: FloatArray
    distance: FloatArray

    @classmethod
    def of(
        cls, rotation: FloatArray, offset: FloatArray, half_a: FloatArray, half_b: FloatArray
    ) -> _Corners:
        """The corners of all pairs."""
        ways = np.array([rotation.transpose(1, 0, 2) * half_b[:, None], rotation * half_a[:, None]])
        place = (
            np.array([offset, -turned_back(rotation, offset)])[:, :, None]
            + _CORNERS[0] * ways[:, 0, :, None]
        )
        place += _CORNERS[1] * ways[:, 1, :, None]
        place += _CORNERS[2] * ways[:, 2, :, None]
        half = np.array([half_a, half_b])
        across = np.minimum(np.maximum(place, -half[:, :, None]), half[:, :, None])
        across -= place
        squared = across * across
        return cls(
            rotation,
            offset,
            half,
            place,
            across,
            np.sqrt(squared[:, 0] + squared[:, 1] + squared[:, 2]),
        )

    def depth(self, normal: FloatArray) -> FloatArray:
        """How far (2, 8, p) the corners are outside the other boxes along the ``normal`` (3, p)."""
        outward: FloatArray = np.array([normal, -turned_back(self.rotation, normal)])
        height = outward[:, :, None] * self.place
        extent = np.abs(outward) * self.half
        height[:, 0] += height[:, 1]
        height[:, 0] += height[:, 2]
        return height[:, 0] - (extent[:, 0] + extent[:, 1] + extent[:, 2])[:, None]

    def middles(self, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sum (3, p) of the points midway to the other boxes by their ``weight`` (2, 8, p), and of
        the weights (p,)."""
        terms = np.empty((2, 4, *weight.shape[1:]))
        np.multiply(self.across, 0.5, out=terms[:, :3])
        terms[:, :3] += self.place
        terms[:, :3] *= weight[:, None]
        terms[:, 3] = weight
        of_b, of_a = _added(terms)
        return of_b[:3] + (turned(self.rotation, of_a[:3]) + self.offset * of_a[3]), of_b[3] + of_a[
            3
        ]

    def ways(self, weight: FloatArray) -> FloatArray:
        """Sum (3, p) of the ways from the first box to the second by their ``weight`` (2, 8, p)."""
        of_b, of_a = _added(self.across * weight[:, None])
        return np.asarray(turned(self.rotation, of_a) - of_b)


def _added(terms: FloatArray) -> FloatArray:
    """Sums (..., p) of the eight in each (..., 8, p)."""
    terms = terms[..., :4, :] + terms[..., 4:, :]
    terms = terms[..., :2, :] + terms[..., 2:, :]
    return terms[..., 0, :] + terms[..., 1, :]


def _move_to_nearest_corners(found: BoxContacts, share: FloatArray, boxes: _Boxes) -> None:
    """Move each centre ``found`` by ``share`` (p,) of the way to the mean of the corners whose
    distance to the other box, or depth in it along the normal, is nearly the least; this mean lies
    in the plane of the centre, which counts the more the farther apart the nearest corner is.

    Completes the contacts that are not exact: boxes apart whose nearest points are a corner of one
    and any point of the other. Parallel edges that face each other are equally near all along; the
    centre is the mean of all the corners that are as near.
    """
    rows = ((share > 0) | ~found.exact).nonzero()[0]
    if len(rows) == 0:
        return
    corners = _Corners.of(*_rows(rows, boxes))
    least = found.distance[rows]
    normal = found.normal.take(rows, axis=1)
    middle = found.centre.take(rows, axis=1)
    exact = found.exact[rows]
    part = share[rows]
    if not exact.all():
        least = np.where(exact, least, corners.distance.min(axis=(0, 1)))
        way = corners.ways(
            _nearness(corners.distance - least) / np.maximum(corners.distance, 1e-12)
        )
        length = np.sqrt(dot(way, way))
        normal = np.where(exact | (length == 0), normal, way / np.where(length > 0, length, 1.0))
        part = np.where(exact, part, 1.0)
        found.distance[rows], found.normal[:, rows] = least, normal
        found.area[rows] *= exact
    # 0 for corners that are past the other box.
    beside = np.maximum(1.0 - corners.distance / ROUGHNESS, 0.0)
    depth = np.minimum(corners.depth(normal), 0.0) * (beside * exact)
    near = _nearness(corners.distance + depth - least)
    total, weight = corners.middles(near)
    own = np.maximum(_LEAST_WEIGHT, 1.0 - near.max(axis=(0, 1))) * exact
    mean = (own * middle + total) / (own + weight)
    mean += normal * (dot(normal, middle - mean) * exact)
    found.centre[:, rows] = middle + part * (mean - middle)
