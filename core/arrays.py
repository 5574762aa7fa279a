"""Array types that all stages share, and runs of numbers; shapes are given where an array is documented, as in ``(n, 3)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def runs(numbers: IntArray) -> tuple[IntArray, IntArray]:
    """Where the runs of equal ``numbers`` (n,) begin, and how long they are."""
    begin = np.flatnonzero(np.concatenate([numbers[:1] == numbers[:1], numbers[1:] != numbers[:-1]]))
    return begin, np.append(begin[1:], len(numbers)) - begin


def ranges(first: IntArray, size: IntArray) -> IntArray:
    """The numbers ``first[k], first[k] + 1, ...``, ``size[k]`` of them for each k, one after the other."""
    return np.asarray(np.arange(size.sum()) + (first - size.cumsum() + size).repeat(size))
