"""Placement of labels beside their anchors, without overlaps. Coordinates are pixels, origin at the
bottom left."""

from __future__ import annotations

import numpy as np

from ...core.arrays import BoolArray, FloatArray
from .hud import Rectangle
from .render_data import Size

# Candidate centres of a label, in halves of its extent plus a distance: right, left, above, below,
# then the diagonals; near, then far.
_SIDES = np.array(
    [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)], dtype=np.float64
)
# A diagonal needs a smaller offset on either axis.
_DIAGONAL = np.where(np.abs(_SIDES).sum(axis=1, keepdims=True) > 1, 0.5, 1.0)
_DISTANCES = (1.0, 2.2, 4.0)
_CROWD = 28  # number of labels from which on they stay near: long leaders would cross each other
_CELL = 12.0  # pixels
_COST_OF_DISTANCE = 6  # cost of the next distance, in covered pixels of a path
_COST_OF_CONFUSION = 15  # cost of being nearer to another label's anchor than to its own


def project(position: FloatArray, perspective: FloatArray, size: Size) -> FloatArray:
    """Pixels (n, 2) of positions (n, 3) under ``perspective`` (4, 4), world to clip space; NaN
    behind the viewer and out of sight."""
    clip = np.column_stack([position, np.ones(len(position))]) @ perspective.T
    visible = (clip[:, 3] > 1e-9) & (np.abs(clip[:, :3]) <= clip[:, 3:]).all(axis=1)
    ndc = clip[:, :2] / np.where(visible, clip[:, 3], 1.0)[:, None]
    pixels = (ndc * 0.5 + 0.5) * size
    pixels[~visible] = np.nan
    return pixels


def squares_around(anchor: FloatArray, clearance: FloatArray) -> FloatArray:
    """Squares (n, 4: left, bottom, right, top) around places (n, 2) that extend ``clearance`` (n,)
    to each side; of visible ones only."""
    return np.column_stack([anchor - clearance[:, None], anchor + clearance[:, None]])[
        ~np.isnan(anchor[:, 0])
    ]


def place_labels(
    anchor: FloatArray,
    extent: FloatArray,
    clearance: FloatArray,
    room: Rectangle,
    occupied: FloatArray,
    paths: FloatArray,
) -> FloatArray:
    """Lower left corners (n, 2) of labels of ``extent`` (n, 2) beside ``anchor`` (n, 2), NaN
    without room.

    Labels stay within ``room`` (left, bottom, right, top), keep ``clearance`` (n,) from their
    anchor and avoid the rectangles ``occupied`` (m, 4: left, bottom, right, top). They are placed
    in their order: near their anchor, on the side that covers the fewest of the pixels ``paths``
    (k, 2), by default the right.
    """
    corner = np.full_like(anchor, np.nan)
    if not len(anchor):
        return corner
    distances = _DISTANCES if len(anchor) < _CROWD else _DISTANCES[:2]
    reach = (
        np.repeat(distances, len(_SIDES))[None, :, None]
        * np.tile(_DIAGONAL, (len(distances), 1))[None]
    )
    side = np.tile(_SIDES, (len(distances), 1))[None]
    low = (
        anchor[:, None]
        + side * (extent[:, None] / 2 + clearance[:, None, None] * reach)
        - extent[:, None] / 2
    )
    rectangles = np.concatenate([low, low + extent[:, None]], axis=2)
    edges = np.moveaxis(rectangles, 2, 0)
    cost = _covered(edges, paths, room) + _COST_OF_DISTANCE * np.repeat(
        np.arange(len(distances)), len(_SIDES)
    )
    cost += _COST_OF_CONFUSION * _nearer_to_another(edges, anchor)
    free = _free(edges, room, occupied.reshape(-1, 4))
    placed: list[Rectangle] = []
    orders = np.argsort(cost, axis=1, kind="stable").tolist()
    for k, (order, places) in enumerate(zip(orders, rectangles.tolist(), strict=True)):
        for number in order:
            if not free[k, number]:
                continue
            x0, y0, x1, y1 = places[number]
            if not any(
                x0 < right and x1 > left and y0 < top and y1 > bottom
                for left, bottom, right, top in placed
            ):
                corner[k] = x0, y0
                placed.append((x0, y0, x1, y1))
                break
    return corner


# Rectangles are given by their ``edges`` (4, n, s): n labels at s candidates.


def _free(edges: FloatArray, room: Rectangle, occupied: FloatArray) -> BoolArray:
    """Whether each rectangle lies inside ``room`` and outside ``occupied`` (m, 4)."""
    x0, y0, x1, y1 = edges
    result = (x0 >= room[0]) & (y0 >= room[1]) & (x1 <= room[2]) & (y1 <= room[3])
    left, bottom, right, top = occupied.T
    x0, y0, x1, y1 = edges[:, result][..., None]
    result[result] = ~((x0 < right) & (x1 > left) & (y0 < top) & (y1 > bottom)).any(axis=1)
    return result


def _nearer_to_another(edges: FloatArray, anchor: FloatArray) -> BoolArray:
    """Whether each rectangle is nearer to the anchor of another label than to its own."""
    (x0, y0, x1, y1), (x, y) = edges[..., None], anchor.T
    squared = np.maximum(np.maximum(x0 - x, x - x1), 0) ** 2
    squared += np.maximum(np.maximum(y0 - y, y - y1), 0) ** 2
    own = np.diagonal(squared, axis1=0, axis2=2).T
    return np.asarray(squared.min(axis=2) < own)


def _covered(edges: FloatArray, paths: FloatArray, room: Rectangle) -> FloatArray:
    """Number of pixels ``paths`` (k, 2) in each rectangle, to within a cell at its edges: a
    summed-area table of cells."""
    ends = np.maximum(np.ceil(np.array(room[2:]) / _CELL), 1).astype(np.int64)
    width, height = ends.tolist()
    place = (paths / _CELL).astype(np.int64)
    place = place[((place >= 0) & (place < ends)).all(axis=1)]
    sums = np.zeros(ends + 1, dtype=np.int32)
    cells = np.bincount(place @ (height, 1), minlength=width * height).reshape(width, height)
    np.cumsum(np.cumsum(cells, axis=0), axis=1, out=sums[1:, 1:])
    borders = np.clip(np.rint(edges / _CELL), 0, np.tile(ends, 2)[:, None, None])
    x0, y0, x1, y1 = borders.astype(np.int64)
    return np.asarray(sums[x1, y1] - sums[x0, y1] - sums[x1, y0] + sums[x0, y0], dtype=np.float64)
