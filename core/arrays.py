"""Array types of all stages, and functions for runs of numbers. Docstrings give shapes, as in ``(n, 3)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def runs(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Start indices and lengths of the runs of equal ``numbers`` (n,)."""
    begins = np.ones(len(numbers), dtype=np.bool_)
    np.not_equal(numbers[1:], numbers[:-1], out=begins[1:])
    begin = begins.nonzero()[0]
    size = np.empty_like(begin)
    np.subtract(begin[1:], begin[:-1], out=size[:-1])
    size[-1:] = len(numbers) - begin[-1:]
    return begin, size


def ranges(first: IntArray, size: IntArray) -> IntArray:
    """The numbers ``first[k], first[k] + 1, ...``, ``size[k]`` of them for each k, concatenated."""
    return np.asarray(np.arange(size.sum()) + (first - size.cumsum() + size).repeat(size))
