"""Vectors, rotations and poses of many pairs at a time, the pairs along the last axis of every
array.

Sums are in a fixed order, so that results do not depend on which pairs are computed together, as
those of `einsum` and `matmul` do.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray

COLUMN = np.arange(3)[:, None]
"""Numbers of the coordinates as a column, to be compared with an axis (n,) per pair."""


SIDES = np.concatenate([np.eye(3), -np.eye(3)])
"""The normals (6, 3) of the faces of a box."""

_MANY = 64
"""Number of pairs from which on terms are added in a loop: in `cumsum`, such rows take longer."""


def chunks(count: int, size: int = 4096) -> list[IntArray]:
    """The numbers of ``count`` pairs in parts, at least one, each of a ``size`` so small that what
    is computed of it stays in the processor's cache."""
    return [np.arange(at, min(at + size, count)) for at in range(0, max(count, 1), size)]


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Dot products (..., n) of vectors (2, ..., n) or (3, ..., n)."""
    terms = a * b
    return np.asarray(terms[0] + terms[1] if len(terms) == 2 else terms[0] + terms[1] + terms[2])


def added(terms: FloatArray) -> FloatArray:
    """Sums (..., n) of terms (..., k, n), one after the other."""
    if terms.shape[-1] < _MANY:
        return terms.cumsum(axis=-2)[..., -1, :]
    total = terms[..., 0, :].copy()
    for k in range(1, terms.shape[-2]):
        total += terms[..., k, :]
    return np.asarray(total)


def following(values: FloatArray) -> FloatArray:
    """Of each corner of polygons (c, k, n) the values (c, k, n) of the next one."""
    return np.concatenate([values[:, 1:], values[:, :1]], axis=1)


def upwards(count: int) -> FloatArray:
    """The unit vector along z (3, n), ``count`` times."""
    result = np.zeros((3, count))
    result[2] = 1.0
    return result


def turned(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """``rotation @ vector`` of rotations (3, 3, n) and vectors (3, n) or (3, k, n)."""
    if vector.ndim == 2:
        terms = rotation * vector
        return terms[:, 0] + terms[:, 1] + terms[:, 2]
    result = rotation[:, 0, None] * vector[0]
    result += rotation[:, 1, None] * vector[1]
    result += rotation[:, 2, None] * vector[2]
    return np.asarray(result)


def turned_back(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """``rotation.T @ vector`` of rotations (3, 3, n) and vectors (3, n) or (3, k, n)."""
    return turned(rotation.transpose(1, 0, 2), vector)


product = turned
"""Products of matrices (3, 3, n)."""

relative = turned_back
"""Rotations (3, 3, n) of the second in the frames of the first."""


def relative_pose(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3, n) and offset (3, n) of poses ``b`` in the frames of poses ``a``, both (12,
    n): rotation by rows, then position."""
    turn = a[:9].reshape(3, 3, -1)
    return relative(turn, b[:9].reshape(3, 3, -1)), turned_back(turn, b[9:] - a[9:])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of vectors (3, ..., n)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def pick(values: FloatArray, index: IntArray) -> FloatArray:
    """``values[index[..., p], p]`` of arrays (k, n)."""
    count = values.shape[1]
    return np.asarray(values.reshape(-1).take(index * count + np.arange(count)))


def smooth_step(x: FloatArray | float) -> FloatArray:
    """0 up to 0, 1 from 1 on, and a cubic with continuous slope in between."""
    inside = np.minimum(np.maximum(x, 0.0), 1.0)
    return inside * inside * (3.0 - 2.0 * inside)
