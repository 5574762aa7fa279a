"""Sizes of bodies that waves spread in: those of the bounding box, and the wall of a hollow
body."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np
from bpy.types import Mesh, Object

from ...core.arrays import FloatArray
from ...core.contacts.body_sizes import Size, walled
from ..blender.arrays import read_array
from ..blender.units import metres_per_unit


class Sizes:
    """The sizes that ``objects`` have now; those of bodies that share a mesh are found once.

    The scene is evaluated where one of them needs it: that takes long if a script tags one object
    after the other, and traces the scene if a property has changed since.
    """

    def __init__(self, objects: Iterable[Object]) -> None:
        self._depsgraph = None
        if not all(map(_is_as_modelled, objects)):
            self._depsgraph = bpy.context.evaluated_depsgraph_get()
        self._metres = metres_per_unit(bpy.context.scene)
        self._known: dict[tuple[float, ...], Size] = {}

    def of(self, obj: Object) -> Size:
        """The size of a body, see `walled`."""
        evaluated = obj if self._depsgraph is None else obj.evaluated_get(self._depsgraph)
        scale = _scale(obj) * self._metres
        mesh = evaluated.data
        if not isinstance(mesh, Mesh) or len(mesh.polygons) == 0:
            x, y, z = (np.ptp(evaluated.bound_box, axis=0) * scale).tolist()
            return Size.of_box((x, y, z))
        key = mesh.as_pointer(), *scale.tolist()
        if key not in self._known:
            self._known[key] = _size_of_mesh(mesh, scale)
        return self._known[key]


def _is_as_modelled(obj: Object) -> bool:
    """Whether an object has the size of its own mesh, which no evaluation changes."""
    mesh = obj.data
    return (
        isinstance(mesh, Mesh)
        and not (mesh.is_editmode or mesh.shape_keys or obj.modifiers or obj.parent)
        and len(mesh.polygons) > 0
    )


def _scale(obj: Object) -> FloatArray:
    """The scale (3,) of an object by its properties and its parent's matrix: a script may have set
    them since the last evaluation, in which its dimensions are older."""
    basis = obj.matrix_basis
    if obj.parent is not None:
        basis = obj.parent.matrix_world @ obj.matrix_parent_inverse @ basis
    return np.abs(basis.to_scale())


def _size_of_mesh(mesh: Mesh, scale: FloatArray) -> Size:
    corners = read_array(mesh.vertices, "co", 3).astype(np.float64) * scale
    mesh.calc_loop_triangles()
    triangles = read_array(mesh.loop_triangles, "vertices", 3, np.int32).astype(np.int64)
    x, y, z = np.ptp(corners, axis=0).tolist()
    return walled((x, y, z), corners, triangles)
