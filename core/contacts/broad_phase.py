"""Broad phase: which bounding boxes overlap, by a sweep along one axis in NumPy."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray

_LARGE = 6.0
"""Extent relative to the median above which a box is compared with all others: among the rest it
would widen every search."""

_CHUNK = 200_000
"""Pairs compared at a time, so that what is compared stays in the cache; where there are no more,
all are compared."""

_ROWS = 64
"""Largest number of boxes per step of the sweep."""


def overlapping_pairs(low: FloatArray, high: FloatArray, active: BoolArray) -> IntArray:
    """Pairs (p,) of boxes with lowest and highest corners (3, n) that overlap or touch and of which
    at least one is ``active`` (n,): for each ``a n + b`` of the boxes a < b, ascending. A box with
    NaN overlaps nothing."""
    count = len(active)
    few = int(active.sum()) * count <= _CHUNK
    first, second = _with_all(low, high, active) if few else _swept(low, high, active)
    pairs: IntArray = np.minimum(first, second) * count + np.maximum(first, second)
    pairs.sort()
    return pairs


def _with_all(low: FloatArray, high: FloatArray, active: BoolArray) -> IntArray:
    """Pairs (2, p) of each ``active`` box with all boxes, each pair once."""
    rows = active.nonzero()[0]
    step = max(1, _CHUNK // max(len(active), 1))
    parts = [rows[k : k + step] for k in range(0, len(rows), step)]
    return _compared(low, high, active, [(part, 0, len(active)) for part in parts])


def _swept(low: FloatArray, high: FloatArray, active: BoolArray) -> IntArray:
    """The overlapping pairs (2, p) of `overlapping_pairs`, by a sweep along the axis in which the
    boxes spread most. Large boxes, which would be compared with nearly all in a sweep, are compared
    with all."""
    real = np.flatnonzero(~np.isnan(low + high).any(axis=0))
    if len(real) < len(active):
        return real[_swept(low[:, real], high[:, real], active[real])]
    axis = int((high.max(axis=1) - low.min(axis=1)).argmax())
    extent = high[axis] - low[axis]
    large = extent > _LARGE * max(float(np.median(extent)), 0.0)
    found = _with_all(low, high, large)
    found = found[:, active[found[0]] | active[found[1]]]
    others = np.flatnonzero(~large)
    if len(others) == 0:
        return found
    others = others[low[axis, others].argsort(kind="stable")]
    low = low.take(others, axis=1)
    high = high.take(others, axis=1)
    # Where all are active, those before have found them.
    begin = (
        np.arange(len(others))
        if active.all()
        else low[axis].searchsorted(low[axis] - extent[others].max())
    )
    end = low[axis].searchsorted(high[axis], side="right")
    active = active[others]
    rows = active.nonzero()[0]
    parts = [rows[k : k + _ROWS] for k in range(0, len(rows), _ROWS)]
    near = [(part, int(begin[part[0]]), int(end[part].max())) for part in parts]
    return np.concatenate([found, others[_compared(low, high, active, near)]], axis=1)


def _compared(
    low: FloatArray, high: FloatArray, active: BoolArray, parts: list[tuple[IntArray, int, int]]
) -> IntArray:
    """Overlapping pairs (2, p), each once, of boxes with lowest and highest corners (3, n).
    ``active`` (n,): boxes of which at least one is in each pair; ``parts``: some of these (k,) at a
    time, and the first of the boxes with which they are compared, and the one after the last."""
    found = [np.zeros((2, 0), dtype=np.int64)]
    for part, begin, end in parts:
        near = slice(begin, end)
        bottom = low[:, part, None]
        top = high[:, part, None]
        met = low[0, near] <= top[0]
        met &= high[0, near] >= bottom[0]
        for axis in (1, 2):
            met &= low[axis, near] <= top[axis]
            met &= high[axis, near] >= bottom[axis]
        row, other = np.divmod(met.reshape(-1).nonzero()[0], max(met.shape[1], 1))
        row = part[row]
        other = other + begin
        kept = (row < other) | ((row > other) & ~active[other])
        found.append(np.array([row[kept], other[kept]]))
    return np.concatenate(found, axis=1)
