"""World transforms of all objects of the file, read in one call."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import TypeVar

import bpy
import numpy as np
from bpy.types import Depsgraph, Object
from numpy.typing import NDArray

from ...core.arrays import FloatArray
from ..blender.arrays import read_array
from .present import evaluated_in, is_shown

_Float = TypeVar("_Float", np.float32, np.float64)

_SHEARED = 1e-4
"""Cosine of the angle between two axes of an object beyond which it counts as sheared."""


def session_ids() -> NDArray[np.int32]:
    """(n,) session ids of all objects of the file."""
    return read_array(bpy.data.objects, "session_uid", 1, np.int32)[:, 0]


def world_matrices(count: int, depsgraph: Depsgraph) -> NDArray[np.float32]:
    """(n, 16) world matrices of all objects of the file, column by column, as a depsgraph has
    evaluated them; ``count``: n, which Blender would count again."""
    if not is_shown(depsgraph.scene):
        return matrices_of(bpy.data.objects, depsgraph)
    values = np.empty(16 * count, dtype=np.float32)
    bpy.data.objects.foreach_get("matrix_world", values)
    return values.reshape(count, 16)


def matrices_of(objects: Iterable[Object], depsgraph: Depsgraph) -> NDArray[np.float32]:
    """(n, 16) world matrices of some objects, column by column, as a depsgraph has evaluated
    them."""
    matrices = [obj.matrix_world.transposed() for obj in evaluated_in(objects, depsgraph)]
    return np.array(matrices, dtype=np.float32).reshape(-1, 16)


def in_metres(matrices: NDArray[_Float], metres: float) -> NDArray[_Float]:
    """Raw matrices (n, 16) to units of ``metres`` as matrices to metres."""
    if metres == 1.0:
        return matrices
    return (matrices * np.tile((metres, metres, metres, 1.0), 4)).astype(matrices.dtype)


def rigid_transforms(raw: NDArray[np.float32] | FloatArray) -> tuple[FloatArray, FloatArray]:
    """Split raw matrices (n, 16) into rigid transforms (n, 4, 4) and stretches (n, 6): the scales
    along x, y and z, negative where mirrored, and the shears of y along x, of z along x and of z
    along y. Objects are sheared by a parent whose scale differs from axis to axis. Of a
    matrix that is not finite, the transform is 0 and the stretch is not a number.
    """
    return _split_one(raw.astype(np.float32).tobytes()) if len(raw) == 1 else _split(raw)


@lru_cache(maxsize=16)
def _split_one(raw: bytes) -> tuple[FloatArray, FloatArray]:
    """`rigid_transforms` of one matrix, read-only: several things are read of an object that
    moves."""
    found = _split(np.frombuffer(raw, dtype=np.float32).reshape(1, 16))
    for values in found:
        values.setflags(write=False)
    return found


def _split(raw: NDArray[np.float32] | FloatArray) -> tuple[FloatArray, FloatArray]:
    """`rigid_transforms`."""
    columns = raw.T.astype(np.float64, order="C").reshape(4, 4, -1)
    lost = ~np.isfinite(columns).all(axis=(0, 1))
    columns[:, :, lost] = 0.0
    axes = columns[:3, :3]
    scales = np.sqrt((axes * axes).sum(axis=1))
    x, y, z = axes
    volume = (
        (y[1] * z[2] - y[2] * z[1]) * x[0]
        + (y[2] * z[0] - y[0] * z[2]) * x[1]
        + (y[0] * z[1] - y[1] * z[0]) * x[2]
    )
    scales[:, volume < 0] *= -1
    axes /= np.where(scales == 0, 1.0, scales)[:, None]
    stretches = np.concatenate([scales, np.zeros_like(scales)])
    x, y, z = axes
    shears = np.abs([(x * y).sum(axis=0), (x * z).sum(axis=0), (y * z).sum(axis=0)])
    for k in np.flatnonzero(shears.max(axis=0) > _SHEARED).tolist():
        axes[:, :, k], stretches[:, k] = _unsheared(axes[:, :, k] * scales[:, k, None])
    stretches[:, lost] = np.nan
    return columns.transpose(2, 1, 0).copy(), stretches.T


def _unsheared(axes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The axes (3, 3) of the rotation, in rows, and the stretch (6,) that together are the ``axes``
    of a sheared object."""
    x, y, z = axes
    side = np.sign((np.cross(x, y) * z).sum())
    first = side * x / _length(x)
    across = y - (y * first).sum() * first
    second = side * across / _length(across)
    third = np.cross(first, second)
    scales = side * _length(x), side * _length(across), (z * third).sum()
    shears = (y * first).sum(), (z * first).sum(), (z * second).sum()
    return np.array([first, second, third]), np.array([*scales, *shears])


def _length(vector: FloatArray) -> float:
    return max(float(np.sqrt((vector * vector).sum())), 1e-300)


def lengths_of_axes(stretch: FloatArray) -> FloatArray:
    """The scales (3,) that Blender shows of an object with this ``stretch`` (6,)."""
    x, y, z, y_along_x, z_along_x, z_along_y = stretch
    return np.hypot([x, y, z], [0.0, y_along_x, np.hypot(z_along_x, z_along_y)])


def apply_stretch(points: FloatArray, stretch: FloatArray) -> FloatArray:
    """Points (n, 3) of an object's mesh, scaled and sheared as in the world by ``stretch`` (6,)."""
    result = points * stretch[:3]
    if stretch[3:].any():
        result[:, 0] += points[:, 1] * stretch[3] + points[:, 2] * stretch[4]
        result[:, 1] += points[:, 2] * stretch[5]
    return result
