"""Pairs of bodies that are single boxes: distances and patches in arrays, without pairs of
cores."""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, joined
from ...frozen import frozen
from .body_patches import PairPatches
from .box_axes import axis_normals, best_axes
from .boxes import BoxContacts, box_contacts
from .cores import CoreTable, Kind, Size
from .frames import COLUMN, product, relative, turned, turned_back
from .manifold import patches
from .supporting_feature import box_face


@frozen
class Boxes:
    """Pairs of bodies that are single boxes.

    Attributes:
        rows: (k,) which of the pairs of a query they are.
        rotation, offset: (3, 3, k), (3, k) of the second box in the frame of the first [m].
        half_a, half_b: (3, k) half extents of the first and of the second [m].
        radius_a, radius_b: (k,) by which they are grown [m].
    """

    rows: IntArray
    rotation: FloatArray
    offset: FloatArray
    half_a: FloatArray
    half_b: FloatArray
    radius_a: FloatArray
    radius_b: FloatArray


_AT_ONCE = 4096
"""Most pairs whose contacts are computed at a time, to bound memory: smaller parts cost more in
calls than the cache saves."""


def _contacts(boxes: Boxes, limit: FloatArray) -> BoxContacts:
    """Contacts up to ``limit`` (k,)."""
    count = len(boxes.rows)
    parts = max(1, -(-count // _AT_ONCE))
    found = []
    for k in range(parts):
        part = slice(count * k // parts, count * (k + 1) // parts)
        placed = (
            boxes.rotation[..., part],
            boxes.offset[:, part],
            boxes.half_a[:, part],
            boxes.half_b[:, part],
        )
        found.append(box_contacts(*placed, limit[part]))
    return joined(found)


class BoxPairs:
    """Queries between those bodies of a table that are single boxes. ``is_box`` (n,): which bodies
    are."""

    def __init__(self, table: CoreTable) -> None:
        first = np.minimum(table.start[:-1], max(len(table.kind) - 1, 0))
        self.is_box: BoolArray = (np.diff(table.start) == 1) & (table.kind[first] == Kind.BOX)
        self._all = bool(self.is_box.all())
        self._placed = table.placed
        # By body, for those that are boxes.
        self._sizes = np.concatenate([table.half, table.radius[:, None]], axis=1)[..., first]
        self._authored = table.is_box[first]
        self._all_authored = bool(self._authored.all())
        self._turn = table.rotation[..., first]
        self._shift = table.offset[:, first]
        self._outline = table.outline[:, first]

    def chosen(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray) -> Boxes | None:
        """The ``pairs`` (p, 2), placed as in `NarrowPhase`, whose bodies are both single boxes;
        None without any."""
        first, second = pairs.T
        if self._all:
            rows = np.arange(len(pairs))
        else:
            rows = (self.is_box[first] & self.is_box[second]).nonzero()[0]
            if len(rows) == 0:
                return None
            first = first[rows]
            second = second[rows]
            rotation = rotation[..., rows]
            offset = offset[:, rows]
        if self._placed:
            shift = self._shift[:, second]
            turn_a = self._turn[..., first]
            turn_b = self._turn[..., second]
            offset = turned_back(turn_a, offset + turned(rotation, shift) - self._shift[:, first])
            rotation = relative(turn_a, product(rotation, turn_b))
        size_a, size_b = (self._sizes[Size.SHARP].take(body, axis=1) for body in (first, second))
        if not self._all_authored:
            sharp = self._authored[first] & self._authored[second]
            usual = (self._sizes[Size.USUAL].take(body, axis=1) for body in (first, second))
            size_a, size_b = (
                np.where(sharp, *sizes) for sizes in zip((size_a, size_b), usual, strict=True)
            )
        return Boxes(rows, rotation, offset, size_a[:3], size_b[:3], size_a[3], size_b[3])

    def clearances(self, boxes: Boxes) -> FloatArray:
        """Separations (k,) along the best axes [m]: lower bounds on the distances, positive exactly
        where the boxes are apart."""
        return (
            best_axes(boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b)[0]
            - boxes.radius_a
            - boxes.radius_b
        )

    def directed_clearances(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray
    ) -> tuple[FloatArray, FloatArray] | None:
        """`clearances` and normals (3, p), or None unless all bodies are boxes at their own
        origins."""
        if not self._all or self._placed:
            return None
        boxes = self.chosen(pairs, rotation, offset)
        if boxes is None:
            return None
        placed = boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b
        distance, axis = best_axes(*placed)
        return distance - (boxes.radius_a + boxes.radius_b), axis_normals(axis, *placed)

    def patches(self, boxes: Boxes, pairs: IntArray, limit: FloatArray) -> PairPatches:
        """Patches of ``boxes``, those of ``pairs`` (k, 2) of bodies."""
        radius = boxes.radius_a + boxes.radius_b
        found = _contacts(boxes, limit + radius)
        area, normal, centre = found.area, found.normal, found.centre
        first, second = pairs.T
        if (radius > 0).any():
            area = area * self._flatness(first, second, boxes, normal)
            centre = centre + normal * ((boxes.radius_a - boxes.radius_b) / 2)
        if self._placed:
            turn = self._turn[..., first]
            normal = turned(turn, normal)
            centre = turned(turn, centre) + self._shift[:, first]
        return PairPatches(found.distance - radius, normal, centre, area)

    def corners(
        self, boxes: Boxes, pairs: IntArray, normal: FloatArray, centre: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """The number (k,) of the patch, and the place (3, k), of each corner of the patches of
        ``boxes``, those of ``pairs`` of bodies. ``normal`` and ``centre`` (3, p): of the
        patches."""
        first, second = pairs.T
        if self._placed:
            turn = self._turn[..., first]
            shift = self._shift[:, first]
            normal = turned_back(turn, normal)
            centre = turned_back(turn, centre - shift)
        face_a = box_face(normal, self._outline[:, first]) - centre[:, None]
        face_b = turned(
            boxes.rotation, box_face(-turned_back(boxes.rotation, normal), self._outline[:, second])
        )
        found = patches(face_a, face_b + (boxes.offset - centre)[:, None], normal)
        alone = ~found.used.any(axis=0, keepdims=True)  # no outline, but the centre
        number, corner = np.concatenate([found.used, alone]).T.nonzero()
        places = (
            np.concatenate([found.corners, np.zeros((3, *alone.shape))], axis=1)[:, corner, number]
            + centre[:, number]
        )
        return number, turned(turn[..., number], places) + shift[
            :, number
        ] if self._placed else places

    def _flatness(
        self, first: IntArray, second: IntArray, boxes: Boxes, normal: FloatArray
    ) -> FloatArray:
        """Area (k,) of the smaller of the two faces divided by that of its core, so that rounded
        edges within a box do not reduce the area."""
        ratios = []
        areas = []
        for body, half, way in (
            (first, boxes.half_a, normal),
            (second, boxes.half_b, turned_back(boxes.rotation, normal)),
        ):
            across = np.abs(way).argmax(axis=0) != COLUMN
            areas.append(np.where(across, half, 1.0).prod(axis=0))
            ratios.append(
                np.where(across, self._outline[:, body] / np.maximum(half, 1e-9), 1.0).prod(axis=0)
            )
        return np.asarray(np.where(areas[0] <= areas[1], ratios[0], ratios[1]))
