"""Vectors, rotations and poses, many at a time."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products of the vectors along the last axis."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def turned(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """``rotation @ vector`` of rotations (..., 3, 3) and vectors (..., 3)."""
    return np.asarray(np.einsum("...ij,...j->...i", rotation, vector))


def turned_back(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """``rotation.T @ vector`` of rotations (..., 3, 3) and vectors (..., 3)."""
    return np.asarray(np.einsum("...ji,...j->...i", rotation, vector))


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products (3, 3, p) of matrices (3, 3, p)."""
    return np.asarray(np.einsum("ijp,jkp->ikp", a, b))


def relative_pose(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3, p) and offset (3, p) of poses ``b`` in the frames of poses ``a``, both (12, p): rotation by rows, then position."""
    turn_a, turn_b = a[:9].reshape(3, 3, -1), b[:9].reshape(3, 3, -1)
    return np.einsum("kip,kjp->ijp", turn_a, turn_b), np.einsum("ijp,ip->jp", turn_a, b[9:] - a[9:])


def identity_and_relative(rotation: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrices (p, 4, 4) of the identity and of relative poses."""
    count = offset.shape[1]
    matrices = np.zeros((count, 4, 4))
    matrices[:, :3, :3] = rotation.transpose(2, 0, 1)
    matrices[:, :3, 3] = offset.T
    matrices[:, 3, 3] = 1.0
    return np.broadcast_to(np.eye(4), (count, 4, 4)), matrices
