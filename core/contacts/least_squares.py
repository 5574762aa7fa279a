"""Bounded least squares for few equations and any number of unknowns."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

_ROUNDS = 200
"""Most Newton steps; such problems usually need a few tens at most."""
_EXACT = 1e-12
"""Relative error of the equations at which the solution counts as found."""
_HALVINGS = 40
_ROUNDING = 4 * np.finfo(np.float64).eps


def bounded_least_squares(
    matrix: FloatArray,
    target: FloatArray,
    low: FloatArray,
    high: FloatArray,
    softness: float = 1e-9,
) -> FloatArray:
    """The ``x`` (n,) in [low, high] that minimises ``|x|^2 + |matrix x - target|^2 / softness``.

    This is approximately the smallest solution of the equations, or, if there is none, the nearest
    point to one. Newton's method on the dual problem of m unknowns, which is concave and piecewise
    quadratic.

    Args:
        matrix: (m, n).
        target: (m,).
        low: least values (n,), which may be -infinity.
        high: largest values (n,), which may be infinity.
        softness: the greater, the less the error counts beside the size of x.
    """
    dual = np.zeros(len(target))
    size = float(np.abs(target).max(initial=0.0)) or 1.0
    # Of the equations, where the dual is 1: below it no step leads further.
    rounding = _ROUNDING * (np.abs(matrix) @ np.abs(matrix.T))

    def gradient(dual: FloatArray) -> FloatArray:
        return target - matrix @ np.clip(dual @ matrix, low, high) - softness * dual

    for _ in range(_ROUNDS):
        rest = gradient(dual)
        if np.all(np.abs(rest) <= np.maximum(_EXACT * size, rounding @ np.abs(dual))):
            break
        pull = dual @ matrix
        inner = matrix[:, (pull >= low) & (pull <= high)]
        step = np.linalg.solve(inner @ inner.T + softness * np.eye(len(target)), rest)
        # Otherwise the highest value along the step lies before its end.
        whole = bool(step @ gradient(dual + step) >= 0)
        length = float(whole)
        reach = 1.0
        for _ in range(0 if whole else _HALVINGS):
            middle = (length + reach) / 2
            length, reach = (
                (middle, reach) if step @ gradient(dual + middle * step) >= 0 else (length, middle)
            )
        dual = dual + length * step
    return np.clip(dual @ matrix, low, high)
