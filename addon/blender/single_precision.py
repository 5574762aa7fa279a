"""Decimal values of Blender's properties, which are stored in single precision."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np


@lru_cache(4096)
def shortest(value: float) -> float:
    """The shortest decimal that is the same number in single precision: 0.1, not
    0.10000000149011612."""
    return float(str(np.float32(value)))


def authored(value: Any) -> Any:
    """A property's value with its floats, or those of its array, as the author wrote them."""
    if isinstance(value, float):
        return shortest(value)
    return value if isinstance(value, int | str) else tuple(map(shortest, value))
