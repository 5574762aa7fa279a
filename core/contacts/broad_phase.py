"""Broad phase: which bounding boxes overlap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def overlapping_pairs(bounds: FloatArray, moving: BoolArray | None = None) -> IntArray:
    """Pairs (p, 2) of boxes (n, 2, 3) that overlap or touch, each once, smaller index first, sorted.

    Pairs of which neither is ``moving`` (n,) are left out.
    """
    count = len(bounds)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int64)
    low, high = bounds[:, 0], bounds[:, 1]
    axis = int(np.argmax(np.var(low + high, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    # In the order of their lower ends, a box overlaps along the axis with those after it that begin before it ends.
    ends = np.searchsorted(low[order, axis], high[order, axis], side="right")
    lengths = ends - np.arange(count) - 1
    first = np.repeat(np.arange(count), lengths)
    second = np.arange(len(first)) - np.repeat(np.cumsum(lengths) - lengths, lengths) + first + 1
    a, b = order[first], order[second]
    kept = np.ones(len(a), dtype=np.bool_) if moving is None else moving[a] | moving[b]
    for other in range(3):
        if other != axis:
            kept &= (low[a, other] <= high[b, other]) & (low[b, other] <= high[a, other])
    pairs = np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1)[kept]
    ordered: IntArray = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return ordered
