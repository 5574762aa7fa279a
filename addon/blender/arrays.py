"""Arrays of Blender's collections, read and written in one call each."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


def read_array(
    items: Any, attribute: str, width: int, kind: DTypeLike = np.float32
) -> NDArray[Any]:
    """An attribute of ``width`` values of all items of a collection, shape (n, width)."""
    values = np.empty(len(items) * width, dtype=kind)
    items.foreach_get(attribute, values)
    return values.reshape(-1, width)
