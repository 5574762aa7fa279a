"""Sizes of bodies that waves spread in: those of the bounding box, and the wall of a hollow
body."""

from __future__ import annotations

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.arrays import FloatArray
from ...core.scene.measured import SHEET, wall_of
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit


class Sizes:
    """The sizes of bodies in an evaluation; those of bodies that share a mesh are found once."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._metres = metres_per_unit(depsgraph.scene)
        self._known: dict[tuple[float, ...], tuple[float, float, float]] = {}

    def of(self, obj: Object) -> tuple[float, float, float]:
        """Length, width and thickness of a body [m], in descending order. The thickness is that of
        its wall: by volume and area of a closed mesh, at most 1 cm of one with open edges."""
        mesh = obj.evaluated_get(self._depsgraph).data
        if not isinstance(mesh, Mesh) or len(mesh.polygons) == 0:
            return self._in_metres(obj, None)
        key = mesh.as_pointer(), *obj.scale, *obj.dimensions
        if key not in self._known:
            self._known[key] = self._in_metres(obj, mesh)
        return self._known[key]

    def _in_metres(self, obj: Object, mesh: Mesh | None) -> tuple[float, float, float]:
        large, middle, small = sorted(obj.dimensions, reverse=True)
        if mesh is not None:
            small = _wall(mesh, np.abs(obj.scale), (large, middle, small), SHEET / self._metres)
        return large * self._metres, middle * self._metres, small * self._metres


def _wall(mesh: Mesh, scale: FloatArray, size: tuple[float, float, float], sheet: float) -> float:
    """The thickness of a body whose bounding box has this ``size``, the greatest first. ``sheet``:
    that of a mesh with open edges, if it is not less."""
    corners = read_array(mesh.vertices, "co", 3).astype(np.float64) * scale
    mesh.calc_loop_triangles()
    a, b, c = corners[read_array(mesh.loop_triangles, "vertices", 3, np.int32)].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    area = float(np.linalg.norm(across, axis=1).sum() / 2)
    volume = abs(float(np.einsum("ij,ij->", a, across) / 6))
    faces = np.bincount(read_array(mesh.loops, "edge_index", 1, np.int32).ravel())
    if ((faces == 0) | (faces == 2)).all():
        return wall_of(size, volume, area)
    return min(size[2] or sheet, sheet)
