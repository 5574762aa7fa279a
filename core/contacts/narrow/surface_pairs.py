"""Contacts of surfaces: of two meshes, a mesh and a hull, and of a convex core inside a mesh.

FCL tells how far two surfaces are apart. Where they are near, the triangles about the nearest
points make the patch. Where solids have passed through each other, the faces that look at each
other do, as deep as they have passed. A body wholly inside a solid is as if in a wall as thick as
bodies may sink in, so that distances are continuous from outside to the far side of that wall.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import BoolArray, FloatArray, chosen_of
from .body_patches import CoreContacts, core_contacts
from .closed_forms import nearest_on_triangle
from .convex import ConvexDistances
from .core_pairs import CorePairing, CorePairs
from .core_patches import CorePatches
from .cores import CoreTable, Kind, Size
from .frames import dot
from .manifold import PATCH_GAP, Patches, patches
from .surfaces import Surface, Surfaces
from .triangles import beside, facing_axes, triangle_to_triangle, unit_normals

_REACH = 1.1 * PATCH_GAP
"""Metres beyond the least distance within which triangles belong to the patch."""

_TOUCHING = 1e-7
"""Metres of distance up to which surfaces may cross."""

_OPPOSITE = -1e-3
"""Cosine between the normals of two faces below which they look at each other."""


@dataclass(frozen=True, slots=True)
class _Gap:
    """How far apart two cores are, 0 where they overlap, and their nearest points in the world."""

    distance: float
    first: FloatArray
    second: FloatArray


@dataclass(frozen=True, slots=True)
class _Deep:
    """Pair number ``row`` of surfaces, which cross, or of which one is inside the other: how far it
    may sink in at most, as the distance ``deepest`` < 0, and the distance ``least`` of one inside,
    NaN where they cross."""

    row: int
    gap: _Gap
    deepest: float
    least: float


class SurfacePairs:
    """Pairs of cores of a table of which the second is a mesh."""

    def __init__(
        self,
        table: CoreTable,
        pairing: CorePairing,
        surfaces: Surfaces,
        bodies: ConvexDistances,
        patches: CorePatches,
    ) -> None:
        self._table = table
        self._pairing = pairing
        self._surfaces = surfaces
        self._bodies = bodies
        self._patches = patches

    def _is_surface(self, core: int) -> bool:
        return bool(self._table.kind[core] >= Kind.HULL)

    def gaps(self, rows: CorePairs, solid: bool = False) -> tuple[FloatArray, FloatArray]:
        """Distances (n,) of the cores, 0 where they overlap, and normals (3, n) from first to
        second. ``solid``: what is inside a hull overlaps it."""
        found = [self._gap(rows, k, solid) for k in range(len(rows))]
        way = np.array([gap.second - gap.first for gap in found]).T
        length = np.sqrt(dot(way, way))
        return np.array([gap.distance for gap in found]), way / np.where(length > 0, length, 1.0)

    def _gap(self, rows: CorePairs, k: int, solid: bool = False) -> _Gap:
        """The gap of pair ``k``. FCL gives the nearest points right only where the mesh comes
        first, and never those of spheres."""
        import fcl

        first, second = int(rows.first[k]), int(rows.second[k])
        turn, place = rows.rotation_b[..., k], rows.centre_b[:, k]
        other: Any = (
            self._convex(first) if solid or not self._is_surface(first) else self._surfaces[first]
        )
        other.second.setRotation(np.ascontiguousarray(turn.T @ rows.rotation_a[..., k]))
        other.second.setTranslation(turn.T @ (rows.centre_a[:, k] - place))
        result = fcl.DistanceResult()
        distance = float(
            fcl.distance(
                self._surfaces[second].first,
                other.second,
                fcl.DistanceRequest(enable_nearest_points=True),
                result,
            )
        )
        on_mesh, on_other = (turn @ np.asarray(point) + place for point in result.nearest_points)
        return _Gap(
            max(distance, 0.0),
            rows.centre_a[:, k] if self._table.kind[first] == Kind.POINT else on_other,
            on_mesh,
        )

    def _convex(self, core: int) -> Any:
        if self._table.kind[core] == Kind.MESH:
            return self._surfaces[core]
        return self._bodies.core(
            core, Size.THICK if self._table.kind[core] == Kind.BOX else Size.USUAL
        )

    def contacts(
        self,
        rows: CorePairs,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """Add the contacts of pairs of surfaces within ``limit`` (p,) of the pairs of bodies to
        ``found``, and lower bounds on the others to ``distance`` (p,)."""
        # Numbers of the pairs, and how far their triangles may be from each other.
        apart: dict[int, float] = {}
        deep: list[_Deep] = []
        for k in range(len(rows)):
            a, b = self._surfaces[int(rows.first[k])], self._surfaces[int(rows.second[k])]
            owner, radius = int(rows.owner[k]), float(rows.radius_a[k] + rows.radius_b[k])
            gap = self._gap(rows, k)
            least, most = gap.distance - radius, _most(a, b)
            if gap.distance <= _TOUCHING:
                if most > 0:
                    deep.append(_Deep(k, gap, -most, np.nan))
                else:
                    apart[k] = _REACH
                continue
            around = (
                self._around(chosen_of(rows, np.array([k])), a, b)
                if most > 0 and least - most <= limit[owner]
                else 0.0
            )
            if least - most > limit[owner] or around > 0:
                least -= most if np.isfinite(around) else gap.distance + most
            if least > limit[owner]:
                distance[owner] = min(distance[owner], least)
            elif around > 0:
                deep.append(_Deep(k, gap, -most, least))
            else:
                apart[k] = gap.distance + _REACH
        if deep:
            apart.update(dict.fromkeys(self._passed_through(rows, deep, found, corners), _REACH))
        if apart:
            numbers = np.array(list(apart))
            near = self._pairing.near_triangles(
                chosen_of(rows, numbers), np.array(list(apart.values()))
            )
            self._lying(near, limit, distance, found, corners)

    def meet(self, rows: CorePairs) -> BoolArray:
        """Which pairs (n,) meet as surfaces: two meshes, or a hull and a solid mesh."""
        meshes = self._table.kind[rows.first] == Kind.MESH
        if self._table.kind[rows.first[0]] != Kind.HULL:
            return np.asarray(meshes)
        return np.array(
            [self._surfaces[core].depth > 0 for core in rows.second.tolist()], dtype=np.bool_
        )

    def near(self, rows: CorePairs, limit: FloatArray) -> CorePairs:
        """Convex cores of one kind on the triangles within ``limit`` (p,) metres of each; where a
        pair takes long, on those that can belong to its patch."""
        reach = limit[rows.owner]
        if self._table.kind[rows.first[0]] >= Kind.CYLINDER:
            gap = self.gaps(rows, solid=True)[0]
            reach = np.where(
                gap > 0, np.minimum(gap - rows.radius_a - rows.radius_b + _REACH, reach), reach
            )
        return self._pairing.on_triangles(rows, reach)

    def inside(
        self, rows: CorePairs, limit: FloatArray, distance: FloatArray, found: list[CoreContacts]
    ) -> BoolArray:
        """Which convex cores (n,) have their middle inside the solid they are paired with. Adds
        their contacts as `contacts` does."""
        chosen = np.zeros(len(rows), dtype=np.bool_)
        for k in np.flatnonzero(np.isfinite(self.deepest(rows))).tolist():
            row = chosen_of(rows, np.array([k]))
            mesh = self._surfaces[int(row.second[0])]
            turn, place = row.rotation_b[..., 0], row.centre_b[:, 0]
            centre = (row.centre_a[:, 0] - place) @ turn
            if not (
                (centre > mesh.low).all()
                and (centre < mesh.high).all()
                and mesh.contains(centre[None])[0]
            ):
                continue
            chosen[k] = True
            owner, radius = int(row.owner[0]), float(row.radius_a[0] + row.radius_b[0])
            least = max(self._gap(row, 0).distance - radius, 0.0) + float(self.deepest(row)[0])
            distance[owner] = min(distance[owner], max(least, limit[owner]))
            if least <= limit[owner]:
                corners = mesh.index.corners.transpose(2, 1, 0)
                nearest = nearest_on_triangle(
                    np.repeat(centre[:, None], corners.shape[2], axis=1), corners
                )
                way = nearest - centre[:, None]
                best = int(dot(way, way).argmin())
                found.append(
                    _point(row, least, -turn @ way[:, best], turn @ nearest[:, best] + place)
                )
        return chosen

    def deepest(self, rows: CorePairs) -> FloatArray:
        """The least distance (n,) of convex cores from their meshes: how far they may sink in,
        -infinity from a shell."""
        table = self._table
        thin = 2 * (table.bound_half[:, rows.first].min(axis=0) + rows.radius_a)
        cores, of = np.unique(rows.second, return_inverse=True)
        meshes = [self._surfaces[core] for core in cores.tolist()]
        depth, size = (
            np.array([(mesh.depth, mesh.size) for mesh in meshes])
            .reshape(-1, 2)
            .T[:, of.reshape(-1)]
        )
        return np.where(depth > 0, -np.minimum(depth, np.minimum(thin, size) / 2), -np.inf)

    def _around(self, row: CorePairs, a: Surface, b: Surface) -> float:
        """The depth of the solid that encloses the other surface, 0 where neither does."""
        for outer, inner, outer_pose, inner_pose in (
            (a, b, (row.rotation_a, row.centre_a), (row.rotation_b, row.centre_b)),
            (b, a, (row.rotation_b, row.centre_b), (row.rotation_a, row.centre_a)),
        ):
            turn, place = (pose[..., 0] for pose in outer_pose)
            point = (
                inner_pose[0][..., 0] @ inner.index.corners[0, 0] + inner_pose[1][:, 0] - place
            ) @ turn
            if (
                outer.depth > 0
                and (point > outer.low).all()
                and (point < outer.high).all()
                and outer.contains(point[None])[0]
            ):
                return outer.depth
        return 0.0

    def _corners(self, rows: CorePairs) -> tuple[FloatArray, FloatArray]:
        assert rows.triangle_a is not None and rows.triangle_b is not None
        first = self._pairing.corners(rows.first, rows.triangle_a, rows.rotation_a, rows.centre_a)
        return first, self._pairing.corners(
            rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b
        )

    def _lying(
        self,
        rows: CorePairs,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """Surfaces that are apart, and such that cross where no faces look at each other."""
        first, second = self._corners(rows)
        separation = triangle_to_triangle(first, second)
        # Where they touch, the outer sides of the two are towards each other.
        outwards = dot(separation.normal, unit_normals(first) - unit_normals(second))
        turns = (separation.distance <= _TOUCHING) & (outwards < 0)
        separation = replace(
            separation, normal=np.where(turns, -separation.normal, separation.normal)
        )
        gap = separation.distance - rows.radius_a - rows.radius_b
        near = (gap <= limit[rows.owner]).nonzero()[0]
        np.minimum.at(distance, rows.owner, np.maximum(gap, limit[rows.owner]))
        if len(near):
            rows, separation = chosen_of(rows, near), chosen_of(separation, near)
            patch = self._patches.patches(rows, separation)
            found.append(core_contacts(rows, separation.normal, gap[near], patch, corners))

    def _passed_through(
        self, pairs: CorePairs, deep: list[_Deep], found: list[CoreContacts], corners: bool
    ) -> list[int]:
        """Solids whose surfaces cross, or of which one is inside the other. Returns the numbers of
        the pairs that cross where no faces look at each other."""
        several = chosen_of(pairs, np.array([pair.row for pair in deep]))
        deepest, least = np.array([[pair.deepest, pair.least] for pair in deep]).T
        rows = self._pairing.near_triangles(
            replace(several, owner=np.arange(len(deep))), _REACH - 2 * deepest
        )
        number, rows = rows.owner, replace(rows, owner=several.owner[rows.owner])
        first, second = self._corners(rows)
        depths = np.array(
            [
                [self._surfaces[core].depth for core in cores]
                for cores in zip(several.first, several.second, strict=True)
            ]
        ).T
        solid_a, solid_b = depths[:, number] > 0
        normal_a, normal_b = unit_normals(first), unit_normals(second)
        against = dot(normal_a, normal_b)
        # A shell has no outside: both sides of it are looked at.
        turned = (~solid_a | ~solid_b) & (against > 0)
        normal_a = np.where(~solid_a & turned, -normal_a, normal_a)
        normal_b = np.where(~solid_b & turned, -normal_b, normal_b)
        chosen = (
            (dot(normal_a, normal_b) < _OPPOSITE)
            & ~beside(first, second, normal_a)
            & ~beside(second, first, normal_b)
        ).nonzero()[0]
        rows, number, first, second = (
            chosen_of(rows, chosen),
            number[chosen],
            first[..., chosen],
            second[..., chosen],
        )
        normal_a, normal_b, turned = normal_a[:, chosen], normal_b[:, chosen], turned[chosen]
        separation, axis = facing_axes(first, second, normal_a, normal_b)
        middle = (first.sum(axis=1) + second.sum(axis=1)) / 6
        patch = patches(first - middle[:, None], second - middle[:, None], axis)
        patch = replace(
            patch, centre=middle + patch.centre, corners=middle[:, None] + patch.corners
        )
        depth = separation + np.where(patch.found, patch.gap, 0.0)
        ends = [
            patch.centre + axis * (dot(corners[:, 0] - patch.centre, normal) / dot(axis, normal))
            for corners, normal in ((first, normal_a), (second, normal_b))
        ]
        beyond = dot(axis, ends[1] - ends[0])  # at the middle of the patch
        patch = replace(patch, centre=(ends[0] + ends[1]) / 2)
        valid, again = patch.found & (depth < _REACH), []
        for k, pair in enumerate(deep):
            mine = np.flatnonzero((number == k) & valid)
            under = mine[beyond[mine] < -_TOUCHING]
            valid[under] = self._overlap(
                chosen_of(several, np.array([k])), ends[0][:, under], ends[1][:, under]
            )
            through = [under[valid[under] & (turned[under] == side)] for side in (False, True)]
            if len(through[0]) and len(through[1]):  # a shell inside a wall: the shorter way out
                valid[max(through, key=lambda way: float(-depth[way].min()))] = False
            if np.isfinite(pair.least):
                valid[mine[beyond[mine] >= 0]] = False
            if not valid[mine].any():
                if np.isfinite(pair.least):
                    found.append(_inside(chosen_of(several, np.array([k])), pair))
                else:
                    again.append(pair.row)
        deepest, least = deepest[number], least[number]
        distance = np.where(
            np.isfinite(least), least, np.maximum(depth, deepest) - rows.radius_a - rows.radius_b
        )
        kept = valid.nonzero()[0]
        if len(kept):
            found.append(
                core_contacts(
                    chosen_of(rows, kept),
                    axis[:, kept],
                    distance[kept],
                    chosen_of(patch, kept),
                    corners,
                )
            )
        return again

    def _both(self, row: CorePairs) -> tuple[Surface, Surface]:
        return self._surfaces[int(row.first[0])], self._surfaces[int(row.second[0])]

    def _overlap(self, row: CorePairs, on_a: FloatArray, on_b: FloatArray) -> BoolArray:
        """Where points (3, n) of either surface are inside the other one, if that is a solid."""
        result = np.ones(on_a.shape[1], dtype=np.bool_)
        a, b = self._both(row)
        for solid, points, turn, place in (
            (a, on_b, row.rotation_a, row.centre_a),
            (b, on_a, row.rotation_b, row.centre_b),
        ):
            if solid.depth > 0:
                result &= solid.contains((points - place).T @ turn[..., 0])
        return result


def _most(a: Surface, b: Surface) -> float:
    """How far the smaller of two surfaces may sink into the other [m]."""
    return min(max(a.depth, b.depth), min(a.size, b.size) / 2)


def _inside(pairs: CorePairs, pair: _Deep) -> CoreContacts:
    """The contact of the only one of ``pairs``, of which one solid is inside the other, where
    their surfaces are nearest."""
    gap = pair.gap
    return _point(pairs, pair.least, gap.first - gap.second, (gap.first + gap.second) / 2)


def _point(row: CorePairs, distance: float, way: FloatArray, centre: FloatArray) -> CoreContacts:
    """A contact of one pair at a point, its normal along ``way``."""
    at = centre[:, None]
    none = np.zeros(1, dtype=np.bool_)
    patch = Patches(at, np.zeros(1), none, np.zeros(1), at[:, None], none[None], none, np.zeros(1))
    normal = way / max(float(np.linalg.norm(way)), 1e-300)
    return core_contacts(row, normal[:, None], np.array([distance]), patch, True)
