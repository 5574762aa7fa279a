"""Narrow phase: signed distance and contact patch of pairs of bodies, many pairs at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray, chosen_of, joined, some_of, taken
from ..shapes import Compound, Shape
from .body_patches import CoreContacts, PairPatches, core_contacts, reduced
from .box_pairs import BoxPairs
from .convex import ConvexDistances
from .core_distances import CoreDistances, exact
from .core_pairs import BEYOND, CorePairing, CorePairs, bounded
from .core_patches import CorePatches
from .cores import CoreTable, Kind
from .frames import chunks, upwards
from .hollow_hulls import HollowHulls
from .known_patches import KnownPatches
from .separating_axes import AxisSeparation
from .surface_pairs import SurfacePairs
from .surfaces import Surfaces

_CERTAIN = 1e-4
"""Metres between a lower and an upper bound on a distance up to which the lower bound counts as the
distance."""


class NarrowPhase:
    """Queries between bodies given by number. ``solid`` says which bodies are volumes: their meshes
    count as hulls. ``is_box`` (n,): which bodies are single boxes; ``is_mesh`` (n,): which have a
    mesh. What it knows of shapes that are also in the one ``before`` it takes over.

    A pair is placed by the ``rotation`` (3, 3, p) of its second body and the ``offset`` (3, p) of
    its origin in the frame of the first; results are in that frame.
    """

    def __init__(
        self,
        shapes: Sequence[Shape],
        solid: Sequence[bool] | None = None,
        before: NarrowPhase | None = None,
    ) -> None:
        self._table: CoreTable = CoreTable.of(
            shapes, solid or [False] * len(shapes), None if before is None else before._table
        )
        table = self._table
        self._shapes = tuple(shapes)
        self._known: KnownPatches = KnownPatches(
            self._shapes, None if before is None else before._known
        )
        self._boxes = BoxPairs(table)
        self.is_box = self._boxes.is_box
        self.is_mesh = (
            np.logical_or.reduceat(np.append(table.kind == Kind.MESH, False), table.start[:-1])
            if len(shapes)
            else self.is_box
        )
        self._is_single = np.diff(table.start) == 1  # the parts of others may move
        surfaces = Surfaces(table)
        bodies = ConvexDistances(table)
        self._kept = surfaces
        if before is not None:
            surfaces.take_over(before._kept)
        self._pairing = CorePairing(table, surfaces)
        self._distances = CoreDistances(table, self._pairing, bodies)
        self._patches = CorePatches(table, self._pairing)
        self._hollow = HollowHulls(shapes, table, bodies)
        self._surfaces = SurfacePairs(table, self._pairing, surfaces, bodies, self._patches)

    @property
    def thickness(self) -> FloatArray:
        """Smallest extent of each body's thinnest part (n,) [m]: a step longer than that may pass
        through it."""
        return self._table.thickness

    def place(self, body: int, shape: Compound, bounds: FloatArray) -> bool:
        """Give a body of several cores the ``shape`` with these local ``bounds``, which differs
        from its own only in the places of its parts. Returns False where it has a single core, or
        no core of the table had a place."""
        if not self._table.placed or self._is_single[body]:
            return False
        self._table.place(body, shape)
        self._hollow.measure(body, bounds)
        return True

    def query(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, limit: FloatArray
    ) -> PairPatches:
        """Distances and patches of ``pairs`` (p, 2). Distances up to ``limit`` (p,) metres are
        exact; beyond, they are lower bounds."""
        found = self._query(pairs, rotation, offset, limit)
        self._hollow.limit(pairs, rotation, offset, found)
        return found

    def _query(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, limit: FloatArray
    ) -> PairPatches:
        boxes = self._boxes.chosen(pairs, rotation, offset)
        if boxes is None:
            return self._known_or_general(pairs, rotation, offset, limit)
        found = self._boxes.patches(boxes, pairs[boxes.rows], limit[boxes.rows])
        if len(boxes.rows) == len(pairs):
            return found
        others = np.delete(np.arange(len(pairs)), boxes.rows)
        rest = self._known_or_general(
            pairs[others], taken(rotation, others), taken(offset, others), limit[others]
        )
        return PairPatches.joined(len(pairs), (boxes.rows, found), (others, rest))

    def _known_or_general(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray, limit: FloatArray
    ) -> PairPatches:
        """`_general`, which pairs with a mesh are only computed by where they are not known."""
        kept = self.is_mesh[pairs].any(axis=1) & self._is_single[pairs].all(axis=1)
        mine, others = kept.nonzero()[0], (~kept).nonzero()[0]

        if len(mine) == 0:
            return self._general(pairs, rotation, offset, limit)

        def general(rows: IntArray) -> PairPatches:
            return self._general(
                pairs[rows], taken(rotation, rows), taken(offset, rows), limit[rows]
            )

        found = self._known.of(
            [(self._shapes[a], self._shapes[b]) for a, b in pairs[mine].tolist()],
            (taken(rotation, mine), taken(offset, mine), limit[mine]),
            lambda rows: general(mine[rows]),
        )
        return PairPatches.joined(len(pairs), (mine, found), (others, general(others)))

    def corners(
        self,
        pairs: IntArray,
        rotation: FloatArray,
        offset: FloatArray,
        limit: FloatArray,
        normal: FloatArray,
        centre: FloatArray,
    ) -> tuple[IntArray, FloatArray]:
        """The number (k,) of the pair, and the place (3, k), of each corner of the patches of
        ``pairs``, which have this ``normal`` and ``centre`` (3, p).

        Args:
            pairs: numbers of the bodies (p, 2).
            rotation: of the second body in the frame of the first (3, 3, p).
            offset: of its origin there (3, p) [m].
            limit: distance up to which there is a patch (p,) [m].
            normal: of the patches (3, p).
            centre: of the patches (3, p) [m].
        """
        parts = []
        others = np.arange(len(pairs))
        boxes = self._boxes.chosen(pairs, rotation, offset)
        if boxes is not None:
            number, places = self._boxes.corners(
                boxes, pairs[boxes.rows], normal[:, boxes.rows], centre[:, boxes.rows]
            )
            parts.append((boxes.rows[number], places))
            others = np.delete(others, boxes.rows)
        if len(others):
            corners = self._general(
                pairs[others], rotation[..., others], offset[:, others], limit[others], corners=True
            ).corners
            parts.append(
                (others.repeat([len(each) for each in corners]), np.concatenate(corners).T)
            )
        return np.concatenate([number for number, _ in parts]), np.concatenate(
            [places for _, places in parts], axis=1
        )

    def clearances(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray) -> FloatArray:
        """Signed distances (p,), or lower bounds on them that are positive only if the distance is.
        Cheaper than `query`."""
        boxes = self._boxes.chosen(pairs, rotation, offset)
        if boxes is None:
            return self.directed_clearances(pairs, rotation, offset)[0]
        distance = np.empty(len(pairs))
        distance[boxes.rows] = self._boxes.clearances(boxes)
        if len(boxes.rows) < len(pairs):
            others = np.delete(np.arange(len(pairs)), boxes.rows)
            distance[others] = self.directed_clearances(
                pairs[others], rotation[..., others], offset[:, others]
            )[0]
        return distance

    def directed_clearances(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """`clearances` (p,), and the unit normals (3, p) from first to second bodies along which
        they are measured."""
        found = self._boxes.directed_clearances(pairs, rotation, offset)
        if found is not None:
            return found
        count = len(pairs)
        distance = np.full(count, np.inf)
        normal = upwards(count)
        for rows in self._pairing.groups(pairs, rotation, offset):
            if self._is_on_mesh(rows):
                gap, normals = self._surfaces.gaps(rows)
            else:
                separation = self._distances.separated(rows)
                gap, normals = separation.distance, separation.normal
            gap = gap - rows.radius_a - rows.radius_b
            outward = np.where(rows.flipped, -normals, normals)
            order = np.argsort(-gap, kind="stable")
            owner = rows.owner[order]
            closer = gap[order] < distance[owner]
            normal[:, owner[closer]] = outward[:, order[closer]]
            np.minimum.at(distance, owner, gap[order])
        return distance, normal

    def gaps(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray) -> FloatArray:
        """Distances (p,) [m], 0 where bodies overlap. Cheaper than `query`, which finds the
        depth."""
        distance = np.full(len(pairs), np.inf)
        for rows in self._pairing.groups(pairs, rotation, offset):
            if self._is_on_mesh(rows):
                gap = self._surfaces.gaps(rows, solid=True)[0]
            else:
                gap = self._distances.separated(rows, depths=False).distance
            np.minimum.at(distance, rows.owner, gap - rows.radius_a - rows.radius_b)
        return np.asarray(np.maximum(distance, 0.0))

    def box_gaps(self, pairs: IntArray, rotation: FloatArray, offset: FloatArray) -> FloatArray:
        """Lower bounds on the distances (p,) [m]: those of boxes around the parts of bodies. Far
        cheaper than the distances of meshes."""
        least = np.full(len(pairs), np.inf)
        for rows in self._pairing.groups(pairs, rotation, offset):
            gap = self._distances.box_gaps(rows) - rows.radius_a - rows.radius_b
            np.minimum.at(least, rows.owner, gap)
        return least

    def _is_on_mesh(self, rows: CorePairs) -> bool:
        return bool(self._table.kind[rows.second[0]] == Kind.MESH)

    def _general(
        self,
        pairs: IntArray,
        rotation: FloatArray,
        offset: FloatArray,
        limit: FloatArray,
        corners: bool = False,
    ) -> PairPatches:
        """Distances and patches of pairs of any shapes, as of `query`.

        Args:
            pairs: numbers of the bodies (p, 2).
            rotation: of the second body in the frame of the first (3, 3, p).
            offset: of its origin there (3, p) [m].
            limit: distance beyond which a lower bound will do (p,) [m].
            corners: whether the outlines of the patches are wanted.
        """
        distance = np.full(len(pairs), np.inf)
        found: list[CoreContacts] = []
        closed: list[tuple[CorePairs, AxisSeparation]] = []
        others = []
        for rows in self._pairing.groups(pairs, rotation, offset):
            if self._is_on_mesh(rows):
                rows = self._within(rows, limit, distance)
                if len(rows) == 0:
                    continue
                meet = self._surfaces.meet(rows)
                if meet.any():
                    self._surfaces.contacts(chosen_of(rows, meet), limit, distance, found, corners)
                rows = chosen_of(rows, ~meet)
                rows = chosen_of(rows, ~self._surfaces.inside(rows, limit, distance, found))
                rows = self._surfaces.near(rows, limit) if len(rows) else rows
                if len(rows):
                    self._on_triangles(rows, limit, distance, found, corners)
            elif self._distances.in_closed_form(rows):
                closed.append((rows, self._distances.separated(rows)))
            else:
                others.append(rows)
        # The rest together: fewer, longer arrays.
        if others:
            rows = self._within(joined(others), limit, distance)
            if len(rows):
                closed.append((rows, exact(self._distances.by_fcl(rows))))
        if closed:
            rows = joined([group for group, _ in closed])
            separated = joined([separated for _, separated in closed])
            is_point = self._table.kind[rows.first] == Kind.POINT
            for alike in (is_point, ~is_point):
                if alike.any():
                    several = some_of(rows, alike), some_of(separated, alike)
                    self._finish(*several, limit, distance, found, corners)
        return reduced(np.where(np.isinf(distance), limit + BEYOND, distance), found, corners)

    def _on_triangles(
        self,
        rows: CorePairs,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """`_finish` for convex cores of one kind on triangles (n,)."""
        for part in chunks(len(rows)):
            some = chosen_of(rows, part)
            least = self._surfaces.least_distances(some)
            chosen, separated = self._distances.from_triangles(some, least)
            self._finish(chosen_of(some, chosen), separated, limit, distance, found, corners)

    def _within(self, rows: CorePairs, limit: FloatArray, distance: FloatArray) -> CorePairs:
        """The rows whose bounding boxes are within ``limit`` (p,) of each other; lower bounds on
        the others are added to ``distance`` (p,)."""
        gap = self._distances.box_gaps(rows) - rows.radius_a - rows.radius_b
        far = gap > limit[rows.owner]
        np.minimum.at(distance, rows.owner[far], gap[far])
        return some_of(rows, ~far)

    def _finish(
        self,
        rows: CorePairs,
        separated: AxisSeparation,
        limit: FloatArray,
        distance: FloatArray,
        found: list[CoreContacts],
        corners: bool,
    ) -> None:
        """Add the patches of rows within ``limit`` to ``found`` and lower bounds on the others to
        ``distance``.

        Args:
            rows: pairs of cores (n,).
            separated: their separations (n,).
            limit: largest distance of a contact, of each pair of bodies (p,) [m].
            distance: of each pair of bodies (p,) [m], which is changed.
            found: contacts so far, which is added to.
            corners: whether the outlines of the patches are wanted.
        """
        gap = bounded(rows, separated.distance - rows.radius_a - rows.radius_b, limit)
        near = gap <= limit[rows.owner]
        np.minimum.at(distance, rows.owner[~near], gap[~near])
        if not near.any():
            return
        rows = some_of(rows, near)
        separated = some_of(separated, near)
        patch = self._patches.patches(rows, separated)
        unsure = ~separated.exact & (patch.gap > _CERTAIN)
        if unsure.any():
            again = chosen_of(rows, unsure)
            self._finish(
                again, exact(self._distances.by_fcl(again)), limit, distance, found, corners
            )
            rows = chosen_of(rows, ~unsure)
            separated = chosen_of(separated, ~unsure)
            patch = chosen_of(patch, ~unsure)
        if len(rows):
            gap = (
                separated.distance
                - rows.radius_a
                - rows.radius_b
                + np.where(separated.exact, 0.0, patch.gap)
            )
            normal = separated.normal
            if rows.triangle_b is not None:
                gap, normal, patch = self._surfaces.sunk_in(rows, gap, normal, patch)
            found.append(core_contacts(rows, normal, gap, patch, corners))
