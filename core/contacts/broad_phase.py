"""Broad phase: which bounding boxes overlap, by a uniform grid in NumPy."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray

_LARGE = 4.0
"""Size in cells above which a box is compared with all others instead of being entered in the grid."""

_CHUNK = 1_000_000
"""Pairs compared at a time, to bound memory."""


def overlapping_pairs(bounds: FloatArray, moved: BoolArray | None = None) -> IntArray:
    """Pairs (p, 2) of boxes (n, 2, 3) that overlap or touch, each once, smaller index first, sorted.

    With ``moved`` (n,) only pairs in which at least one box has moved. A box with NaN overlaps nothing.
    """
    count = len(bounds)
    real = ~np.isnan(bounds).any(axis=(1, 2))
    if not real.all():
        number = np.flatnonzero(real)
        return number[overlapping_pairs(bounds[real], None if moved is None else moved[real])]
    if moved is not None:
        active = np.flatnonzero(moved)
        if len(active) * count <= _CHUNK:
            return _sorted(_with_all(bounds, active, moved), count)
    pairs = _by_grid(bounds)
    if moved is not None:
        pairs = pairs[moved[pairs[:, 0]] | moved[pairs[:, 1]]]
    return _sorted(pairs, count)


def _sorted(pairs: IntArray, count: int) -> IntArray:
    """Pairs sorted, the smaller number first."""
    first, second = pairs.T
    keys = np.sort(np.minimum(first, second) * count + np.maximum(first, second))
    return np.stack([keys // max(count, 1), keys % max(count, 1)], axis=1)


def _overlapping(bounds: FloatArray, a: IntArray, b: IntArray) -> IntArray:
    """Numbers of the pairs (a, b) that overlap, tested axis by axis among the remaining pairs."""
    left = np.arange(len(a))
    for axis in range(3):
        low, high = np.ascontiguousarray(bounds[:, 0, axis]), np.ascontiguousarray(bounds[:, 1, axis])
        met = (low[a] <= high[b]) & (low[b] <= high[a])
        a, b, left = a[met], b[met], left[met]
    return left


def _with_all(bounds: FloatArray, active: IntArray, is_active: BoolArray) -> IntArray:
    """Pairs of each active box with all boxes, each pair once."""
    found = []
    low, high = np.ascontiguousarray(bounds.transpose(1, 2, 0))  # (3, n): compared along the boxes
    step = max(1, _CHUNK // max(len(bounds), 1))
    for begin in range(0, len(active), step):
        rows = active[begin : begin + step]
        met = np.ones((len(rows), len(bounds)), dtype=np.bool_)
        for axis in range(3):
            met &= low[axis] <= high[axis, rows, None]
            met &= high[axis] >= low[axis, rows, None]
        place = met.reshape(-1).nonzero()[0]
        row, other = rows[place // len(bounds)], place % len(bounds)
        kept = (row < other) | ((row > other) & ~is_active[other])
        found.append(np.stack([row[kept], other[kept]], axis=1))
    return np.concatenate(found) if found else np.zeros((0, 2), dtype=np.int64)


def _by_grid(bounds: FloatArray) -> IntArray:
    """Pairs, each once, in any order."""
    count = len(bounds)
    if count < 2:
        return np.zeros((0, 2), dtype=np.int64)
    extent = (bounds[:, 1] - bounds[:, 0]).max(axis=1)
    cell = max(float(np.median(extent)) * 1.5, 1e-9)
    large = extent > _LARGE * cell
    small = np.flatnonzero(~large)
    pairs = [_with_all(bounds, np.flatnonzero(large), large)]
    if len(small) > 1:
        origin = bounds[small, 0].min(axis=0)
        # Few enough cells a side that a cell's number fits into 64 bits.
        cell = max(cell, float(np.max(bounds[small, 1].max(axis=0) - origin)) / 1_000_000)
        first = ((bounds[small, 0] - origin) / cell).astype(np.int64)
        last = ((bounds[small, 1] - origin) / cell).astype(np.int64)
        pairs.append(small[_within_cells(bounds[small], first, last)])
    return np.concatenate(pairs)


def _within_cells(bounds: FloatArray, first: IntArray, last: IntArray) -> IntArray:
    """Pairs of boxes that cover cells ``first`` (n, 3) to ``last`` (n, 3). A pair counts in one cell alone: the first that both cover."""
    span = last - first + 1
    many = span[:, 0] * span[:, 1] * span[:, 2]
    box = np.repeat(np.arange(len(first)), many)
    within = np.arange(len(box)) - np.repeat(np.cumsum(many) - many, many)
    step = np.stack([within % span[box, 0], within // span[box, 0] % span[box, 1], within // (span[box, 0] * span[box, 1])], axis=1)
    cell = first[box] + step
    size = last.max(axis=0) + 1
    key = (cell[:, 2] * size[1] + cell[:, 1]) * size[0] + cell[:, 0]
    order = np.argsort(key, kind="stable")
    key, box, cell = key[order], box[order], cell[order]
    ends = np.searchsorted(key, key, side="right")
    following = ends - np.arange(len(key)) - 1
    one = np.repeat(np.arange(len(key)), following)
    other = np.arange(len(one)) - np.repeat(np.cumsum(following) - following, following) + one + 1
    a, b = box[one], box[other]
    met = _overlapping(bounds, a, b)
    one, a, b = one[met], a[met], b[met]
    alone = (np.maximum(first[a], first[b]) == cell[one]).all(axis=1)
    return np.stack([a[alone], b[alone]], axis=1)
