"""Convex polytopes of triangles that grow corner by corner, as quickhull and the expanding polytope
algorithm need them."""

from __future__ import annotations

import math

Point = tuple[float, float, float]

_SLIVER = 1e-18
"""Twice the area [m^2] of a triangle up to which it has no normal."""


class Polytope:
    """A convex polytope whose faces are triangles.

    Attributes:
        points: places [m] that may become corners; others may be added.
        faces: by number, in the order in which they were made: three corners, anticlockwise seen
            from outside, outward unit normal, and the plane's height along it [m]. A sliver has
            the height infinity, and is replaced together with any face beside it.

    Args:
        points: as above.
        level: height above a face up to which points lie in it [m].
    """

    def __init__(self, points: list[Point], level: float) -> None:
        self.points = points
        self.faces: dict[int, tuple[tuple[int, int, int], Point, float]] = {}
        self._level = level
        self._face_at: dict[tuple[int, int], int] = {}  # the face to the left of an edge
        self._made = 0

    def add_face(self, i: int, j: int, k: int) -> int:
        """Add the face with these corners, by number, anticlockwise seen from outside. Returns the
        number of the face."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (self.points[corner] for corner in (i, j, k))
        ux, uy, uz = bx - ax, by - ay, bz - az
        vx, vy, vz = cx - ax, cy - ay, cz - az
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = math.sqrt(x * x + y * y + z * z)
        offset = math.inf
        if length > _SLIVER:
            x, y, z = x / length, y / length, z / length
            offset = x * ax + y * ay + z * az
        number = self._made
        self._made += 1
        self.faces[number] = (i, j, k), (x, y, z), offset
        self._face_at[i, j] = self._face_at[j, k] = self._face_at[k, i] = number
        return number

    def add_corner(self, apex: int, start: int) -> tuple[list[int], list[int]]:
        """Replace the faces that a point sees, ``start`` among them, by new ones around it. Returns
        the numbers of the former and of the latter."""
        x, y, z = self.points[apex]
        faces = self.faces
        visible = [start]
        seen = {start}
        border: list[tuple[int, int, int]] = []
        for number in visible:
            (i, j, k), _, _ = faces[number]
            for a, b in ((i, j), (j, k), (k, i)):
                other = self._face_at[b, a]
                if other in seen:
                    continue
                _, (nx, ny, nz), offset = faces[other]
                if offset == math.inf or nx * x + ny * y + nz * z - offset > self._level:
                    seen.add(other)
                    visible.append(other)
                else:
                    border.append((a, b, other))
        for number in visible:
            del faces[number]
        return visible, [self.add_face(a, b, apex) for a, b, other in border if other not in seen]
