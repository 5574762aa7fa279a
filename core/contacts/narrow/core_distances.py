"""Distances and nearest points of pairs of cores: closed forms and separating axes where there are any, else FCL pair by pair."""

from __future__ import annotations

import numpy as np

from ...arrays import BoolArray, FloatArray
from .box_axes import best_axes
from .closed_forms import (
    Separation,
    between,
    point_to_box,
    point_to_cone,
    point_to_cylinder,
    point_to_triangle,
    segment_to_box,
    segment_to_segment,
    segment_to_triangle,
)
from .convex import Convex, ConvexDistances, Size, separations
from .core_pairs import CorePairing, CorePairs
from .cores import CoreTable, Kind
from .frames import relative, turned, turned_back
from .separating_axes import AxisSeparation, box_to_box, box_to_triangle

_CLOSED_FORMS = {
    (Kind.POINT, Kind.POINT),
    (Kind.POINT, Kind.SEGMENT),
    (Kind.POINT, Kind.BOX),
    (Kind.POINT, Kind.CYLINDER),
    (Kind.POINT, Kind.CONE),
    (Kind.SEGMENT, Kind.SEGMENT),
    (Kind.SEGMENT, Kind.BOX),
    (Kind.BOX, Kind.BOX),
}
"""Pairs of kinds that need not go to FCL."""


class CoreDistances:
    """Distances between the cores of a table."""

    def __init__(self, table: CoreTable, pairing: CorePairing) -> None:
        self._table = table
        self._pairing = pairing
        self._convex = ConvexDistances(table)

    def in_closed_form(self, rows: CorePairs) -> bool:
        """Whether a group without triangles needs no FCL."""
        kind = self._table.kind
        return (int(kind[rows.first[0]]), int(kind[rows.second[0]])) in _CLOSED_FORMS

    def separated(self, rows: CorePairs, depths: bool = True) -> AxisSeparation:
        """Separations of the cores of one group. Without ``depths``, some that overlap may be said to be 0 apart."""
        count = len(rows)
        if count == 0:
            empty = np.zeros((3, 0))
            return AxisSeparation(Separation(np.zeros(0), empty, empty, empty), np.ones(0, dtype=np.bool_))
        table = self._table
        half_a, half_b = table.half[:, rows.first], table.half[:, rows.second]
        kinds = Kind(int(table.kind[rows.first[0]])), Kind(int(table.kind[rows.second[0]]))
        match kinds:
            case (Kind.POINT, Kind.POINT):
                return exact(between(rows.centre_a, rows.centre_b))
            case (Kind.POINT, Kind.SEGMENT):
                start, end = _ends(rows.rotation_b, rows.centre_b, half_b)
                return exact(segment_to_segment(rows.centre_a, rows.centre_a, start, end))
            case (Kind.SEGMENT, Kind.SEGMENT):
                ends = (*_ends(rows.rotation_a, rows.centre_a, half_a), *_ends(rows.rotation_b, rows.centre_b, half_b))
                return exact(segment_to_segment(*ends))
            case (Kind.POINT, Kind.BOX):
                return exact(point_to_box(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.POINT, Kind.CYLINDER):
                return exact(point_to_cylinder(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.POINT, Kind.CONE):
                return exact(point_to_cone(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.SEGMENT, Kind.BOX):
                return _segment_and_box(rows, half_a, half_b)
            case (Kind.BOX, Kind.BOX):
                sharp = self._sharp(rows)
                half_a = np.where(sharp, table.sharp_half[:, rows.first], half_a)
                half_b = np.where(sharp, table.sharp_half[:, rows.second], half_b)
                rows.radius_a = np.where(sharp, table.sharp_radius[rows.first], rows.radius_a)
                rows.radius_b = np.where(sharp, table.sharp_radius[rows.second], rows.radius_b)
                return box_to_box(rows.rotation_a, rows.centre_a, half_a, rows.rotation_b, rows.centre_b, half_b)
            case (_, Kind.MESH):
                return self._separated_from_triangles(rows, kinds[0])
        return exact(self.by_fcl(rows, depths))

    def _separated_from_triangles(self, rows: CorePairs, kind: Kind) -> AxisSeparation:
        assert rows.triangle_b is not None
        if kind in (Kind.POINT, Kind.SEGMENT, Kind.BOX):
            corners = self._pairing.corners(rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b)
            if kind is Kind.POINT:
                return exact(point_to_triangle(rows.centre_a, corners))
            if kind is Kind.SEGMENT:
                return exact(segment_to_triangle(*_ends(rows.rotation_a, rows.centre_a, self._table.half[:, rows.first]), corners))
            return box_to_triangle(rows.rotation_a, rows.centre_a, self._table.thick_half[:, rows.first], corners)
        return exact(self.by_fcl(rows))

    def near_by_fcl(self, rows: CorePairs, limit: FloatArray) -> Separation:
        """`by_fcl` of the rows whose bounding boxes are within ``limit`` of each other; lower bounds for the others."""
        table = self._table
        centre_a = rows.centre_a + turned(rows.rotation_a, table.bound_centre[:, rows.first])
        centre_b = rows.centre_b + turned(rows.rotation_b, table.bound_centre[:, rows.second])
        turn, offset = relative(rows.rotation_a, rows.rotation_b), turned_back(rows.rotation_a, centre_b - centre_a)
        bound = best_axes(turn, offset, table.bound_half[:, rows.first], table.bound_half[:, rows.second]).distance
        near = bound <= rows.radius_a + rows.radius_b + limit[rows.owner]
        if near.all():
            return self.by_fcl(rows)
        result = Separation(bound, np.tile([[0.0], [0.0], [1.0]], len(rows)), centre_a, centre_b)
        chosen = np.flatnonzero(near)
        if len(chosen):
            found = self.by_fcl(rows.chosen(chosen))
            for name in ("distance", "normal", "first", "second"):
                getattr(result, name)[..., chosen] = getattr(found, name)
        return result

    def _sharp(self, rows: CorePairs) -> BoolArray:
        """Which rows are of two boxes that meet with sharp edges."""
        table = self._table
        return np.asarray(table.is_box[rows.first] & table.is_box[rows.second] & (table.kind[rows.second] == Kind.BOX))

    def by_fcl(self, rows: CorePairs, depths: bool = True) -> Separation:
        """Separations by FCL, and by EPA where cores overlap."""
        size = Size.CORE if rows.triangle_b is None else Size.THICK
        first, second = (
            self._convex.cores(core.tolist(), size)
            if triangle is None
            else [self._triangle_object(c, t) for c, t in zip(core.tolist(), triangle.tolist(), strict=True)]
            for core, triangle in ((rows.first, rows.triangle_a), (rows.second, rows.triangle_b))
        )
        for k in np.flatnonzero(self._sharp(rows)).tolist():
            first[k] = self._convex.core(int(rows.first[k]), Size.SHARP)
            second[k] = self._convex.core(int(rows.second[k]), Size.SHARP)
        turn = relative(rows.rotation_a, rows.rotation_b)
        found = separations(first, second, turn, turned_back(rows.rotation_a, rows.centre_b - rows.centre_a), depths)
        ends = (turned(rows.rotation_a, end) + rows.centre_a for end in (found.first, found.second))
        return Separation(found.distance, turned(rows.rotation_a, found.normal), *ends)

    def _triangle_object(self, core: int, number: int) -> Convex:
        return self._convex.triangle(core, number, self._pairing.mesh(core).corners[number])


def exact(separation: Separation) -> AxisSeparation:
    """A separation whose distances are all exact."""
    return AxisSeparation(separation, np.ones(len(separation.distance), dtype=np.bool_))


def _ends(rotation: FloatArray, centre: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Both ends (3, n) of segments along local z."""
    along = rotation[:, 2] * half[2]
    return centre - along, centre + along


def _segment_and_box(rows: CorePairs, half_a: FloatArray, half_b: FloatArray) -> AxisSeparation:
    """Exact where they are apart; a segment through a box is a box without width and height."""
    start, end = _ends(rows.rotation_a, rows.centre_a, half_a)
    separation = segment_to_box(start, end, rows.rotation_b, rows.centre_b, half_b)
    through = np.flatnonzero(separation.distance < 1e-9)
    if len(through):
        sides = (rows.rotation_a, rows.centre_a, half_a, rows.rotation_b, rows.centre_b, half_b)
        deep = box_to_box(*(side[..., through] for side in sides)).separation
        for name in ("distance", "normal", "first", "second"):
            getattr(separation, name)[..., through] = getattr(deep, name)
    return exact(separation)
