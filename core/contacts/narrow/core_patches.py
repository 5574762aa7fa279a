"""Contact patches of pairs of cores: the polygons of their facing features, intersected."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, some_of, taken
from .closed_forms import Separation
from .core_pairs import CorePairing, CorePairs
from .cores import CoreTable, Kind
from .manifold import Patches, for_both, patches
from .sections import directions, reach, section_area
from .supporting_feature import FEW, MANY, polygons

_DRAWN_ROUGHLY = np.array([Kind.CYLINDER <= kind <= Kind.HULL for kind in Kind])
"""By kind: those whose supporting features are approximated by polygons with fewer corners."""

_NEAR = 1e-3
"""Metres from the nearest points of two cores within which their patch must lie."""

_Polygons = tuple[FloatArray, BoolArray, BoolArray]
"""What `polygons` returns."""


class CorePatches:
    """Patches between the cores of a table."""

    def __init__(self, table: CoreTable, pairing: CorePairing) -> None:
        self._table = table
        self._pairing = pairing

    def patches(self, rows: CorePairs, separation: Separation) -> Patches:
        """Patches of rows of one group, their centres and corners in the world."""
        normal = separation.normal
        middle = (
            separation.first + normal * rows.radius_a + separation.second - normal * rows.radius_b
        ) / 2
        count = len(rows)
        if self._table.kind[rows.first[0]] == Kind.POINT:
            none = np.zeros(count, dtype=np.bool_)
            return Patches(
                middle,
                np.zeros(count),
                none,
                np.zeros(count),
                middle[:, None],
                none[None],
                none,
                np.zeros(count),
            )
        (first, many_a, wide_a), (second, many_b, wide_b) = self._polygons(rows, normal)
        first -= middle[:, None]
        second -= middle[:, None]
        most_a, most_b = (MANY if many.any() else FEW for many in (many_a, many_b))
        result = patches(first[:, :most_a], second[:, :most_b], normal)
        drawn = np.where(rows.triangle_a is None, self._table.kind[rows.first], Kind.MESH)
        kind = np.maximum(drawn, self._table.kind[rows.second])
        missing = _DRAWN_ROUGHLY[kind] & _misses_nearest_points(result)
        centre, area, outline = result.centre, result.area, result.corners
        if missing.any():
            centre, area, outline = centre * ~missing, area * ~missing, outline * ~missing
        simpler = self._table.kind[rows.first]
        faceted = (self._table.kind[rows.second] == Kind.HULL) & (
            (simpler == Kind.BOX) | (simpler == Kind.HULL)
        )
        if faceted.any():
            some = some_of(rows, faceted)
            place = taken(middle, faceted)
            around = directions(taken(normal, faceted))
            (reach_a,), (reach_b,) = for_both(
                lambda *cores: (reach(self._table, *cores),),
                (some.first, some.rotation_a, some.centre_a, place, around),
                (some.second, some.rotation_b, some.centre_b, place, around),
            )
            area[faceted] = np.maximum(area[faceted], section_area(reach_a, reach_b))
        return replace(
            result,
            centre=middle + centre,
            area=area,
            corners=middle[:, None] + outline,
            wide=wide_a & wide_b,
        )

    def _polygons(self, rows: CorePairs, normal: FloatArray) -> tuple[_Polygons, _Polygons]:
        """The supporting features of the first and of the second cores, or the triangles that stand
        for them: see `polygons`. ``normal`` (3, n): from first to second."""
        a = rows.first, rows.rotation_a, rows.centre_a, normal
        b = rows.second, rows.rotation_b, rows.centre_b, -normal
        if rows.triangle_a is None and rows.triangle_b is None:
            return for_both(partial(polygons, self._table), a, b)
        return self._drawn(rows.triangle_a, *a), self._drawn(rows.triangle_b, *b)

    def _drawn(
        self,
        triangle: IntArray | None,
        core: IntArray,
        rotation: FloatArray,
        centre: FloatArray,
        direction: FloatArray,
    ) -> _Polygons:
        """The supporting features of cores, or the triangles that stand for them.

        Args:
            triangle: number of the triangle of each mesh (n,), None without meshes.
            core: numbers of the cores (n,).
            rotation: of the cores (3, 3, n).
            centre: of the cores (3, n) [m].
            direction: towards the other core, unit vectors (3, n).
        """
        if triangle is None:
            return polygons(self._table, core, rotation, centre, direction)
        corners = self._pairing.corners(core, triangle, rotation, centre)
        return corners, np.zeros(len(core), dtype=np.bool_), np.ones(len(core), dtype=np.bool_)


def _misses_nearest_points(patch: Patches) -> BoolArray:
    """Which patches (n,) miss the origin, where the nearest points of their cores are: rough ones
    belong there."""
    low = np.where(patch.used, patch.corners, np.inf).min(axis=1)
    high = np.where(patch.used, patch.corners, -np.inf).max(axis=1)
    return np.asarray(patch.found & ((low > _NEAR) | (high < -_NEAR)).any(axis=0))
