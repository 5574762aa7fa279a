"""Sizes of bodies that waves spread in: those of the bounding box, and the wall of a hollow
body."""

from __future__ import annotations

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.scene.measured import SHEET, wall_of
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit


def sizes_of(obj: Object, depsgraph: Depsgraph) -> tuple[float, float, float]:
    """The three sizes [m] of a body, the greatest first. The least is that of its wall: by volume
    and area of a closed mesh; a mesh with open edges is a sheet of at most 1 cm."""
    metres = metres_per_unit(depsgraph.scene)
    sheet = SHEET / metres
    large, middle, small = sorted(obj.dimensions, reverse=True)
    mesh = obj.evaluated_get(depsgraph).data
    if isinstance(mesh, Mesh) and len(mesh.polygons):
        corners = read_array(mesh.vertices, "co", 3).astype(np.float64) * np.abs(obj.scale)
        mesh.calc_loop_triangles()
        a, b, c = corners[read_array(mesh.loop_triangles, "vertices", 3, np.int32)].transpose(
            1, 0, 2
        )
        across = np.cross(b - a, c - a)
        area = float(np.linalg.norm(across, axis=1).sum() / 2)
        volume = abs(float(np.einsum("ij,ij->", a, across) / 6))
        faces = np.bincount(read_array(mesh.loops, "edge_index", 1, np.int32).ravel())
        is_closed = bool(((faces == 0) | (faces == 2)).all())
        small = (
            wall_of((large, middle, small), volume, area)
            if is_closed
            else min(small or sheet, sheet)
        )
    return large * metres, middle * metres, small * metres
