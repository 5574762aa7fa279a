"""Pairs of bodies as pairs of their cores in world space, in groups of the same kinds, meshes as
their triangles nearby."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    chosen_of,
    part_of,
    portions,
    ranges,
    runs,
    taken,
)
from .cores import CoreTable, Kind, Size
from .frames import chunks, dot, product, relative, turned, turned_back
from .manifold import most_within
from .mesh_index import MeshIndex
from .surfaces import CoreSurface, Surfaces
from .triangles import apart_by, beside, triangle_to_triangle

BEYOND = 1e-9
"""Metres beyond the limit of a query at which a distance is reported where only a lower bound is
known."""

_AT_ONCE = 1 << 14
"""Pairs of bounds compared at a time: few enough for the processor's cache."""

_SAME_BOUND = 1e-7
"""Metres by which bounds on distances differ that are the same but for rounding."""

_OPPOSITE = -1e-3
"""Cosine of the angle between the outward normals of two faces below which they face each other."""


_Triangles = tuple[IntArray, IntArray, IntArray, IntArray]
"""Pairs of triangles (m,) of rows: number of the row, of both triangles, and which pieces they
belong to, see `CorePairs`."""


@dataclass(slots=True)
class CorePairs:
    """Pairs of convex cores in world space.

    Attributes:
        owner: (n,) number of the pair of bodies.
        flipped: (n,) whether the first core is one of the second body of that pair.
        first, second: (n,) numbers of the cores.
        rotation_a, centre_a, rotation_b, centre_b: (3, 3, n), (3, n) poses of the cores [m].
        radius_a, radius_b: (n,) by which the cores are grown [m].
        triangle_a, triangle_b: (n,) number of a triangle, in place of a core that is a mesh.
        piece: (n,) of triangles: which pieces of the same two cores they belong to, as a number.
    """

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
    piece: IntArray | None = None

    def __len__(self) -> int:
        return len(self.owner)


class _Placing(NamedTuple):
    """Poses of m first surfaces in the frames of the second ones.

    Attributes:
        turn: rotations (3, 3, m).
        shift: origins (3, m) [m].
    """

    turn: FloatArray
    shift: FloatArray

    def of(self, pair: IntArray, points: FloatArray) -> FloatArray:
        """Points (3, n) or (3, k, n) of first surfaces, in the frames of the second ones; ``pair``
        (n,): number of the pair of each point."""
        shift: FloatArray = taken(self.shift, pair)
        return turned(taken(self.turn, pair), points) + (
            shift if points.ndim == 2 else shift[:, None]
        )

    def back_to_first(self, second: CoreSurface, reach: FloatArray) -> FloatArray:
        """Boxes (m, 2, 3) around the second surface, grown by ``reach`` (m,), in the first one's
        frames."""
        back = _Placing(self.turn.transpose(1, 0, 2), -turned_back(self.turn, self.shift))
        return back.onto_second(second, reach)

    def onto_second(self, first: CoreSurface, reach: FloatArray) -> FloatArray:
        """Boxes (m, 2, 3) around the first surface, grown by ``reach`` (m,), in the second one's
        frames."""
        middle = (first.low + first.high) / 2
        half = (first.high - first.low) / 2
        centre = turned(self.turn, middle[:, None]) + self.shift
        extent = turned(np.abs(self.turn), half[:, None] + reach)
        return np.stack([centre - extent, centre + extent]).transpose(2, 0, 1)


class CorePairing:
    """Makes pairs of cores from pairs of the bodies of a table."""

    def __init__(self, table: CoreTable, surfaces: Surfaces) -> None:
        self._table = table
        self._surfaces = surfaces

    def groups(
        self, pairs: IntArray, rotation: FloatArray, offset: FloatArray
    ) -> Iterator[CorePairs]:
        """All pairs of cores of ``pairs`` of bodies, placed as in `NarrowPhase`, in groups of the
        same kinds, the simpler kind first."""
        table = self._table
        owner, first, second = _products(table.start, pairs)
        turn_b: FloatArray = taken(rotation, owner)
        place_b: FloatArray = taken(offset, owner)
        # The frame is that of the first body of each pair, see `NarrowPhase`.
        turn_a = np.eye(3)[:, :, None]
        place_a = np.zeros((3, 1))
        if table.placed:
            place_b = place_b + turned(turn_b, taken(table.offset, second))
            turn_b = product(turn_b, taken(table.rotation, second))
            turn_a, place_a = taken(table.rotation, first), taken(table.offset, first)
        flipped = table.kind[first] > table.kind[second]
        first, second = np.where(flipped, second, first), np.where(flipped, first, second)
        rotation_a = np.where(flipped, turn_b, turn_a)
        centre_a = np.where(flipped, place_b, place_a)
        rotation_b = np.where(flipped, turn_a, turn_b)
        centre_b = np.where(flipped, place_a, place_b)
        kinds = table.kind[first] * len(Kind) + table.kind[second]
        radius_a, radius_b = (table.radius[Size.USUAL, core] for core in (first, second))
        everything = CorePairs(
            owner,
            flipped,
            first,
            second,
            rotation_a,
            centre_a,
            rotation_b,
            centre_b,
            radius_a,
            radius_b,
        )
        order = kinds.argsort(kind="stable")
        begin, size = runs(kinds[order])
        if len(begin) > 1:
            everything = chosen_of(everything, order)
        for first_row, count in zip(begin.tolist(), size.tolist(), strict=True):
            rows = part_of(everything, slice(first_row, first_row + count))
            kind_a, kind_b = divmod(int(kinds[order[first_row]]), len(Kind))
            if kind_b == Kind.MESH and kind_a == Kind.BOX:
                rows.radius_a = table.radius[Size.THICK, rows.first]
            if kind_b == Kind.MESH and kind_a == Kind.POINT:
                rows.radius_b = np.array(
                    [table.cores[core].mesh_radius_to_points for core in rows.second.tolist()]
                )
            yield rows

    def mesh(self, core: int) -> MeshIndex:
        """The triangles of a core that is a mesh or a hull."""
        return self._surfaces[core].index

    def on_triangles(self, rows: CorePairs, reach: FloatArray) -> CorePairs:
        """Convex cores of one kind against those triangles of their meshes that are within
        ``reach`` (n,) metres."""
        table = self._table
        turn = relative(rows.rotation_b, rows.rotation_a)
        middle = turned_back(
            rows.rotation_b,
            rows.centre_a
            + turned(rows.rotation_a, taken(table.bound_centre, rows.first))
            - rows.centre_b,
        )
        half = turned(np.abs(turn), taken(table.bound_half, rows.first))
        half += rows.radius_a + rows.radius_b + np.maximum(reach, 0.0)
        bounds = np.stack([middle - half, middle + half]).transpose(2, 0, 1)
        row = []
        triangle = []
        piece = []
        for surface, mine in self.alike(rows.second):
            box, near = surface.index.near(bounds[mine])
            row.append(mine[box])
            triangle.append(near)
            piece.append(surface.piece[near])
        every = np.concatenate(row)
        order = np.lexsort((every, rows.second[every]))
        expanded = chosen_of(rows, every[order])
        expanded.triangle_b = np.concatenate(triangle)[order]
        expanded.piece = np.concatenate(piece)[order]
        return expanded

    def alike(self, cores: IntArray) -> Iterator[tuple[CoreSurface, IntArray]]:
        """Each different surface of ``cores`` (n,), and where in these the cores (m,) are that have
        it."""
        different, of = np.unique(cores, return_inverse=True)
        surface = np.array([id(self._surfaces[core]) for core in different.tolist()])[of]
        order = surface.argsort(kind="stable")
        for begin, size in zip(*(n.tolist() for n in runs(surface[order])), strict=True):
            mine = order[begin : begin + size]
            yield self._surfaces[int(cores[mine[0]])], mine

    def near_triangles(
        self, rows: CorePairs, distance: FloatArray, beyond: float = 0.0
    ) -> CorePairs:
        """The pairs of triangles of pairs of surfaces that may be within ``distance`` (n,) metres
        of each other, and of those up to ``beyond`` [m] farther apart those that can belong to a
        patch, in order of the rows."""
        near = partial(self._near_of_alike, beyond=beyond)
        return self.with_triangles(rows, *self._triangles(rows, distance, near))

    def facing_triangles(self, rows: CorePairs, reach: FloatArray, margin: float) -> _Triangles:
        """The pairs of triangles, within ``reach`` (n,) [m], that look at each other and may lie
        over each other, seen along the normal of either; where one surface is a solid, only
        triangles within ``margin`` [m] of its bounds."""
        return self._triangles(rows, reach, partial(self._facing_of_alike, margin=margin))

    def with_triangles(
        self, rows: CorePairs, number: IntArray, first: IntArray, second: IntArray, piece: IntArray
    ) -> CorePairs:
        """Pairs of triangles (m,) of the ``rows`` of these numbers (m,)."""
        expanded = chosen_of(rows, number)
        expanded.triangle_a, expanded.triangle_b, expanded.piece = first, second, piece
        return expanded

    def _triangles(
        self,
        rows: CorePairs,
        reach: FloatArray,
        of_alike: Callable[
            [CoreSurface, CoreSurface, _Placing, FloatArray], tuple[IntArray, IntArray, IntArray]
        ],
    ) -> _Triangles:
        """Call ``of_alike`` for the rows of each pair of surfaces, and join what it finds, in order
        of the rows."""
        alike: dict[tuple[int, int], list[int]] = {}
        for k, pair in enumerate(zip(rows.first.tolist(), rows.second.tolist(), strict=True)):
            one, other = (id(self._surfaces[core]) for core in pair)
            alike.setdefault((one, other), []).append(k)
        none = np.zeros(0, dtype=np.int64)
        found: list[_Triangles] = [(none, none, none, none)]
        for numbers in map(np.array, alike.values()):
            some = chosen_of(rows, numbers)
            turn = relative(some.rotation_b, some.rotation_a)
            way = some.centre_a - some.centre_b
            placing = _Placing(turn, turned_back(some.rotation_b, way))
            first, second = (
                self._surfaces[int(core[numbers[0]])] for core in (rows.first, rows.second)
            )
            row, mine, theirs = of_alike(first, second, placing, reach[numbers])
            found.append((numbers[row], mine, theirs, _pieces(first, mine, second, theirs)))
        number, of_first, of_second, piece = (
            np.concatenate(parts) for parts in zip(*found, strict=True)
        )
        order = np.argsort(number, kind="stable")
        return number[order], of_first[order], of_second[order], piece[order]

    def _near_of_alike(
        self,
        first: CoreSurface,
        second: CoreSurface,
        placing: _Placing,
        distance: FloatArray,
        beyond: float,
    ) -> tuple[IntArray, IntArray, IntArray]:
        """The triangles of the same two surfaces in m poses that are near each other, as defined by
        `near_triangles`: number of the pose, of the first and of the second triangle."""
        reach = distance + beyond
        pair, near = first.index.near(placing.back_to_first(second, reach))
        corners = placing.of(pair, taken(first.corners, near))
        bounds = np.stack([corners.min(axis=1) - reach[pair], corners.max(axis=1) + reach[pair]])
        mine, theirs = second.index.near(bounds.transpose(2, 0, 1))
        pair = pair[mine]
        apart = [
            apart_by(taken(corners, mine[part]), taken(second.corners, theirs[part]))
            for part in chunks(len(mine))
        ]
        bound = np.concatenate(apart)
        most = distance[pair]
        if beyond > 0:
            radius = np.minimum(first.radii[near[mine]], second.radii[theirs])
            piece = _pieces(first, near[mine], second, theirs)
            if piece.any():
                of = by_piece(pair, piece)
                lowest = _lowest(of, bound, reach[pair])
                found = triangle_to_triangle(
                    taken(corners, mine[lowest]), taken(second.corners, theirs[lowest])
                )
                least = np.full(of.max() + 1, np.inf)
                np.minimum.at(least, of[lowest], found.distance)
                most = np.maximum(most, least[of])
            most = np.minimum(most + np.minimum(most_within(radius), beyond), reach[pair])
        possible = (bound <= most).nonzero()[0]
        return pair[possible], near[mine[possible]], theirs[possible]

    def _facing_of_alike(
        self,
        first: CoreSurface,
        second: CoreSurface,
        placing: _Placing,
        reach: FloatArray,
        margin: float,
    ) -> tuple[IntArray, IntArray, IntArray]:
        """The triangles of the same two surfaces in m poses that face each other, as defined by
        `facing_triangles`, in the form of `_near_of_alike`.

        Args:
            first: the first surface.
            second: the second surface.
            placing: the poses.
            reach: greatest distance of triangles (m,) [m].
            margin: as of `facing_triangles` [m].
        """
        within = np.full_like(reach, margin)
        pair, near = first.index.near(
            placing.back_to_first(second, within if second.depth > 0 else reach)
        )
        middle_a = placing.of(pair, taken(first.middles, near))
        radius_a = first.radii[near]
        middle_b, radius_b = second.middles, second.radii
        normal = turned(taken(placing.turn, pair), taken(first.normals, near))
        half = np.abs(normal) * reach[pair] + radius_a
        bounds = np.stack([middle_a - half, middle_a + half])
        counts = np.ones((len(reach), len(radius_b)), dtype=np.bool_)
        if first.depth > 0:
            around = placing.onto_second(first, within)
            low, high = around[pair].transpose(1, 2, 0)
            bounds = np.stack([np.maximum(bounds[0], low), np.minimum(bounds[1], high)])
            counts[:] = False
            counts[second.index.near(around)] = True
        every = _in_boxes(middle_b - radius_b, middle_b + radius_b, counts, bounds, pair)
        kept: list[tuple[IntArray, IntArray]] = []
        for part in chunks(len(every[0])):
            mine, theirs = (numbers[part] for numbers in every)
            against = dot(taken(normal, mine), taken(second.normals, theirs))
            if first.depth == 0 or second.depth == 0:  # either side of a shell can face others
                against = -np.abs(against)
            mine = mine[against < _OPPOSITE]
            theirs = theirs[against < _OPPOSITE]
            way = taken(middle_b, theirs) - taken(middle_a, mine)
            both = radius_a[mine] + radius_b[theirs]
            over = ~beside(way, both, taken(normal, mine))
            over &= ~beside(way, both, taken(second.normals, theirs))
            kept.append((mine[over], theirs[over]))
        mine, theirs = (np.concatenate(parts) for parts in zip(*kept, strict=True))
        return pair[mine], near[mine], theirs

    def corners(
        self, mesh: IntArray, triangle: IntArray, rotation: FloatArray, centre: FloatArray
    ) -> FloatArray:
        """World corners (3, 3, n), by coordinate and corner, of triangles of meshes."""
        local = np.empty((3, 3, len(mesh)))
        for surface, mine in self.alike(mesh):
            local[..., mine] = taken(surface.corners, triangle[mine])
        return turned(rotation, local) + centre[:, None]


def _pieces(first: CoreSurface, mine: IntArray, second: CoreSurface, theirs: IntArray) -> IntArray:
    """Which pieces of two surfaces triangles (n,) of the first and of the second belong to."""
    if first.pieces == second.pieces == 1:
        return np.zeros_like(mine)
    return first.piece[mine] * second.pieces + second.piece[theirs]


def _lowest(group: IntArray, bound: FloatArray, most: FloatArray) -> IntArray:
    """Indices of the pairs of triangles (n,) that have the lowest ``bound`` [m] of their ``group``,
    if that is at most ``most``; over a flat floor several have the same one."""
    low = np.full(group.max() + 1, np.inf)
    np.minimum.at(low, group, bound)
    return (bound <= np.minimum(low[group] + _SAME_BOUND, most)).nonzero()[0]


def by_piece(group: IntArray, piece: IntArray) -> IntArray:
    """Numbers (n,) of the groups into which each ``group`` (n,) is divided by ``piece`` (n,)."""
    if not piece.any():
        return group
    return np.unique(group * (piece.max() + 1) + piece, return_inverse=True)[1]


def _in_boxes(
    low: FloatArray, high: FloatArray, counts: BoolArray, boxes: FloatArray, group: IntArray
) -> tuple[IntArray, IntArray]:
    """Numbers of boxes and of what is in them.

    Args:
        low: lowest corners of the bounds of what may be in boxes (3, t).
        high: highest corners (3, t).
        counts: which of these may be in boxes of a group (m, t).
        boxes: lowest and highest corners (2, 3, n).
        group: of each box (n,), ascending.
    """
    found = [np.zeros((2, 0), dtype=np.int64)]
    for begin, size in zip(*(numbers.tolist() for numbers in runs(group)), strict=True):
        others = counts[group[begin]].nonzero()[0]
        bottom, top = low[:, None, others], high[:, None, others]
        rows = np.arange(begin, begin + size)
        for part in portions(len(others) * (rows - begin + 1), _AT_ONCE):
            box = boxes[:, :, rows[part], None]
            met = ((bottom <= box[1]) & (top >= box[0])).all(axis=0)
            row, place = met.nonzero()
            found.append(np.stack([rows[part][row], others[place]]))
    of, member = np.concatenate(found, axis=1)
    return of, member


def _products(start: IntArray, pairs: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Every core of each pair's first body with every core of its second: number of the pair, of
    either core."""
    count = np.diff(start)[pairs]
    many = count[:, 0] * count[:, 1]
    owner = np.repeat(np.arange(len(pairs)), many)
    within = ranges(np.zeros_like(many), many)
    return (
        owner,
        start[pairs[owner, 0]] + within // count[owner, 1],
        start[pairs[owner, 1]] + within % count[owner, 1],
    )


def bounded(rows: CorePairs, gap: FloatArray, limit: FloatArray) -> FloatArray:
    """Gaps as lower bounds on the distances of the bodies: beyond ``limit`` not all triangles of a
    mesh are included."""
    return gap if rows.triangle_b is None else np.minimum(gap, limit[rows.owner] + BEYOND)
