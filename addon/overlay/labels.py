"""Where labels go: beside their places, not over each other. Pixels, origin at the bottom left. No GPU, no Blender."""

from __future__ import annotations

import numpy as np

from .colour_map import FloatArray

GAP = 5.0
"""Pixels between a place's symbol and its label."""

# Where a label's centre may be, in halves of its extent plus a reach: right, left, above, below, then the diagonals; near, then farther.
_SIDES = np.array([(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)], dtype=np.float64)
_REACHES = (1.0, 2.2, 4.0)
_COST_OF_REACH = 6  # a step farther is worth that many covered pixels of a path


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
    priority: FloatArray,
    size: tuple[float, float],
    taken: FloatArray,
    busy: FloatArray,
) -> FloatArray:
    """Lower left corners (n, 2) of labels of ``extent`` (n, 2) beside ``anchor`` (n, 2; NaN: not seen), NaN where there is no room.

    Labels keep ``clearance`` (n,) from their place and off the rectangles ``taken`` (m, 4: left, bottom, right, top). Those of higher
    ``priority`` (n,) choose first: near their place, on the side that covers the fewest of the pixels ``busy`` (k, 2), else the right.
    """
    corner = np.full_like(anchor, np.nan)
    seen = np.flatnonzero(~np.isnan(anchor[:, 0]))
    rectangles = taken.reshape(-1, 4)
    penalty = np.repeat(_COST_OF_REACH * np.arange(len(_REACHES)), len(_SIDES))
    # A diagonal needs less of the reach on either axis.
    reach = np.where(np.abs(_SIDES).sum(axis=1) > 1, 0.5, 1.0)
    sides = np.tile(_SIDES, (len(_REACHES), 1))
    for k in seen[np.argsort(-priority[seen], kind="stable")].tolist():
        reaches = np.outer(np.array(_REACHES) * (clearance[k] + GAP), reach).reshape(-1, 1)
        low = anchor[k] + sides * (extent[k] / 2 + reaches) - extent[k] / 2
        high = low + extent[k]
        inside = ((low >= 0) & (high <= size)).all(axis=1)
        overlaps = (
            (low[:, None, 0] < rectangles[None, :, 2])
            & (high[:, None, 0] > rectangles[None, :, 0])
            & (low[:, None, 1] < rectangles[None, :, 3])
            & (high[:, None, 1] > rectangles[None, :, 1])
        ).any(axis=1)
        near = busy[((busy > low.min(axis=0)) & (busy < high.max(axis=0))).all(axis=1)]
        covered = ((near[None, :, :] > low[:, None, :]) & (near[None, :, :] < high[:, None, :])).all(axis=2).sum(axis=1)
        free = np.flatnonzero(inside & ~overlaps)
        if len(free):
            best = free[np.argmin((covered + penalty)[free])]
            corner[k] = low[best]
            rectangles = np.concatenate([rectangles, [[*low[best], *high[best]]]])
    return corner
