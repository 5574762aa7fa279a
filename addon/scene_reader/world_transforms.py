"""World transforms of all objects of the file, read in one call."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ...core.arrays import FloatArray
from ..blender.arrays import read_array


def session_ids() -> NDArray[np.int32]:
    """(n,) session ids of all objects of the file."""
    return read_array(bpy.data.objects, "session_uid", 1, np.int32)[:, 0]


def raw_matrices(count: int) -> NDArray[np.float32]:
    """(n, 16) world matrices of all objects of the file, column by column; ``count``: n, which
    Blender would count again."""
    values = np.empty(16 * count, dtype=np.float32)
    bpy.data.objects.foreach_get("matrix_world", values)
    return values.reshape(count, 16)


def in_metres(matrices: NDArray[np.float32], metres: float) -> NDArray[np.float32]:
    """Raw matrices (n, 16) to units of ``metres`` as matrices to metres."""
    if metres == 1.0:
        return matrices
    return (matrices * np.tile((metres, metres, metres, 1.0), 4)).astype(np.float32)


def rigid_transforms(raw: NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
    """Split raw matrices (n, 16) into rigid transforms (n, 4, 4) and scales (n, 3), negative where
    mirrored.

    A shear is dropped, as Bullet does.
    """
    columns = raw.T.astype(np.float64, order="C").reshape(4, 4, -1)
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
    return columns.transpose(2, 1, 0).copy(), scales.T
