"""Sizes of bodies that waves spread in: those of the bounding box, and the wall of a hollow
body."""

from __future__ import annotations

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.contacts.body_sizes import Size, walled
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit


class Sizes:
    """The sizes of bodies in an evaluation; those of bodies that share a mesh are found once."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._metres = metres_per_unit(depsgraph.scene)
        self._known: dict[tuple[float, ...], Size] = {}

    def of(self, obj: Object) -> Size:
        """The size of a body, see `walled`."""
        mesh = obj.evaluated_get(self._depsgraph).data
        if not isinstance(mesh, Mesh) or len(mesh.polygons) == 0:
            return self._in_metres(obj, None)
        key = mesh.as_pointer(), *obj.scale, *obj.dimensions
        if key not in self._known:
            self._known[key] = self._in_metres(obj, mesh)
        return self._known[key]

    def _in_metres(self, obj: Object, mesh: Mesh | None) -> Size:
        x, y, z = (length * self._metres for length in obj.dimensions)
        if mesh is None:
            return Size.of_box((x, y, z))
        corners = read_array(mesh.vertices, "co", 3).astype(np.float64)
        mesh.calc_loop_triangles()
        triangles = read_array(mesh.loop_triangles, "vertices", 3, np.int32).astype(np.int64)
        return walled((x, y, z), corners * np.abs(obj.scale) * self._metres, triangles)
