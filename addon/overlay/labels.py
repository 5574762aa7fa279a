"""Where labels go: beside their places, not over each other. Pixels, origin at the bottom left. No GPU, no Blender."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .colour_map import FloatArray

# Where a label's centre may be, in halves of its extent plus a reach: right, left, above, below, then the diagonals; near, then farther.
_SIDES = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)], dtype=np.float64)
_REACH_OF_SIDE = np.where(np.abs(_SIDES).sum(axis=1, keepdims=True) > 1, 0.5, 1.0)  # a diagonal needs less on either axis
_REACHES = (1.0, 2.2, 4.0)
_COST_OF_REACH = 6  # a step farther is worth that many covered pixels of a path
_COST_OF_CONFUSION = 15  # so is standing nearer to the place of another label than to one's own


def project(position: FloatArray, perspective: FloatArray, size: tuple[float, float]) -> FloatArray:
    """Pixels (n, 2) of positions (n, 3) under ``perspective`` (4, 4), world to clip space; NaN behind the viewer and out of sight."""
    clip = np.column_stack([position, np.ones(len(position))]) @ perspective.T
    visible = (clip[:, 3] > 1e-9) & (np.abs(clip[:, :3]) <= clip[:, 3:]).all(axis=1)
    ndc = clip[:, :2] / np.where(visible, clip[:, 3], 1.0)[:, None]
    pixels = (ndc * 0.5 + 0.5) * size
    pixels[~visible] = np.nan
    return pixels


def around(anchor: FloatArray, clearance: FloatArray) -> FloatArray:
    """Squares (n, 4: left, bottom, right, top) around places (n, 2) that reach ``clearance`` (n,) to each side; of the seen ones only."""
    return np.column_stack([anchor - clearance[:, None], anchor + clearance[:, None]])[~np.isnan(anchor[:, 0])]


def place_labels(
    anchor: FloatArray,
    extent: FloatArray,
    clearance: FloatArray,
    room: tuple[float, float, float, float],
    taken: FloatArray,
    busy: FloatArray,
) -> FloatArray:
    """Lower left corners (n, 2) of labels of ``extent`` (n, 2) beside ``anchor`` (n, 2), NaN where there is no room.

    Labels stay within ``room`` (left, bottom, right, top), keep ``clearance`` (n,) from their place and stay off the rectangles ``taken``
    (m, 4: left, bottom, right, top). The first choose first: near their place, on the side that covers the fewest of the pixels ``busy``
    (k, 2), else the right.
    """
    corner = np.full_like(anchor, np.nan)
    rectangles = np.concatenate([taken.reshape(-1, 4), np.zeros_like(anchor).repeat(2, axis=1)])  # room for those placed here
    count = len(taken)
    for k in range(len(anchor)):
        best, lowest = None, np.inf
        for step, factor in enumerate(_REACHES):
            if lowest <= step * _COST_OF_REACH:
                break
            low = anchor[k] + _SIDES * (extent[k] / 2 + factor * clearance[k] * _REACH_OF_SIDE) - extent[k] / 2
            high = low + extent[k]
            free = np.flatnonzero(_free(low, high, room, rectangles[:count]))
            if len(free):
                cost = _covered(low[free], high[free], busy) + step * _COST_OF_REACH
                cost = cost + _COST_OF_CONFUSION * _nearer_to_another(low[free], high[free], anchor, k)
                if cost.min() < lowest:
                    best, lowest = low[free[np.argmin(cost)]], cost.min()
        if best is not None:
            corner[k] = best
            rectangles[count] = *best, *(best + extent[k])
            count += 1
    return corner


# The last axis is only two long: comparing its parts by themselves is several times faster than `all` over it.


def _free(low: FloatArray, high: FloatArray, room: tuple[float, float, float, float], rectangles: FloatArray) -> NDArray[np.bool_]:
    """Which rectangles ``low`` to ``high`` (s, 2) lie inside ``room`` and off ``rectangles`` (m, 4)."""
    (x0, y0), (x1, y1) = low.T, high.T
    left, bottom, right, top = rectangles.T
    overlaps = (x0[:, None] < right) & (x1[:, None] > left) & (y0[:, None] < top) & (y1[:, None] > bottom)
    return (x0 >= room[0]) & (y0 >= room[1]) & (x1 <= room[2]) & (y1 <= room[3]) & ~overlaps.any(axis=1)


def _nearer_to_another(low: FloatArray, high: FloatArray, anchor: FloatArray, own: int) -> NDArray[np.bool_]:
    """Which rectangles (s,) are nearer to another place than to their own."""
    (x0, y0), (x1, y1), (x, y) = low.T[:, :, None], high.T[:, :, None], anchor.T
    squared = np.maximum(np.maximum(x0 - x, x - x1), 0) ** 2 + np.maximum(np.maximum(y0 - y, y - y1), 0) ** 2
    return squared.min(axis=1) < squared[:, own]


def _covered(low: FloatArray, high: FloatArray, busy: FloatArray) -> NDArray[np.int64]:
    """How many of the pixels ``busy`` (k, 2) lie in each rectangle (s,)."""
    (x0, y0), (x1, y1), (x, y) = low.T[:, :, None], high.T[:, :, None], busy.T
    near = (x > x0.min()) & (x < x1.max()) & (y > y0.min()) & (y < y1.max())
    x, y = x[near], y[near]
    return ((x > x0) & (x < x1) & (y > y0) & (y < y1)).sum(axis=1)
