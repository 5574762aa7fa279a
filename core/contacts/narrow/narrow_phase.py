"""Narrow phase: signed distance and contact patch of pairs of bodies, many pairs at a time.

Spheres, capsules and boxes, among themselves and against triangles, have closed forms or separating axes in NumPy; what else there is goes
to FCL pair by pair.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from ..hull import hull_2d
from ..shapes import Shape
from .boxes import best_axes, box_contacts, corner_contacts
from .closed_forms import (
    Separation,
    between,
    dot,
    point_to_box,
    point_to_cone,
    point_to_cylinder,
    point_to_triangle,
    segment_to_box,
    segment_to_segment,
    segment_to_triangle,
    turned,
    turned_back,
)
from .convex import Convex, ConvexDistances, Size, separations
from .cores import CoreTable, Kind
from .manifold import PATCH_GAP, Patches, contact_plane, patches
from .mesh_index import MeshIndex
from .separating_axes import AxisSeparation, box_to_box, box_to_triangle
from .supporting_feature import FEW, MANY, Features, triangle_polygons

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

_DRAWN_ROUGHLY = (Kind.CYLINDER, Kind.CONE, Kind.HULL)
"""Kinds whose features have fewer corners than they should."""

_NEAR = 1e-3
"""Metres from the nearest points of two cores within which their patch must lie."""

_CERTAIN = 1e-4
"""Metres by which a lower bound on a distance may be below an upper bound and still pass for it."""

_BEYOND = 1e-9
"""Metres beyond the reach that a distance is said to be of which no more is known."""

_TOGETHER = 4e-5
"""Metres by which a point or line may be further away than the nearest part of the bodies and still belong to their patch."""

_POINT_AREA, _FACE_AREA = 1e-12, 1e-3
"""Area in square metres that a point counts as beside faces, and from about which on a face belongs to the patch within ``PATCH_GAP``."""

MAX_PATCH_POINTS = 8


@dataclass(frozen=True, slots=True)
class PairPatches:
    """Per pair of bodies, in the frame of the first: signed ``distance`` (p,) [m] (a lower bound where it is beyond the reach asked for),
    unit ``normal`` (3, p) from first to second, ``centre`` (3, p) of the patch, midway between the surfaces, ``area`` (p,) [m^2], and if
    asked for the ``corners`` (k, 3) of each patch."""

    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    area: FloatArray
    corners: tuple[FloatArray, ...] = ()


@dataclass(frozen=True, slots=True)
class _Boxes:
    """Pairs ``rows`` (k,) of single boxes, the second placed relative to the first, and the radii (k,) by which each is grown."""

    rows: IntArray
    rotation: FloatArray
    offset: FloatArray
    half_a: FloatArray
    half_b: FloatArray
    radius_a: FloatArray
    radius_b: FloatArray


@dataclass(slots=True)
class _Rows:
    """Pairs of convex cores, placed in the world: ``owner`` (n,) the pair of bodies, ``flipped`` (n,) whether its first body is the second
    here, numbers of the cores, ``radius_a`` and ``radius_b`` by which they are grown. ``triangle_a`` and ``triangle_b`` (n,) say which
    triangle stands in where a core is a mesh."""

    owner: IntArray
    flipped: BoolArray
    first: IntArray
    second: IntArray
    rotation_a: FloatArray
    centre_a: FloatArray
    rotation_b: FloatArray
    centre_b: FloatArray
    radius_a: FloatArray
    radius_b: FloatArray
    triangle_a: IntArray | None = None
    triangle_b: IntArray | None = None

    def __len__(self) -> int:
        return len(self.owner)

    def chosen(self, rows: IntArray | BoolArray) -> _Rows:
        """Some of the rows."""
        values: list[Any] = [getattr(self, f.name) for f in fields(self)]
        picked: list[Any] = [None if value is None else value[rows] for value in values]
        return _Rows(*picked)


@dataclass(frozen=True, slots=True)
class _Found:
    """Touching rows and what they have: distance with radii, normal, middle of the patch, ``weight`` (area in square metres, that of a line
    tiny but in proportion), reported ``area``, corners."""

    owner: IntArray
    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    weight: FloatArray
    area: FloatArray
    corners: list[FloatArray] | None


class NarrowPhase:
    """Queries between bodies given by number. ``solid`` says which bodies are volumes: their meshes count as hulls. ``is_box`` (n,): which
    bodies are single boxes.

    A pair is placed by the ``rotation`` (3, 3, p) of its second body and the ``offset`` (3, p) of its origin in the frame of the first;
    results are in that frame.
    """

    def __init__(self, shapes: Sequence[Shape], solid: Sequence[bool] | None = None) -> None:
        self._table = table = CoreTable.of(shapes, solid or [False] * len(shapes))
        self._convex = ConvexDistances(table)
        self._features = Features(table)
        self._meshes: dict[int, MeshIndex] = {}
        first = np.minimum(table.start[:-1], max(len(table.kind) - 1, 0))
        self.is_box = (np.diff(table.start) == 1) & (table.kind[first] == Kind.BOX)
        self._all_boxes = bool(self.is_box.all())
        # Per body, for those that are boxes, pairs last.
        self._half, self._sharp_half = table.half[first].T.copy(), table.sharp_half[first].T.copy()
        self._radius, self._sharp_radius = table.radius[first], table.sharp_radius[first]
        self._authored = table.is_box[first]
        self._turn, self._shift = table.rotation[first].transpose(1, 2, 0).copy(), table.offset[first].T.copy()
        self._outline = table.outline[first].T.copy()

    @property
    def thickness(self) -> FloatArray:
        """Smallest extent of each body's thinnest part (n,) [m]: what moves further in one step may pass through it unseen."""
        return self._table.thickness

    def query(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, reach: FloatArray, corners: bool = False) -> PairPatches:
        """Distances and patches of ``pairs`` (p, 2). Distances up to ``reach`` (p,) metres are exact; beyond, they are lower bounds.
        ``corners``: give the points of the patches, too."""
        count = len(pairs)
        result = PairPatches(np.empty(count), np.empty((3, count)), np.empty((3, count)), np.empty(count), ())
        others = np.arange(count)
        if not corners:
            boxes = self._boxes(pairs, rotation, offset)
            if boxes is not None:
                others = self._box_patches(boxes, pairs, reach, result, others)
        if len(others) == 0:
            return result
        found = self._general(pairs[others], rotation[..., others], offset[:, others], reach[others], corners)
        if len(others) == count:
            return found
        result.distance[others], result.area[others] = found.distance, found.area
        result.normal[:, others], result.centre[:, others] = found.normal, found.centre
        return result

    def clearances(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, reach: FloatArray) -> FloatArray:
        """Signed distances (p,), or lower bounds on them that are positive only if the distance is. Cheaper than `query`. Beyond ``reach``
        (p,) a bound need not be larger than that."""
        boxes = self._boxes(pairs, rotation, offset)
        if boxes is None:
            return self.directed_clearances(pairs, rotation, offset, reach)[0]
        distance = np.empty(len(pairs))
        distance[boxes.rows] = (
            best_axes(boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b).distance - boxes.radius_a - boxes.radius_b
        )
        if len(boxes.rows) < len(pairs):
            rest = np.ones(len(pairs), dtype=np.bool_)
            rest[boxes.rows] = False
            others = np.flatnonzero(rest)
            distance[others] = self.directed_clearances(pairs[others], rotation[..., others], offset[:, others], reach[others])[0]
        return distance

    def directed_clearances(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, reach: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The same, and normals (3, p) from first to second."""
        if self._all_boxes:
            boxes = self._boxes(pairs, rotation, offset)
            if boxes is not None and not self._table.placed:
                radius = boxes.radius_a + boxes.radius_b
                found = box_contacts(boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b, np.full(len(pairs), np.inf))
                return found.distance - radius, found.normal
        count = len(pairs)
        distance = np.full(count, np.inf)
        normal = np.tile([0.0, 0.0, 1.0], (count, 1))
        for rows in self._rows(pairs, *_matrices(rotation, offset), reach):
            separation = self._separated(rows).separation
            gap = _bounded(rows, separation.distance - rows.radius_a - rows.radius_b, reach)
            outward = np.where(rows.flipped[:, None], -separation.normal, separation.normal)
            order = np.argsort(-gap, kind="stable")
            owner = rows.owner[order]
            closer = gap[order] < distance[owner]
            normal[owner[closer]] = outward[order][closer]
            np.minimum.at(distance, owner, gap[order])
        return np.where(np.isinf(distance), reach + _BEYOND, distance), normal.T

    def gaps(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, reach: FloatArray) -> FloatArray:
        """Distances (p,) up to ``reach`` (p,), 0 where bodies overlap: cheaper than to find out how deep."""
        distance = np.full(len(pairs), np.inf)
        for rows in self._rows(pairs, *_matrices(rotation, offset), reach):
            gap = self._separated(rows, depths=False).separation.distance - rows.radius_a - rows.radius_b
            np.minimum.at(distance, rows.owner, _bounded(rows, gap, reach))
        return np.where(np.isinf(distance), reach + _BEYOND, np.maximum(distance, 0.0))

    def _boxes(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray) -> _Boxes | None:
        """Those of the pairs that are of two single boxes."""
        first, second = pairs.T
        if self._all_boxes:
            rows = np.arange(len(pairs))
        else:
            rows = np.flatnonzero(self.is_box[first] & self.is_box[second])
            if len(rows) == 0:
                return None
            first, second, rotation, offset = first[rows], second[rows], rotation[..., rows], offset[:, rows]
        if self._table.placed:
            shift, turn_a, turn_b = self._shift[:, second], self._turn[..., first], self._turn[..., second]
            offset = offset + np.einsum("ijp,jp->ip", rotation, shift) - self._shift[:, first]
            offset = np.einsum("ijp,ip->jp", turn_a, offset)
            rotation = product(turn_a.transpose(1, 0, 2), product(rotation, turn_b))
        sharp = self._authored[first] & self._authored[second]
        some, every = bool(sharp.any()), bool(sharp.all())
        size = []
        for body in (first, second):
            half, radius = self._half[:, body], self._radius[body]
            if some:
                sharp_half, sharp_radius = self._sharp_half[:, body], self._sharp_radius[body]
                half = sharp_half if every else np.where(sharp, sharp_half, half)
                radius = sharp_radius if every else np.where(sharp, sharp_radius, radius)
            size.append((half, radius))
        (half_a, radius_a), (half_b, radius_b) = size
        return _Boxes(rows, rotation, offset, half_a, half_b, radius_a, radius_b)

    def _box_patches(self, boxes: _Boxes, pairs: IntArray, reach: FloatArray, result: PairPatches, every: IntArray) -> IntArray:
        """Write what boxes have; the pairs that are left."""
        rows = boxes.rows
        radius = boxes.radius_a + boxes.radius_b
        found = box_contacts(boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b, reach[rows] + radius)
        corner_contacts(found, boxes.rotation, boxes.offset, boxes.half_a, boxes.half_b)
        area, normal, centre = found.area, found.normal, found.centre
        first, second = pairs[rows].T
        if np.any(radius > 0):
            area = area * self._flatness(first, second, boxes, normal)
            centre = centre + normal * ((boxes.radius_a - boxes.radius_b) / 2)
        if self._table.placed:
            turn = self._turn[..., first]
            normal = np.einsum("ijp,jp->ip", turn, normal)
            centre = np.einsum("ijp,jp->ip", turn, centre) + self._shift[:, first]
        result.distance[rows] = found.distance - radius
        result.normal[:, rows], result.centre[:, rows], result.area[rows] = normal, centre, area
        if len(rows) == len(every):
            return every[:0]
        left = np.ones(len(every), dtype=np.bool_)
        left[rows] = False
        return every[left]

    def _flatness(self, first: IntArray, second: IntArray, boxes: _Boxes, normal: FloatArray) -> FloatArray:
        """Areas (k,) of the smaller of the two faces over those of the boxes' cores: edges that are rounded within the size of a box take
        nothing from what is flat."""
        ratios, areas = [], []
        for body, half, way in ((first, boxes.half_a, normal), (second, boxes.half_b, np.einsum("ijp,ip->jp", boxes.rotation, normal))):
            across = np.arange(3)[:, None] != np.abs(way).argmax(axis=0)
            areas.append(np.where(across, half, 1.0).prod(axis=0))
            ratios.append(np.where(across, self._outline[:, body] / np.maximum(half, 1e-9), 1.0).prod(axis=0))
        flatness: FloatArray = np.where(areas[0] <= areas[1], ratios[0], ratios[1])
        return flatness

    def _general(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, reach: FloatArray, corners: bool) -> PairPatches:
        """Pairs of any shapes."""
        distance = np.full(len(pairs), np.inf)
        found: list[_Found] = []
        kind = self._table.kind
        closed: list[tuple[_Rows, AxisSeparation]] = []
        others = []
        for rows in self._rows(pairs, *_matrices(rotation, offset), reach):
            if rows.triangle_b is not None:
                self._finish(rows, self._separated(rows), reach, distance, found, corners)
            elif (int(kind[rows.first[0]]), int(kind[rows.second[0]])) in _CLOSED_FORMS:
                closed.append((rows, self._separated(rows)))
            else:
                others.append(rows)
        # The rest together: fewer, longer arrays.
        if others:
            rows = _joined(others)
            closed.append((rows, _exact(self._near_by_fcl(rows, reach))))
        if closed:
            rows, separated = _together(closed)
            points = kind[rows.first] == Kind.POINT
            for chosen in (np.flatnonzero(points), np.flatnonzero(~points)):
                if len(chosen):
                    part = AxisSeparation(_chosen(separated.separation, chosen), separated.exact[chosen])
                    self._finish(rows.chosen(chosen), part, reach, distance, found, corners)
        return _reduced(np.where(np.isinf(distance), reach + _BEYOND, distance), found, corners)

    def _rows(self, pairs: IntArray, a: FloatArray, b: FloatArray, reach: FloatArray) -> Iterator[_Rows]:
        """All pairs of cores of all pairs of bodies, in groups of the same kinds, the simpler kind first, meshes as their triangles."""
        table = self._table
        owner, first, second = _products(table.start, pairs)
        flipped = table.kind[first] > table.kind[second]
        first, second = np.where(flipped, second, first), np.where(flipped, first, second)
        matrix_a = np.where(flipped[:, None, None], b[owner], a[owner])
        matrix_b = np.where(flipped[:, None, None], a[owner], b[owner])
        rotation_a, centre_a = self._world(first, matrix_a)
        rotation_b, centre_b = self._world(second, matrix_b)
        kinds = table.kind[first] * len(Kind) + table.kind[second]
        radius_a, radius_b = table.radius[first], table.radius[second]
        everything = _Rows(owner, flipped, first, second, rotation_a, centre_a, rotation_b, centre_b, radius_a, radius_b)
        for value in np.unique(kinds).tolist():
            rows = everything.chosen(np.flatnonzero(kinds == value)) if np.any(kinds != value) else everything
            kind_a, kind_b = Kind(value // len(Kind)), Kind(value % len(Kind))
            if kind_a is Kind.MESH:
                yield from self._meshes_on_meshes(rows, reach)
            elif kind_b is Kind.MESH:
                yield self._on_triangles(rows, kind_a, reach)
            else:
                yield rows

    def _world(self, core: IntArray, matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
        rotation, centre = matrix[:, :3, :3], matrix[:, :3, 3]
        if not self._table.placed:
            return rotation, centre
        return rotation @ self._table.rotation[core], centre + turned(rotation, self._table.offset[core])

    def _mesh(self, core: int) -> MeshIndex:
        made = self._meshes.get(core)
        if made is None:
            mesh = self._table.cores[core].mesh
            assert mesh is not None
            made = self._meshes[core] = MeshIndex.of(mesh)
        return made

    def _on_triangles(self, rows: _Rows, kind: Kind, reach: FloatArray) -> _Rows:
        """Convex cores against those triangles of their meshes that are near."""
        table = self._table
        if kind is Kind.BOX:
            rows.radius_a = table.thick_radius[rows.first]
        if kind is Kind.POINT:
            rows.radius_b = np.array([table.cores[core].mesh_radius_to_points for core in rows.second.tolist()])
        relative = np.einsum("nji,njk->nik", rows.rotation_b, rows.rotation_a)
        middle = turned_back(rows.rotation_b, rows.centre_a + turned(rows.rotation_a, table.bound_centre[rows.first]) - rows.centre_b)
        half = np.einsum("nij,nj->ni", np.abs(relative), table.bound_half[rows.first])
        half += (rows.radius_a + rows.radius_b + np.maximum(reach[rows.owner], 0.0))[:, None]
        bounds = np.stack([middle - half, middle + half], axis=1)
        row, triangle = [], []
        for core in np.unique(rows.second).tolist():
            mine = np.flatnonzero(rows.second == core)
            box, near = self._mesh(core).near(bounds[mine])
            row.append(mine[box])
            triangle.append(near)
        expanded = rows.chosen(np.concatenate(row))
        expanded.triangle_b = np.concatenate(triangle)
        return expanded

    def _meshes_on_meshes(self, rows: _Rows, reach: FloatArray) -> Iterator[_Rows]:
        """Pairs of near triangles of two meshes, one pair of meshes at a time."""
        table = self._table
        for k in range(len(rows)):
            row = rows.chosen(np.array([k]))
            first, second = self._mesh(int(row.first[0])), self._mesh(int(row.second[0]))
            grown = float(row.radius_a[0] + row.radius_b[0] + max(reach[row.owner[0]], 0.0))
            turn, shift = row.rotation_b[0].T @ row.rotation_a[0], row.rotation_b[0].T @ (row.centre_a[0] - row.centre_b[0])
            middle, half = table.bound_centre[row.second[0]], table.bound_half[row.second[0]] + grown
            back = turn.T @ (middle - shift)
            extent = np.abs(turn.T) @ half
            _, near = first.near(np.array([[back - extent, back + extent]]))
            corners = first.corners[near] @ turn.T + shift
            bounds = np.stack([corners.min(axis=1) - grown, corners.max(axis=1) + grown], axis=1)
            mine, theirs = second.near(bounds)
            expanded = row.chosen(np.zeros(len(mine), dtype=np.int64))
            expanded.triangle_a, expanded.triangle_b = near[mine], theirs
            yield expanded

    def _corners(self, mesh: IntArray, triangle: IntArray, rotation: FloatArray, centre: FloatArray) -> FloatArray:
        """World corners (n, 3, 3) of triangles of meshes."""
        local = np.empty((len(mesh), 3, 3))
        for core in np.unique(mesh).tolist():
            mine = mesh == core
            local[mine] = self._mesh(core).corners[triangle[mine]]
        return turned(rotation[:, None], local) + centre[:, None]

    def _separated(self, rows: _Rows, depths: bool = True) -> AxisSeparation:
        """Separations of the cores of one group. Without ``depths``, some that overlap may be said to be 0 apart."""
        count = len(rows)
        if count == 0:
            empty = np.zeros((0, 3))
            return AxisSeparation(Separation(np.zeros(0), empty, empty, empty), np.ones(0, dtype=np.bool_))
        table = self._table
        half_a, half_b = table.half[rows.first], table.half[rows.second]
        kinds = Kind(int(table.kind[rows.first[0]])), Kind(int(table.kind[rows.second[0]]))
        match kinds:
            case (Kind.POINT, Kind.POINT):
                return _exact(between(rows.centre_a, rows.centre_b))
            case (Kind.POINT, Kind.SEGMENT):
                start, end = _ends(rows.rotation_b, rows.centre_b, half_b)
                return _exact(segment_to_segment(rows.centre_a, rows.centre_a, start, end))
            case (Kind.SEGMENT, Kind.SEGMENT):
                ends = (*_ends(rows.rotation_a, rows.centre_a, half_a), *_ends(rows.rotation_b, rows.centre_b, half_b))
                return _exact(segment_to_segment(*ends))
            case (Kind.POINT, Kind.BOX):
                return _exact(point_to_box(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.POINT, Kind.CYLINDER):
                return _exact(point_to_cylinder(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.POINT, Kind.CONE):
                return _exact(point_to_cone(rows.centre_a, rows.rotation_b, rows.centre_b, half_b))
            case (Kind.SEGMENT, Kind.BOX):
                return _segment_and_box(rows, half_a, half_b)
            case (Kind.BOX, Kind.BOX):
                sharp = self._sharp(rows)
                half_a = np.where(sharp[:, None], table.sharp_half[rows.first], half_a)
                half_b = np.where(sharp[:, None], table.sharp_half[rows.second], half_b)
                rows.radius_a = np.where(sharp, table.sharp_radius[rows.first], rows.radius_a)
                rows.radius_b = np.where(sharp, table.sharp_radius[rows.second], rows.radius_b)
                return box_to_box(rows.rotation_a, rows.centre_a, half_a, rows.rotation_b, rows.centre_b, half_b)
            case (_, Kind.MESH):
                return self._separated_from_triangles(rows, kinds[0])
        return _exact(self._by_fcl(rows, depths))

    def _separated_from_triangles(self, rows: _Rows, kind: Kind) -> AxisSeparation:
        assert rows.triangle_b is not None
        if kind in (Kind.POINT, Kind.SEGMENT, Kind.BOX):
            corners = self._corners(rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b)
            if kind is Kind.POINT:
                return _exact(point_to_triangle(rows.centre_a, corners))
            if kind is Kind.SEGMENT:
                return _exact(segment_to_triangle(*_ends(rows.rotation_a, rows.centre_a, self._table.half[rows.first]), corners))
            return box_to_triangle(rows.rotation_a, rows.centre_a, self._table.thick_half[rows.first], corners)
        return _exact(self._by_fcl(rows))

    def _near_by_fcl(self, rows: _Rows, reach: FloatArray) -> Separation:
        """`_by_fcl` of those rows whose bounding boxes are within reach; lower bounds for the others."""
        table = self._table
        centre_a = rows.centre_a + turned(rows.rotation_a, table.bound_centre[rows.first])
        centre_b = rows.centre_b + turned(rows.rotation_b, table.bound_centre[rows.second])
        turn = np.einsum("nki,nkj->ijn", rows.rotation_a, rows.rotation_b)
        offset = turned_back(rows.rotation_a, centre_b - centre_a).T
        bound = best_axes(turn, offset, table.bound_half[rows.first].T, table.bound_half[rows.second].T).distance
        near = bound <= rows.radius_a + rows.radius_b + reach[rows.owner]
        if near.all():
            return self._by_fcl(rows)
        result = Separation(bound, np.tile([0.0, 0.0, 1.0], (len(rows), 1)), centre_a, centre_b)
        chosen = np.flatnonzero(near)
        if len(chosen):
            found = self._by_fcl(rows.chosen(chosen))
            for name in ("distance", "normal", "first", "second"):
                getattr(result, name)[chosen] = getattr(found, name)
        return result

    def _sharp(self, rows: _Rows) -> BoolArray:
        """Which rows are of two boxes that meet with sharp edges."""
        table = self._table
        return np.asarray(table.is_box[rows.first] & table.is_box[rows.second] & (table.kind[rows.second] == Kind.BOX))

    def _by_fcl(self, rows: _Rows, depths: bool = True) -> Separation:
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
        turn = np.matmul(rows.rotation_a.transpose(0, 2, 1), rows.rotation_b)
        found = separations(first, second, turn, turned_back(rows.rotation_a, rows.centre_b - rows.centre_a), depths)
        ends = (turned(rows.rotation_a, end) + rows.centre_a for end in (found.first, found.second))
        return Separation(found.distance, turned(rows.rotation_a, found.normal), *ends)

    def _triangle_object(self, core: int, number: int) -> Convex:
        return self._convex.triangle(core, number, self._mesh(core).corners[number])

    def _finish(
        self, rows: _Rows, separated: AxisSeparation, reach: FloatArray, distance: FloatArray, found: list[_Found], corners: bool
    ) -> None:
        """Add the patches of rows within reach to ``found`` and lower bounds on the others to ``distance``."""
        gap = _bounded(rows, separated.separation.distance - rows.radius_a - rows.radius_b, reach)
        near = gap <= reach[rows.owner]
        np.minimum.at(distance, rows.owner[~near], gap[~near])
        if not near.any():
            return
        chosen = np.flatnonzero(near)
        rows = rows.chosen(chosen)
        separation, exact = _chosen(separated.separation, chosen), separated.exact[chosen]
        patch = self._patches(rows, separation)
        unsure = ~exact & (patch.gap > _CERTAIN)
        if unsure.any():
            again = rows.chosen(unsure)
            measured = self._by_fcl(again)
            self._finish(again, _exact(measured), reach, distance, found, corners)
            rows, separation, exact, patch = rows.chosen(~unsure), _chosen(separation, ~unsure), exact[~unsure], _chosen(patch, ~unsure)
        if len(rows):
            gap = separation.distance - rows.radius_a - rows.radius_b + np.where(exact, 0.0, patch.gap)
            found.append(_found(rows, separation.normal, gap, patch, corners))

    def _patches(self, rows: _Rows, separation: Separation) -> Patches:
        """Patches of rows of one group, their centres and corners in the world."""
        normal = separation.normal
        middle = (separation.first + normal * rows.radius_a[:, None] + separation.second - normal * rows.radius_b[:, None]) / 2
        count = len(rows)
        if self._table.kind[rows.first[0]] == Kind.POINT:
            none = np.zeros(count, dtype=np.bool_)
            return Patches(middle, np.zeros(count), none, np.zeros(count), middle[:, None], none[:, None], none)
        first, many_a, wide_a = self._polygons(rows.first, rows.triangle_a, rows.rotation_a, rows.centre_a, normal)
        second, many_b, wide_b = self._polygons(rows.second, rows.triangle_b, rows.rotation_b, rows.centre_b, -normal)
        first -= middle[:, None]
        second -= middle[:, None]
        parts = []
        for corners_a, corners_b in ((FEW, FEW), (MANY, FEW), (FEW, MANY), (MANY, MANY)):
            alike = np.flatnonzero((many_a == (corners_a == MANY)) & (many_b == (corners_b == MANY)))
            if len(alike):
                parts.append((alike, patches(first[alike, :corners_a], second[alike, :corners_b], normal[alike])))
        result = _merged(count, parts)
        kind = np.maximum(self._table.kind[rows.first], self._table.kind[rows.second])
        result = _at_nearest_points(result, np.isin(kind, _DRAWN_ROUGHLY))
        return Patches(
            middle + result.centre, result.area, result.found, result.gap, middle[:, None] + result.corners, result.used, wide_a & wide_b
        )

    def _polygons(
        self, core: IntArray, triangle: IntArray | None, rotation: FloatArray, centre: FloatArray, direction: FloatArray
    ) -> tuple[FloatArray, BoolArray, BoolArray]:
        if triangle is None:
            return self._features.polygons(core, rotation, centre, direction)
        count = len(core)
        corners = self._corners(core, triangle, rotation, centre)
        return triangle_polygons(corners), np.zeros(count, dtype=np.bool_), np.ones(count, dtype=np.bool_)


def _joined(groups: list[_Rows]) -> _Rows:
    """Groups without triangles as one."""
    names = [f.name for f in fields(_Rows) if not f.name.startswith("triangle")]
    return groups[0] if len(groups) == 1 else _Rows(*(np.concatenate([getattr(rows, name) for rows in groups]) for name in names))


def _together(groups: list[tuple[_Rows, AxisSeparation]]) -> tuple[_Rows, AxisSeparation]:
    """Groups without triangles as one."""
    if len(groups) == 1:
        return groups[0]
    parts = (np.concatenate([getattr(s.separation, f.name) for _, s in groups]) for f in fields(Separation))
    return _joined([rows for rows, _ in groups]), AxisSeparation(Separation(*parts), np.concatenate([s.exact for _, s in groups]))


def _at_nearest_points(patch: Patches, rough: BoolArray) -> Patches:
    """Patches around the origin, the nearest points of their cores; ``rough`` ones that miss it moved there."""
    mask = patch.used[..., None]
    low = np.where(mask, patch.corners, np.inf).min(axis=1)
    high = np.where(mask, patch.corners, -np.inf).max(axis=1)
    missed = rough & patch.found & ((low > _NEAR) | (high < -_NEAR)).any(axis=1)
    keep = ~missed[:, None]
    return replace(patch, centre=patch.centre * keep, area=patch.area * ~missed, corners=patch.corners * keep[..., None])


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products (3, 3, p) of matrices (3, 3, p)."""
    return np.asarray(np.einsum("ijp,jkp->ikp", a, b))


def relative_pose(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3, p) and offset (3, p) of poses ``b`` in the frames of poses ``a``, both (12, p): rotation by rows, then position."""
    turn_a, turn_b = a[:9].reshape(3, 3, -1), b[:9].reshape(3, 3, -1)
    return np.einsum("kip,kjp->ijp", turn_a, turn_b), np.einsum("ijp,ip->jp", turn_a, b[9:] - a[9:])


def _matrices(rotation: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Identities and relative poses (p, 4, 4)."""
    count = offset.shape[1]
    matrices = np.zeros((count, 4, 4))
    matrices[:, :3, :3] = rotation.transpose(2, 0, 1)
    matrices[:, :3, 3] = offset.T
    matrices[:, 3, 3] = 1.0
    return np.broadcast_to(np.eye(4), (count, 4, 4)), matrices


def _products(start: IntArray, pairs: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Every core of each pair's first body with every core of its second: number of the pair, of either core."""
    count = np.diff(start)[pairs]
    many = count[:, 0] * count[:, 1]
    owner = np.repeat(np.arange(len(pairs)), many)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(many) - many, many)
    return owner, start[pairs[owner, 0]] + within // count[owner, 1], start[pairs[owner, 1]] + within % count[owner, 1]


def _bounded(rows: _Rows, gap: FloatArray, reach: FloatArray) -> FloatArray:
    """Gaps as lower bounds on the distance of the bodies: beyond its reach not all triangles of a mesh have been looked at."""
    return gap if rows.triangle_b is None else np.minimum(gap, reach[rows.owner] + _BEYOND)


def _exact(separation: Separation) -> AxisSeparation:
    return AxisSeparation(separation, np.ones(len(separation.distance), dtype=np.bool_))


def _ends(rotation: FloatArray, centre: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    along = rotation[:, :, 2] * half[:, 2:]
    return centre - along, centre + along


def _segment_and_box(rows: _Rows, half_a: FloatArray, half_b: FloatArray) -> AxisSeparation:
    """Exact where they are apart; a segment through a box is a box without width and height."""
    start, end = _ends(rows.rotation_a, rows.centre_a, half_a)
    separation = segment_to_box(start, end, rows.rotation_b, rows.centre_b, half_b)
    through = np.flatnonzero(separation.distance < 1e-9)
    if len(through):
        sides = (rows.rotation_a, rows.centre_a, half_a, rows.rotation_b, rows.centre_b, half_b)
        deep = box_to_box(*(side[through] for side in sides)).separation
        for name in ("distance", "normal", "first", "second"):
            getattr(separation, name)[through] = getattr(deep, name)
    return _exact(separation)


def _chosen(values: Any, rows: Any) -> Any:
    """Rows of a dataclass of arrays."""
    return type(values)(*(getattr(values, f.name)[rows] for f in fields(values)))


def _merged(count: int, parts: list[tuple[IntArray, Patches]]) -> Patches:
    """Results for parts of ``count`` rows put together, shorter rows of corners filled up."""
    if len(parts) == 1:
        return parts[0][1]
    merged = []
    for field in fields(Patches):
        values = [getattr(part, field.name) for _, part in parts]
        shape = max(value.shape[1:] for value in values)
        whole = np.zeros((count, *shape), dtype=values[0].dtype)
        for (rows, _), value in zip(parts, values, strict=True):
            if value.ndim == 1 or value.shape[1:] == shape:
                whole[rows] = value
            else:
                whole[rows, : value.shape[1]] = value
        merged.append(whole)
    return Patches(*merged)


def _found(rows: _Rows, normal: FloatArray, distance: FloatArray, patch: Patches, corners: bool) -> _Found:
    """With normals from the first body of the pair to the second."""
    points = None
    if corners:
        points = [c[u] if u.any() else m[None] for c, u, m in zip(patch.corners, patch.used, patch.centre, strict=True)]
    outward = np.where(rows.flipped[:, None], -normal, normal)
    return _Found(rows.owner, distance, outward, patch.centre, patch.area, np.where(patch.wide, patch.area, 0.0), points)


def _reduced(distance: FloatArray, found: list[_Found], corners: bool) -> PairPatches:
    """One patch per pair of bodies from those of its cores and triangles, weighted by their areas and by how near they are beside the
    nearest one."""
    count = len(distance)
    normal = np.tile([0.0, 0.0, 1.0], (count, 1))
    centre, area = np.zeros((count, 3)), np.zeros(count)
    if not found:
        return PairPatches(distance, normal.T, centre.T, area, tuple(np.zeros((0, 3)) for _ in range(count)) if corners else ())
    owner, each, normals, centres, weights, areas = (
        np.concatenate([getattr(f, name) for f in found]) for name in ("owner", "distance", "normal", "centre", "weight", "area")
    )
    if len(np.unique(owner)) == len(owner):
        distance[owner] = np.minimum(distance[owner], each)
        normal[owner], centre[owner], area[owner] = normals, centres, areas
        kept = np.ones(len(owner), dtype=np.bool_)
    else:
        np.minimum.at(distance, owner, each)
        above = each - distance[owner]
        within = _TOGETHER + PATCH_GAP * weights / (weights + _FACE_AREA)
        near = np.square(np.clip(2.0 - 2.0 * above / within, 0.0, 1.0))
        weights = near * (weights + _POINT_AREA)
        kept = weights > 0
        total = np.zeros(count)
        np.add.at(total, owner, weights)
        total = np.where(total > 0, total, 1.0)
        np.add.at(centre, owner, centres * weights[:, None])
        centre /= total[:, None]
        np.add.at(area, owner, near * areas)
        mean = np.zeros((count, 3))
        np.add.at(mean, owner, normals * weights[:, None])
        length = np.sqrt(dot(mean, mean))
        # Normals that cancel, as those of a body in a narrow gap do: the nearest one stands.
        order = np.argsort(-above, kind="stable")
        normal[owner[order]] = normals[order]
        whole = length > 0.1 * total
        normal[whole] = mean[whole] / length[whole, None]
    if not corners:
        return PairPatches(distance, normal.T, centre.T, area)
    points: list[list[FloatArray]] = [[] for _ in range(count)]
    flat_points = [c for f in found for c in (f.corners or [])]
    for k in np.flatnonzero(kept).tolist():
        points[owner[k]].append(flat_points[k])
    return PairPatches(distance, normal.T, centre.T, area, tuple(_outline(p, normal[k]) for k, p in enumerate(points)))


def _outline(points: list[FloatArray], normal: FloatArray) -> FloatArray:
    """Corners of the convex hull of a patch in its plane, at most ``MAX_PATCH_POINTS`` of them."""
    if not points:
        return np.zeros((0, 3))
    every = np.concatenate(points)
    u, v = (axis[0] for axis in contact_plane(normal[None]))
    flat = np.stack([every @ u, every @ v], axis=1)
    _, first = np.unique(np.round(flat, 5), axis=0, return_index=True)
    chosen = np.sort(first)
    chosen = chosen[hull_2d(flat[chosen])]
    if len(chosen) > MAX_PATCH_POINTS:
        chosen = chosen[np.linspace(0, len(chosen), MAX_PATCH_POINTS, endpoint=False).astype(int)]
    return every[chosen]
