"""Arrays of Blender's collections, read and written in one call each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

_LINEAR = 1


def read_array(
    items: Any, attribute: str, width: int, kind: DTypeLike = np.float32
) -> NDArray[Any]:
    """An attribute of ``width`` values of all items of a collection, shape (n, width)."""
    values = np.empty(len(items) * width, dtype=kind)
    items.foreach_get(attribute, values)
    return values.reshape(-1, width)


def write_keys(curve: Any, frames: ArrayLike, values: ArrayLike) -> None:
    """Add keys to an F-curve, with straight lines between them."""
    places = np.column_stack([frames, values]).astype(np.float32)
    curve.keyframe_points.add(len(places))
    curve.keyframe_points.foreach_set("co", places.ravel())
    curve.keyframe_points.foreach_set(
        "interpolation", np.full(len(places), _LINEAR, dtype=np.int32)
    )
    curve.update()
