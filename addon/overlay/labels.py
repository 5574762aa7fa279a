"""Where labels go: beside their places, not over each other. Pixels, origin at the bottom left. No GPU, no Blender."""

from __future__ import annotations

import numpy as np

from .colour_map import FloatArray

GAP = 5.0
"""Pixels between a place's symbol and its label."""

# Where a label's centre may be, in halves of its extent plus clearance: right, left, above, below, then the diagonals.
_SIDES = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)], dtype=np.float64)


def project(position: FloatArray, perspective: FloatArray, size: tuple[float, float]) -> FloatArray:
    """Pixels (n, 2) of positions (n, 3) under ``perspective`` (4, 4), world to clip space; NaN behind the viewer and out of sight."""
    clip = np.column_stack([position, np.ones(len(position))]) @ perspective.T
    visible = (clip[:, 3] > 1e-9) & (np.abs(clip[:, :3]) <= clip[:, 3:]).all(axis=1)
    ndc = clip[:, :2] / np.where(visible, clip[:, 3], 1.0)[:, None]
    pixels = (ndc * 0.5 + 0.5) * size
    pixels[~visible] = np.nan
    return pixels


def place_labels(
    anchor: FloatArray, extent: FloatArray, clearance: FloatArray, priority: FloatArray, size: tuple[float, float], taken: FloatArray
) -> FloatArray:
    """Lower left corners (n, 2) of labels of ``extent`` (n, 2) beside ``anchor`` (n, 2; NaN: not seen), NaN where there is no room.

    ``clearance`` (n,) around each anchor and the rectangles ``taken`` (m, 4: left, bottom, right, top) are kept free. Labels of higher
    ``priority`` (n,) choose first, and prefer the right of their place.
    """
    corner = np.full_like(anchor, np.nan)
    seen = np.flatnonzero(~np.isnan(anchor[:, 0]))
    symbols = np.column_stack([anchor - clearance[:, None], anchor + clearance[:, None]])[seen]
    rectangles = np.concatenate([taken.reshape(-1, 4), symbols])
    for k in seen[np.argsort(-priority[seen], kind="stable")].tolist():
        reach = clearance[k] + GAP
        # A diagonal needs less of the clearance on either axis.
        offset = _SIDES * (extent[k] / 2 + reach * np.where(np.abs(_SIDES).sum(axis=1) > 1, 0.5, 1.0)[:, None])
        low = anchor[k] + offset - extent[k] / 2
        high = low + extent[k]
        inside = ((low >= 0) & (high <= size)).all(axis=1)
        overlaps = (
            (low[:, None, 0] < rectangles[None, :, 2])
            & (high[:, None, 0] > rectangles[None, :, 0])
            & (low[:, None, 1] < rectangles[None, :, 3])
            & (high[:, None, 1] > rectangles[None, :, 1])
        ).any(axis=1)
        free = np.flatnonzero(inside & ~overlaps)
        if len(free):
            corner[k] = low[free[0]]
            rectangles = np.concatenate([rectangles, [[*low[free[0]], *high[free[0]]]]])
    return corner
