"""Contacts of surfaces: of two meshes, a mesh and a hull, and of a convex core inside a mesh.

FCL finds the distance of two surfaces. Where they are apart, the triangles about the nearest points
make the patch. Where solids cross, the triangles that face each other do; the deeper they are, the
more the curve along which the surfaces cross takes their place. For a body wholly inside a solid,
that solid is a wall as thick as bodies may sink in. So distances, centres and areas are continuous
while a body moves from outside through the surface to the far side of that wall.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray, chosen_of, joined
from ...frozen import frozen
from .body_patches import CoreContacts, core_contacts, reduced
from .closed_forms import Separation, nearest_on_triangle
from .convex import ConvexDistances
from .core_pairs import CorePairing, CorePairs, by_piece
from .core_patches import CorePatches
from .cores import CoreTable, Kind, Size
from .deepest import MARGIN, WITHIN, examine_deepest
from .frames import chunks, cross, dot, smooth_step, turned_back
from .manifold import ROUGHNESS, UNEVEN, Patches, patch_gap, patches, within_of
from .surfaces import CoreSurface, SurfacePart, Surfaces
from .triangles import (
    both_ways_apart,
    crossing_lines,
    facing_axes,
    normals_and_areas,
    over_each_other,
    triangle_to_triangle,
    unit_normals,
)

_REACH = 1.1 * ROUGHNESS
"""Metres beyond the least distance within which triangles belong to the patch."""

_SLACK = 1e-4
"""Metres by which triangles that can belong to a patch may seem farther apart."""

_TOUCHING = 1e-7
"""Distance up to which two surfaces count as touching, so that they may cross [m]."""

_OPEN = 1e-6
"""Weight of the mean of the surfaces' normals beside the area that the curve along which they
cross encloses: an open curve encloses none, and those at both ends of a hole cancel."""


@frozen
class _Gap:
    """How far apart two cores are, 0 where they overlap, and their nearest points in the world."""

    distance: float
    first: FloatArray
    second: FloatArray


@frozen
class _CrossingCurve:
    """The curve along which two surfaces cross: its centre of mass, the vector area that it
    encloses as a unit ``normal`` from first to second and an ``area`` [m^2], and its ``extent``
    [m]."""

    centre: FloatArray
    normal: FloatArray
    area: float
    extent: float


@frozen
class _Faces:
    """Triangles (n,) that look at each other: the number of the ``pair`` of surfaces, of both
    triangles, and of their ``piece``, their corners (3, 3, n), outward normals (3, n), and the
    ``area`` (n,) of the smaller one [m^2]; ``turned``: only the other side of a shell does. Signed
    separations along both normals: at least ``bound``, ``behind`` if the first were on the other
    side of the second [m]."""

    pair: IntArray
    triangle_a: IntArray
    triangle_b: IntArray
    piece: IntArray
    first: FloatArray
    second: FloatArray
    normal_a: FloatArray
    normal_b: FloatArray
    area: FloatArray
    turned: BoolArray
    bound: FloatArray
    behind: FloatArray

    @classmethod
    def of(
        cls,
        numbers: tuple[IntArray, IntArray, IntArray, IntArray],
        first: FloatArray,
        second: FloatArray,
        shell_a: BoolArray,
    ) -> _Faces:
        """Of triangles by their corners; ``shell_a`` (n,): the first belongs to a shell, of which
        either side can face the other surface."""
        normal_a, area_a = normals_and_areas(first)
        normal_b, area_b = normals_and_areas(second)
        turned = dot(normal_a, normal_b) > 0
        normal_a = np.where(turned & shell_a, -normal_a, normal_a)
        normal_b = np.where(turned & ~shell_a, -normal_b, normal_b)
        bound, behind = np.maximum(
            both_ways_apart(first, second, normal_a), both_ways_apart(first, second, -normal_b)
        )
        area = np.minimum(area_a, area_b)
        return cls(*numbers, first, second, normal_a, normal_b, area, turned, bound, behind)

    def within(self) -> FloatArray:
        """Metres (n,) beyond the deepest faces at which these can belong to the same patch, see
        `CoreContacts.within`: a patch is no larger than either triangle, and the slope between both
        in any plane at least that in the plane halfway between them."""
        cosine = -dot(self.normal_a, self.normal_b)
        slope = 2 * np.sqrt(np.maximum(1 - cosine, 0.0) / (1 + cosine))
        return MARGIN * np.maximum(within_of(self.area), patch_gap(slope))


@frozen
class _Lying:
    """Faces that lie on each other: the number ``face`` (n,) of the two, and their signed distance
    ``depth`` (n,) [m] along the ``axis`` (3, n)."""

    face: IntArray
    depth: FloatArray
    axis: FloatArray


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

        nearest = np.inf
        request = fcl.DistanceRequest(enable_nearest_points=True)
        for least, mesh, other in self._placed_for_fcl(rows, k, solid):
            if least >= nearest:
                break
            result = fcl.DistanceResult()
            distance = max(float(fcl.distance(mesh, other, request, result)), 0.0)
            if distance < nearest:
                nearest = distance
                points = result.nearest_points
        turn = np.ascontiguousarray(rows.rotation_b[..., k])
        place = rows.centre_b[:, k]
        on_mesh, on_other = (turn @ np.asarray(point) + place for point in points)
        return _Gap(
            nearest,
            rows.centre_a[:, k] if self._table.kind[rows.first[k]] == Kind.POINT else on_other,
            on_mesh,
        )

    def _distance(self, rows: CorePairs, k: int) -> float:
        """The distance of the surfaces of pair ``k``. To find that they cross is faster than to
        find that they are 0 apart."""
        import fcl

        crosses = any(
            fcl.collide(mesh, other, fcl.CollisionRequest(), fcl.CollisionResult())
            for least, mesh, other in self._placed_for_fcl(rows, k)
            if least == 0
        )
        return 0.0 if crosses else self._gap(rows, k).distance

    def _placed_for_fcl(
        self, rows: CorePairs, k: int, solid: bool = False
    ) -> list[tuple[float, Any, Any]]:
        """Parts of the mesh of pair ``k``, at the origin, with parts of the other body, and lower
        bounds on their distances, least first; ``solid`` as in `gaps`."""
        # Products depend on how matrices lie in memory, and results must not.
        turn, other_turn = map(
            np.ascontiguousarray, (rows.rotation_b[..., k], rows.rotation_a[..., k])
        )
        rotation = turn.T @ other_turn
        offset = turn.T @ (rows.centre_a[:, k] - rows.centre_b[:, k])
        others = self._parts(int(rows.first[k]), solid)
        for other in others:
            other.second.setRotation(rotation)
            other.second.setTranslation(offset)
        pairs = [
            (mesh, other) for mesh in self._surfaces[int(rows.second[k])].parts for other in others
        ]
        if len(pairs) == 1:
            return [(0.0, mesh.first, other.second) for mesh, other in pairs]
        least = [mesh.distance_from_bounds(other, rotation, offset) for mesh, other in pairs]
        return [
            (least[pair], pairs[pair][0].first, pairs[pair][1].second)
            for pair in np.argsort(least, kind="stable").tolist()
        ]

    def _parts(self, core: int, solid: bool) -> tuple[SurfacePart, ...]:
        """The parts of the surface of a mesh, or of a hull that is not ``solid``; any other core is
        a part by itself."""
        kind = self._table.kind[core]
        if kind == Kind.MESH or (kind == Kind.HULL and not solid):
            return self._surfaces[core].parts
        body = self._bodies.core(core, Size.THICK if kind == Kind.BOX else Size.USUAL)
        centre = self._table.bound_centre[:, core]
        half = self._table.bound_half[:, core]
        return (SurfacePart(centre - half, centre + half, body.first, body.second),)

    def contacts(
        self,
        rows: CorePairs,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """Add the contacts of pairs of surfaces.

        Args:
            rows: pairs of cores, both of them surfaces.
            limit: largest distance of a contact, of each pair of bodies (p,) [m].
            distance: of each pair of bodies (p,) [m]: gets lower bounds where they are farther
                apart.
            found: contacts so far, which is added to.
            corners: whether the outlines of the patches are wanted.
        """
        # By number of the pair: how far its surfaces are apart, and where one is in the
        # other, how much less their distance is than that of the surfaces.
        apart: dict[int, tuple[float, float]] = {}
        deep: dict[int, float] = {}
        for k in range(len(rows)):
            a = self._surfaces[int(rows.first[k])]
            b = self._surfaces[int(rows.second[k])]
            owner = int(rows.owner[k])
            radius = float(rows.radius_a[k] + rows.radius_b[k])
            gap = self._distance(rows, k)
            most = _most(a, b)
            if gap <= _TOUCHING and most > 0:
                deep[k] = most
                continue
            least = gap - radius
            around = 0.0
            if most > 0 and least - most <= limit[owner]:
                around = self._around(chosen_of(rows, np.array([k])))
            sunk = 0.0
            if least - most > limit[owner] or around > 0:
                sunk = most if np.isfinite(around) else gap + most
            if least - sunk > limit[owner]:
                distance[owner] = min(distance[owner], least - sunk)
            else:
                apart[k] = max(gap, 0.0), sunk
        if deep:
            crossing = self._passed_through(rows, deep, found, corners)
            apart.update(dict.fromkeys(crossing, (0.0, 0.0)))
        if apart:
            gaps, sunk_in = np.array(list(apart.values())).T
            several = chosen_of(rows, np.array(list(apart)))
            near = self._pairing.near_triangles(
                replace(several, owner=np.arange(len(apart))), gaps + _SLACK, ROUGHNESS
            )
            sunk_in = sunk_in[near.owner]
            near.owner = several.owner[near.owner]
            self._lying(near, sunk_in, limit, distance, found, corners)

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
        for k in np.flatnonzero(np.isfinite(self.least_distances(rows))).tolist():
            mesh = self._surfaces[int(rows.second[k])]
            centre = (rows.centre_a[:, k] - rows.centre_b[:, k]) @ rows.rotation_b[..., k].copy()
            if not (
                (centre > mesh.low).all()
                and (centre < mesh.high).all()
                and mesh.contains(centre[None])[0]
            ):
                continue
            chosen[k] = True
            row = chosen_of(rows, np.array([k]))
            owner = int(row.owner[0])
            radius = float(row.radius_a[0] + row.radius_b[0])
            least = max(self._gap(row, 0).distance - radius, 0.0) + float(
                self.least_distances(row)[0]
            )
            distance[owner] = min(distance[owner], max(least, limit[owner]))
            if least <= limit[owner]:
                nearest = self._nearest_to_middle(row)
                way = row.centre_a[:, 0] - nearest
                found.append(_point(row, least, way, nearest))
        return chosen

    def sunk_in(
        self, rows: CorePairs, gap: FloatArray, normal: FloatArray, patch: Patches
    ) -> tuple[FloatArray, FloatArray, Patches]:
        """Distances ``gap`` (n,), normals (3, n) and patches of convex cores whose middles are
        outside the meshes of the triangles they are paired with. Distances end where a core has
        sunk in as far as it may; patches become the point of the mesh that is nearest to its
        middle, from half that depth on."""
        deepest = self.least_distances(rows)
        share = smooth_step(2 * gap / deepest - 1)
        sunk = share.nonzero()[0]
        if len(sunk) == 0:
            return gap, normal, patch
        pairs = np.stack([rows.owner, rows.first, rows.second])[:, sunk]
        _, one, of = np.unique(pairs, axis=1, return_index=True, return_inverse=True)
        nearest = np.stack(
            [self._nearest_to_middle(chosen_of(rows, sunk[k : k + 1])) for k in one.tolist()],
            axis=1,
        )[:, of.reshape(-1)]
        way = nearest - rows.centre_a[:, sunk]
        length = np.sqrt(dot(way, way))
        way = np.where(length > _TOUCHING, way / np.maximum(length, _TOUCHING), normal[:, sunk])
        part = share[sunk]
        mixed = normal[:, sunk] * (1 - part) + way * part
        normal = normal.copy()
        centre = patch.centre.copy()
        normal[:, sunk] = mixed / np.sqrt(dot(mixed, mixed)).clip(1e-300)
        centre[:, sunk] += (nearest - centre[:, sunk]) * part
        area = patch.area * (1 - share)
        return np.maximum(gap, deepest), normal, replace(patch, centre=centre, area=area)

    def _nearest_to_middle(self, row: CorePairs) -> FloatArray:
        """Of a pair of a convex core and a mesh, the only one in ``row``: the point (3,) of the
        mesh nearest to the middle of the core."""
        turn = row.rotation_b[..., 0]
        place = row.centre_b[:, 0]
        corners = self._surfaces[int(row.second[0])].index.corners.transpose(2, 1, 0)
        middle = ((row.centre_a[:, 0] - place) @ turn)[:, None]
        nearest = nearest_on_triangle(np.repeat(middle, corners.shape[2], axis=1), corners)
        way = nearest - middle
        return turn @ nearest[:, int(dot(way, way).argmin())] + place

    def least_distances(self, rows: CorePairs) -> FloatArray:
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

    def _around(self, row: CorePairs) -> float:
        """The depth of the solid that encloses the other surface, 0 where neither does."""
        for solid, other, turn, place in self._each_in_other(row):
            point = other.index.corners[0, :1] @ turn + place
            if (
                solid.depth > 0
                and (point > solid.low).all()
                and (point < solid.high).all()
                and solid.contains(point)[0]
            ):
                return solid.depth
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
        sunk: FloatArray,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """Add the contacts of surfaces that do not cross, and of those that cross where no
        triangles face each other.

        Args:
            rows: pairs of triangles (n,).
            sunk: how much less the distance of the bodies is than that of the triangles, as one
                body is inside the other (n,) [m]; otherwise 0.
            limit: largest distance of a contact, of each pair of bodies (p,) [m].
            distance: of each pair of bodies (p,) [m], which is changed.
            found: contacts so far, which is added to.
            corners: whether the outlines of the patches are wanted.
        """
        parts = chunks(len(rows))
        separation = joined([self._separation(chosen_of(rows, part)) for part in parts])
        gap = separation.distance - rows.radius_a - rows.radius_b - sunk
        deepest = np.full(len(limit), np.inf)
        np.minimum.at(deepest, rows.owner, gap)
        np.minimum.at(distance, rows.owner, np.maximum(gap, limit[rows.owner]))
        most = np.minimum(limit, deepest + WITHIN)
        near = (gap <= most[rows.owner]).nonzero()[0]
        for part in chunks(len(near)) if len(near) else ():
            few = near[part]
            some, apart = chosen_of(rows, few), chosen_of(separation, few)
            patch = self._patches.patches(some, apart)
            normal = np.where(sunk[few] > 0, -apart.normal, apart.normal)
            found.append(core_contacts(some, normal, gap[few], patch, corners))

    def _separation(self, rows: CorePairs) -> Separation:
        """Separations of pairs of triangles, whose outer sides are towards each other where they
        touch."""
        first, second = self._corners(rows)
        found = triangle_to_triangle(first, second)
        outwards = dot(found.normal, unit_normals(first) - unit_normals(second))
        turns = (found.distance <= _TOUCHING) & (outwards < 0)
        return replace(found, normal=np.where(turns, -found.normal, found.normal))

    def _passed_through(
        self,
        pairs: CorePairs,
        deep: dict[int, float],
        found: list[CoreContacts],
        corners: bool,
    ) -> list[int]:
        """Add contacts of pairs, by number, whose surfaces cross and of which one is a solid, with
        how far they may sink into each other [m]. Returns the numbers of those that only touch,
        where no triangles face each other."""
        several = chosen_of(pairs, np.array(list(deep)))
        most = np.array(list(deep.values()))
        row = [chosen_of(several, np.array([k])) for k in range(len(deep))]
        sunk = [k for k in range(len(deep)) if self._is_deep(row[k], float(most[k]))]
        crossings = {k: self._crossing(row[k]) for k in sunk}
        # As deep as that, the curve along which they cross is all that counts.
        others = np.array([k for k in range(len(deep)) if crossings.get(k) is None], dtype=np.intp)
        number, depth, facing = self._facing(several, others, most, corners)
        depths = np.full(len(deep), np.nan)
        np.fmax.at(depths, number, depth)
        depths[depths < -UNEVEN] = np.nan  # they cross elsewhere
        depths[sunk] = np.fmax(depths[sunk], most[sunk])
        crossings |= {
            k: self._crossing(row[k])
            for k in np.flatnonzero(~(depths <= most / 2)).tolist()
            if k not in crossings
        }
        by_faces = np.ones(len(deep), dtype=np.bool_)
        for k, crossing in sorted(crossings.items()):
            if crossing is not None:
                faces = _some(facing, (number == k).nonzero()[0])
                found.append(self._sunk(row[k], float(most[k]), float(depths[k]), crossing, faces))
                by_faces[k] = False
        only_touch = by_faces & np.isnan(depths)
        rows = (by_faces & ~only_touch)[number].nonzero()[0]
        if len(rows):
            found.append(_some(facing, rows))
        return [pair for pair, touches in zip(deep, only_touch, strict=True) if touches]

    def _facing(
        self, pairs: CorePairs, chosen: IntArray, most: FloatArray, corners: bool
    ) -> tuple[IntArray, FloatArray, CoreContacts]:
        """The contacts (n,) of the faces of the ``chosen`` pairs (m,) of solids that look at each
        other, the pair (n,) that each belongs to, and how deep [m] these faces are (n,).

        Args:
            pairs: (p,) of surfaces, one of which is a solid.
            chosen: (m,) numbers of the pairs.
            most: (p,) how far the two may sink into each other [m].
            corners: Whether the contacts have corners.
        """
        several = chosen_of(pairs, chosen)
        faces = self._faces(several, _REACH + 2 * most[chosen])
        # A shell inside a wall may leave it by either of its sides.
        way = 2 * faces.pair + faces.turned
        found = [self._lying_on_each_other(several, faces, np.zeros(0, dtype=np.int64))]

        def examine(part: IntArray) -> tuple[IntArray, FloatArray]:
            found.append(self._lying_on_each_other(several, faces, part))
            return found[-1][0].face, found[-1][0].depth

        group = by_piece(way, faces.piece)
        examine_deepest(group, faces.bound, -most[chosen][faces.pair], faces.within(), examine)
        lying = joined([faces for faces, _ in found])
        patch = joined([patch for _, patch in found])
        order = lying.face.argsort()
        lying = chosen_of(lying, order)
        patch = chosen_of(patch, order)
        side = way[lying.face]
        sunk = lying.depth < -_TOUCHING
        through = np.zeros((len(pairs), 2), dtype=np.bool_)
        through.reshape(-1)[side[lying.depth < _TOUCHING]] = True
        deepest = np.zeros((len(pairs), 2))
        np.minimum.at(deepest.reshape(-1), way, faces.bound)
        farther = 2 * np.arange(len(pairs)) + deepest.argmin(axis=1)
        both = np.asarray(through.all(axis=1))
        dropped = sunk & both[side // 2] & (side == farther[side // 2])
        lying = chosen_of(lying, ~dropped)
        patch = chosen_of(patch, ~dropped)
        rows = self._placed(several, chosen_of(faces, lying.face))
        number = chosen[faces.pair[lying.face]]
        gap = np.maximum(lying.depth, -most[number]) - rows.radius_a - rows.radius_b
        facing = core_contacts(rows, lying.axis, gap, patch, corners)
        return number, -lying.depth, facing

    def _faces(self, pairs: CorePairs, reach: FloatArray) -> _Faces:
        """The triangles of ``pairs`` (p,) of surfaces that face each other within ``reach`` (p,)
        metres."""
        shell = np.array(
            [self._surfaces[core].depth == 0 for core in pairs.first.tolist()], dtype=np.bool_
        )
        triangles = self._pairing.facing_triangles(pairs, reach, _REACH)
        found = []
        for part in chunks(len(triangles[0])):
            number, one, other, piece = (numbers[part] for numbers in triangles)
            rows = self._pairing.with_triangles(pairs, number, one, other, piece)
            faces = _Faces.of((number, one, other, piece), *self._corners(rows), shell[number])
            possible = (faces.bound < _REACH) & (faces.behind <= reach[faces.pair])
            found.append(chosen_of(faces, possible))
        return joined(found)

    def _placed(self, pairs: CorePairs, faces: _Faces) -> CorePairs:
        """Rows of ``faces`` of ``pairs``."""
        return self._pairing.with_triangles(
            pairs, faces.pair, faces.triangle_a, faces.triangle_b, faces.piece
        )

    def _lying_on_each_other(
        self, pairs: CorePairs, faces: _Faces, chosen: IntArray
    ) -> tuple[_Lying, Patches]:
        """Which of the ``chosen`` ones of the ``faces`` lie on each other, and their patches."""
        faces = chosen_of(faces, chosen)
        separation, axis = facing_axes(faces.first, faces.second, faces.normal_a, faces.normal_b)
        over = over_each_other(faces.first, faces.second, axis)
        faces = chosen_of(faces, over)
        axis = axis[:, over]
        separation = separation[over]
        middle = (faces.first.sum(axis=1) + faces.second.sum(axis=1)) / 6
        patch = patches(
            faces.first - middle[:, None], faces.second - middle[:, None], axis, ROUGHNESS
        )
        centre = middle + patch.centre
        depth = separation + np.where(patch.found, patch.gap, 0.0)
        ends = [
            centre + axis * (dot(corners[:, 0] - centre, normal) / dot(axis, normal))
            for corners, normal in ((faces.first, faces.normal_a), (faces.second, faces.normal_b))
        ]
        patch = replace(
            patch, centre=(ends[0] + ends[1]) / 2, corners=middle[:, None] + patch.corners
        )
        valid = patch.found & (depth < _REACH)
        # Seen at the middle of the patch.
        under = valid & (dot(axis, ends[1] - ends[0]) < -_TOUCHING)
        asked = under.nonzero()[0]
        valid[asked] = self._overlap(
            chosen_of(pairs, faces.pair[asked]), ends[0][:, asked], ends[1][:, asked]
        )
        lying = _Lying(chosen[over], depth, axis)
        return chosen_of(lying, valid), chosen_of(patch, valid)

    def _crossing(self, row: CorePairs) -> _CrossingCurve | None:
        """The curve along which the surfaces of the single pair ``row`` cross."""
        near = self._pairing.near_triangles(row, np.full(1, _TOUCHING))
        if len(near) == 0:
            return None
        first, second = self._corners(near)
        middle, way = crossing_lines(first, second)
        length = np.sqrt(dot(way, way))
        total = float(length.sum())
        if total <= _TOUCHING:
            return None
        used = length > 0
        centre = (middle * length).sum(axis=1) / total
        arm = middle - centre[:, None]
        area = cross(arm, way).sum(axis=1) / 2
        outwards = np.zeros(3)
        for core, corners, sign in ((row.first, first, 1.0), (row.second, second, -1.0)):
            if self._surfaces[int(core[0])].depth > 0:
                outwards += sign * (unit_normals(corners) * length).sum(axis=1)
        sizes = float(np.linalg.norm(area)) * total
        if any(surface.depth == 0 for surface in self._both(row)) and (
            area @ outwards < -_OPEN * sizes
        ):
            area = -area  # by the sense of a shell's triangles, whose sides are alike
        normal = area + _OPEN * total * outwards
        normal /= max(float(np.linalg.norm(normal)), 1e-300)
        extent = float(np.ptp(middle[:, used], axis=1).max() + length.max())
        return _CrossingCurve(centre, normal, float(np.linalg.norm(area)), extent)

    def _sunk(
        self,
        row: CorePairs,
        most: float,
        depth: float,
        crossing: _CrossingCurve,
        facing: CoreContacts,
    ) -> CoreContacts:
        """The contact of the single pair ``row``, whose solids have sunk deep into each other: from
        that of the triangles which face each other, at half the depth ``most`` [m], to that around
        the curve where the surfaces cross, from ``most`` on.

        Args:
            depth: of the deepest of those faces [m], NaN where there are none.
            facing: the contacts of those faces.
        """
        if np.isnan(depth):
            depth = min(most, crossing.extent)
            share = 1.0
        else:
            share = float(smooth_step(2 * depth / most - 1))
        normal = np.where(row.flipped, -crossing.normal, crossing.normal)[:, None]
        centre = crossing.centre[:, None]
        area = crossing.area
        corners = None if facing.corners is None else [crossing.centre[None]]
        if share < 1:
            alone = replace(facing, owner=np.zeros_like(facing.owner))
            patch = reduced(np.full(1, np.inf), [alone], facing.corners is not None)
            centre = patch.centre + (centre - patch.centre) * share
            area = float(patch.area[0]) * (1 - share) + area * share
            normal = patch.normal * (1 - share) + normal * share
            normal = normal / max(float(np.linalg.norm(normal)), 1e-300)
            corners = None if facing.corners is None else list(patch.corners)
        distance = -min(depth, most) - row.radius_a - row.radius_b
        areas = np.full(1, area)
        cores = np.array([row.first, row.second, np.zeros(1, dtype=np.int64)])
        within = np.full(1, _REACH)
        return CoreContacts(
            row.owner, cores, distance, normal, centre, areas, areas, within, corners
        )

    def _is_deep(self, row: CorePairs, most: float) -> bool:
        """Whether a corner of either surface is surely deeper than ``most`` [m] inside the other
        one, if that is a solid."""
        for solid, other, turn, place in self._each_in_other(row):
            if solid.depth > 0:
                points = other.points @ turn + place
                inner = (points > solid.low + most) & (points < solid.high - most)
                points = points[inner.all(axis=1)]
                if len(points) == 0:
                    continue
                near, _ = solid.index.near(np.stack([points - most, points + most], axis=1))
                points = np.delete(points, near, axis=0)
                if len(points) and solid.contains(points).any():
                    return True
        return False

    def _each_in_other(
        self, row: CorePairs
    ) -> Iterator[tuple[CoreSurface, CoreSurface, FloatArray, FloatArray]]:
        """Of the single pair ``row``, the second surface and the first one, then the first and the
        second: one, the other, and how points (n, 3) of the other are placed in the frame of the
        one, ``points @ turn + place``."""
        a, b = self._both(row)
        turn_a = row.rotation_a[..., 0]
        turn_b = row.rotation_b[..., 0]
        way = row.centre_b[:, 0] - row.centre_a[:, 0]
        yield b, a, turn_a.T @ turn_b, -turn_b.T @ way
        yield a, b, turn_b.T @ turn_a, turn_a.T @ way

    def _both(self, row: CorePairs) -> tuple[CoreSurface, CoreSurface]:
        return self._surfaces[int(row.first[0])], self._surfaces[int(row.second[0])]

    def _overlap(self, rows: CorePairs, on_a: FloatArray, on_b: FloatArray) -> BoolArray:
        """Which points (3, n) of either surface are inside the other one, if that is a solid."""
        inside = self._contained(rows.first, turned_back(rows.rotation_a, on_b - rows.centre_a))
        rows = chosen_of(rows, inside)
        on_a = on_a[:, inside]
        inside[inside] = self._contained(
            rows.second, turned_back(rows.rotation_b, on_a - rows.centre_b)
        )
        return inside

    def _contained(self, cores: IntArray, points: FloatArray) -> BoolArray:
        """Which points (3, n) are inside the solids ``cores`` (n,), each in the frame of its own;
        true of shells."""
        inside = np.ones(len(cores), dtype=np.bool_)
        for surface, mine in self._pairing.alike(cores):
            if surface.depth > 0:
                inside[mine] = surface.contains(points[:, mine].T)
        return inside


def _most(a: CoreSurface, b: CoreSurface) -> float:
    """How far the smaller of two surfaces may sink into the other [m]."""
    return min(max(a.depth, b.depth), min(a.size, b.size) / 2)


def _some(contacts: CoreContacts, rows: IntArray) -> CoreContacts:
    """Some of the ``contacts``."""
    corners = None if contacts.corners is None else [contacts.corners[k] for k in rows.tolist()]
    return replace(chosen_of(replace(contacts, corners=None), rows), corners=corners)


def _point(row: CorePairs, distance: float, way: FloatArray, centre: FloatArray) -> CoreContacts:
    """A contact of one pair at a point, its normal along ``way``."""
    at = centre[:, None]
    none = np.zeros(1, dtype=np.bool_)
    patch = Patches(at, np.zeros(1), none, np.zeros(1), at[:, None], none[None], none, np.zeros(1))
    normal = way / max(float(np.linalg.norm(way)), 1e-300)
    return core_contacts(row, normal[:, None], np.array([distance]), patch, True)
