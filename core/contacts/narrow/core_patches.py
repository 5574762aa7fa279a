"""Contact patches of pairs of cores: the polygons of their facing features, intersected."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, chosen_of, taken
from .closed_forms import Separation
from .core_pairs import CorePairing, CorePairs
from .cores import CoreTable, Kind
from .manifold import PATCH_GAP, ROUGHNESS, Patches, patches
from .sections import directions, reach, section_area
from .supporting_feature import FEW, MANY, polygons

_DRAWN_ROUGHLY = np.array([Kind.CYLINDER <= kind <= Kind.HULL for kind in Kind])
"""By kind: those whose supporting features are approximated by polygons with fewer corners."""

_NEAR = 1e-3
"""Metres from the nearest points of two cores within which their patch must lie."""


_TOGETHER = 64
"""Number of pairs up to which polygons of few corners count as those of many: one call takes less
time than several."""


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
        first, many_a, wide_a = self._polygons(
            rows.first, rows.triangle_a, rows.rotation_a, rows.centre_a, normal
        )
        second, many_b, wide_b = self._polygons(
            rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b, -normal
        )
        first -= middle[:, None]
        second -= middle[:, None]
        gap = ROUGHNESS if rows.triangle_b is None else PATCH_GAP
        if count <= _TOGETHER:
            many_a[:], many_b[:] = many_a.any(), many_b.any()
        parts = []
        for corners_a, corners_b in ((FEW, FEW), (MANY, FEW), (FEW, MANY), (MANY, MANY)):
            alike = np.flatnonzero(
                (many_a == (corners_a == MANY)) & (many_b == (corners_b == MANY))
            )
            if len(alike):
                parts.append(
                    (
                        alike,
                        patches(
                            taken(first[:, :corners_a], alike),
                            taken(second[:, :corners_b], alike),
                            taken(normal, alike),
                            gap,
                        ),
                    )
                )
        result = _merged(count, parts)
        drawn = np.where(rows.triangle_a is None, self._table.kind[rows.first], Kind.MESH)
        kind = np.maximum(drawn, self._table.kind[rows.second])
        result = _at_nearest_points(result, _DRAWN_ROUGHLY[kind])
        area = result.area
        simpler = self._table.kind[rows.first]
        faceted = (self._table.kind[rows.second] == Kind.HULL) & (
            (simpler == Kind.BOX) | (simpler == Kind.HULL)
        )
        if faceted.any():
            some = chosen_of(rows, faceted)
            place = taken(middle, faceted)
            around = directions(taken(normal, faceted))
            reaches = [
                reach(self._table, core, rotation, centre, place, around)
                for core, rotation, centre in (
                    (some.first, some.rotation_a, some.centre_a),
                    (some.second, some.rotation_b, some.centre_b),
                )
            ]
            area[faceted] = np.maximum(area[faceted], section_area(reaches))
        return replace(
            result,
            centre=middle + result.centre,
            area=area,
            corners=middle[:, None] + result.corners,
            wide=wide_a & wide_b,
        )

    def _polygons(
        self,
        core: IntArray,
        triangle: IntArray | None,
        rotation: FloatArray,
        centre: FloatArray,
        direction: FloatArray,
    ) -> tuple[FloatArray, BoolArray, BoolArray]:
        """The supporting features of cores, or the triangles that stand for them: see `polygons`.

        Args:
            core: numbers of the cores (n,).
            triangle: number of the triangle of each mesh (n,), None without meshes.
            rotation: of the cores (3, 3, n).
            centre: of the cores (3, n) [m].
            direction: towards the other core, unit vectors (3, n).
        """
        if triangle is None:
            return polygons(self._table, core, rotation, centre, direction)
        corners = self._pairing.corners(core, triangle, rotation, centre)
        return corners, np.zeros(len(core), dtype=np.bool_), np.ones(len(core), dtype=np.bool_)


def _at_nearest_points(patch: Patches, rough: BoolArray) -> Patches:
    """Patches around the origin, the nearest points of their cores; ``rough`` ones that miss it
    moved there."""
    low = np.where(patch.used, patch.corners, np.inf).min(axis=1)
    high = np.where(patch.used, patch.corners, -np.inf).max(axis=1)
    keep = ~(rough & patch.found & ((low > _NEAR) | (high < -_NEAR)).any(axis=0))
    return replace(
        patch, centre=patch.centre * keep, area=patch.area * keep, corners=patch.corners * keep
    )


def _merged(count: int, parts: list[tuple[IntArray, Patches]]) -> Patches:
    """Results for parts of ``count`` rows put together, shorter rows of corners filled up."""
    if len(parts) == 1:
        return parts[0][1]
    merged = []
    for field in fields(Patches):
        values = [getattr(part, field.name) for _, part in parts]
        whole = np.zeros((*max(value.shape[:-1] for value in values), count), dtype=values[0].dtype)
        for (rows, _), value in zip(parts, values, strict=True):
            part: tuple[Any, ...] = (*(slice(size) for size in value.shape[:-1]), rows)
            whole[part] = value
        merged.append(whole)
    return Patches(*merged)
