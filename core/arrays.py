"""Array types that all stages share, and runs of numbers; shapes are given where an array is documented, as in ``(n, 3)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def runs(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Where the runs of equal ``numbers`` (n,) begin, and how long they are."""
    begins = np.ones(len(numbers), dtype=np.bool_)
    np.not_equal(numbers[1:], numbers[:-1], out=begins[1:])
    begin = begins.nonzero()[0]
    size = np.empty_like(begin)
    np.subtract(begin[1:], begin[:-1], out=size[:-1])
    size[-1:] = len(numbers) - begin[-1:]
    return begin, size


def ranges(first: IntArray, size: IntArray) -> IntArray:
    """The numbers ``first[k], first[k] + 1, ...``, ``size[k]`` of them for each k, one after the other."""
    return np.asarray(np.arange(size.sum()) + (first - size.cumsum() + size).repeat(size))
