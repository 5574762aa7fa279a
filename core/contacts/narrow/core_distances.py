"""Distances and nearest points of pairs of cores: closed forms and separating axes where there are
any, else FCL pair by pair."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, chosen_of, joined, taken
from .box_axes import best_axes
from .closed_forms import (
    Separation,
    between,
    point_to_box,
    point_to_triangle,
    segment_to_segment,
    segment_to_triangle,
)
from .convex import ConvexDistances, separations
from .core_pairs import CorePairing, CorePairs
from .cores import CoreTable, Kind, Size
from .deepest import WITHIN, examine_deepest
from .frames import relative, turned, turned_back
from .separating_axes import AxisSeparation, box_to_box, box_to_triangle


class _Placed(NamedTuple):
    """Cores in world space: rotation (3, 3, n), centre (3, n) and half extents (3, n)."""

    rotation: FloatArray
    centre: FloatArray
    half: FloatArray


def _ends(
    rotation: FloatArray, centre: FloatArray, half: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Both ends (3, n) of segments along local z."""
    along = rotation[:, 2] * half[2]
    return centre - along, centre + along


_CLOSED_FORMS: dict[tuple[int, int], Callable[[_Placed, _Placed], Separation]] = {
    (Kind.POINT, Kind.POINT): lambda a, b: between(a.centre, b.centre),
    (Kind.POINT, Kind.SEGMENT): lambda a, b: segment_to_segment(a.centre, a.centre, *_ends(*b)),
    (Kind.POINT, Kind.BOX): lambda a, b: point_to_box(a.centre, *b),
    (Kind.SEGMENT, Kind.SEGMENT): lambda a, b: segment_to_segment(*_ends(*a), *_ends(*b)),
}
"""The function for each pair of kinds whose distance has a closed form."""


class CoreDistances:
    """Distances between the cores of a table."""

    def __init__(self, table: CoreTable, pairing: CorePairing, bodies: ConvexDistances) -> None:
        self._table = table
        self._pairing = pairing
        self._convex = bodies

    def _kinds(self, rows: CorePairs) -> tuple[int, int]:
        return int(self._table.kind[rows.first[0]]), int(self._table.kind[rows.second[0]])

    def in_closed_form(self, rows: CorePairs) -> bool:
        """Whether a group without triangles needs no FCL."""
        kinds = self._kinds(rows)
        return kinds in _CLOSED_FORMS or kinds == (Kind.BOX, Kind.BOX)

    def separated(self, rows: CorePairs, depths: bool = True) -> AxisSeparation:
        """Separations of the cores of one group. Without ``depths``, the distance of cores that
        overlap may be 0."""
        half, (first, second) = self._table.half[Size.USUAL], self._kinds(rows)
        if first == second == Kind.BOX:
            sharp = self._sharp(rows)
            size = np.where(sharp, Size.SHARP, Size.USUAL)
            half_a, half_b = (
                self._table.half[size, :, core].T for core in (rows.first, rows.second)
            )
            rows.radius_a = np.where(
                sharp, self._table.radius[Size.SHARP, rows.first], rows.radius_a
            )
            rows.radius_b = np.where(
                sharp, self._table.radius[Size.SHARP, rows.second], rows.radius_b
            )
            return box_to_box(
                rows.rotation_a, rows.centre_a, half_a, rows.rotation_b, rows.centre_b, half_b
            )
        if (first, second) not in _CLOSED_FORMS:
            return exact(self.by_fcl(rows, depths))
        a = _Placed(rows.rotation_a, rows.centre_a, half[:, rows.first])
        b = _Placed(rows.rotation_b, rows.centre_b, half[:, rows.second])
        return exact(_CLOSED_FORMS[first, second](a, b))

    def from_triangles(self, rows: CorePairs, least: FloatArray) -> tuple[IntArray, AxisSeparation]:
        """Separations of convex cores of one kind from those of the triangles that may make their
        patches, and the numbers of these rows. ``least`` (n,): distance of the bodies at which they
        have sunk into each other as far as they may [m]."""
        assert rows.triangle_b is not None
        kind = self._table.kind[rows.first[0]]
        corners = self._pairing.corners(
            rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b
        )
        half = taken(self._table.half, rows.first)
        if kind == Kind.POINT:
            found = exact(point_to_triangle(rows.centre_a, corners))
        elif kind == Kind.SEGMENT:
            ends = _ends(rows.rotation_a, rows.centre_a, half[Size.USUAL])
            found = exact(segment_to_triangle(*ends, corners))
        elif kind == Kind.BOX:
            found = box_to_triangle(rows.rotation_a, rows.centre_a, half[Size.THICK], corners)
        else:
            return self._deepest_by_fcl(rows, corners, least)
        return np.arange(len(rows)), found

    def _deepest_by_fcl(
        self, rows: CorePairs, corners: FloatArray, least: FloatArray
    ) -> tuple[IntArray, AxisSeparation]:
        """`from_triangles` for cores without a closed form, where FCL takes long for each triangle:
        bounds by the planes of the core leave out most. ``corners`` (3, 3, n): of the triangles."""
        radius = rows.radius_a + rows.radius_b
        bound = np.empty(len(rows))
        for core in np.unique(rows.first).tolist():
            mine = np.flatnonzero(rows.first == core)
            local = turned_back(
                taken(rows.rotation_a, mine),
                taken(corners, mine) - rows.centre_a[:, None, mine],
            )
            normals, offsets = self._convex.core(core, Size.USUAL).some_planes()
            heights = np.einsum("fi,ikn->fkn", normals, local).min(axis=1) - offsets[:, None]
            bound[mine] = heights.max(axis=0, initial=-np.inf)
        numbers = []
        found = []

        def examine(part: IntArray) -> tuple[IntArray, FloatArray]:
            numbers.append(part)
            found.append(self.by_fcl(chosen_of(rows, part)))
            return part, found[-1].distance - radius[part]

        examine_deepest(rows.owner, bound - radius, least, np.full(len(rows), WITHIN), examine)
        chosen = np.concatenate(numbers)
        order = chosen.argsort()
        return chosen[order], exact(chosen_of(joined(found), order))

    def box_gaps(self, rows: CorePairs) -> FloatArray:
        """Lower bounds on the distances (n,) of the cores: those of boxes around them."""
        table = self._table
        turn = relative(rows.rotation_a, rows.rotation_b)
        middle = table.bound_centre
        centre_a, centre_b = (
            centre + turned(rotation, taken(middle, core))
            for core, rotation, centre in (
                (rows.first, rows.rotation_a, rows.centre_a),
                (rows.second, rows.rotation_b, rows.centre_b),
            )
        )
        offset = turned_back(rows.rotation_a, centre_b - centre_a)
        halves = taken(table.bound_half, rows.first), taken(table.bound_half, rows.second)
        return best_axes(turn, offset, *halves)[0]

    def _sharp(self, rows: CorePairs) -> BoolArray:
        """Which rows are of two boxes that meet with sharp edges."""
        table = self._table
        return np.asarray(
            table.is_box[rows.first]
            & table.is_box[rows.second]
            & (table.kind[rows.second] == Kind.BOX)
        )

    def by_fcl(self, rows: CorePairs, depths: bool = True) -> Separation:
        """Separations by FCL, and by EPA where cores overlap."""
        size = Size.USUAL if rows.triangle_b is None else Size.THICK
        first = [self._convex.core(core, size) for core in rows.first.tolist()]
        if rows.triangle_b is None:
            second = [self._convex.core(core, size) for core in rows.second.tolist()]
        else:
            meshes = zip(rows.second.tolist(), rows.triangle_b.tolist(), strict=True)
            second = [
                self._convex.triangle(core, number, self._pairing.mesh(core).corners[number])
                for core, number in meshes
            ]
        for k in np.flatnonzero(self._sharp(rows)).tolist():
            first[k] = self._convex.core(int(rows.first[k]), Size.SHARP)
            second[k] = self._convex.core(int(rows.second[k]), Size.SHARP)
        turn = relative(rows.rotation_a, rows.rotation_b)
        found = separations(
            first, second, turn, turned_back(rows.rotation_a, rows.centre_b - rows.centre_a), depths
        )
        ends = (turned(rows.rotation_a, end) + rows.centre_a for end in (found.first, found.second))
        return Separation(found.distance, turned(rows.rotation_a, found.normal), *ends)


def exact(separation: Separation) -> AxisSeparation:
    """A separation whose distances are all exact."""
    whole = np.ones(len(separation.distance), dtype=np.bool_)
    return AxisSeparation(
        separation.distance, separation.normal, separation.first, separation.second, whole
    )
