"""Limits of the parameters of signals, which keep every sample finite, and their checks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from numbers import Integral, Real
from typing import Any, cast

import numpy as np

from ..arrays import FloatArray

MAX_PEAK = 1e6
"""Largest amplitude that a signal may reach."""
MAX_FREQUENCY = 20_000.0
"""Largest frequency [Hz]."""
MAX_SECONDS = 1e6
"""Longest time in a signal's parameters (an endless signal has no duration at all)."""
MIN_SECONDS = 1e-6
"""Shortest duration of a signal that must have one [s]."""


def checked_number(name: str, value: object, low: float, high: float) -> float:
    """Return `value` as a float within [low, high]. Raise ValueError that names `name`
    otherwise."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name}: must be a number, not {type(value).__name__}")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not low <= number <= high:
        raise ValueError(f"{name}: must be from {low:g} to {high:g}, not {number:g}")
    return number


def checked_integer(name: str, value: object, low: int, high: int) -> int:
    """Return `value` as an int within [low, high]. Raise ValueError that names `name` otherwise."""
    whole = (
        value.is_integer()
        if isinstance(value, float)
        else isinstance(value, Integral) and not isinstance(value, bool)
    )
    if not whole:
        raise ValueError(f"{name}: must be a whole number, not {type(value).__name__}")
    number = int(cast(float, value))
    if not low <= number <= high:
        raise ValueError(f"{name}: must be from {low} to {high}")
    return number


def within(
    about: str, low: float, high: float, check: Callable[..., object] = checked_number
) -> dict[str, Any]:
    """The metadata of a signal's field for values from `low` to `high`. A default of None or
    infinity is allowed as well.

    about: what it is, for the JSON Schema. check: `checked_number`, `checked_integer`, or
    `checked_parameter` for a number or an automation.
    """
    return {"check": partial(check, low=low, high=high), "about": about}


def checked_column(
    name: str, numbers: Sequence[float] | FloatArray, limit: float, most: int | None = None
) -> FloatArray:
    """Return `numbers`, at least one and at most `most`, each within ±`limit`, as a read-only copy
    of shape (n,).

    Raise ValueError that names `name` otherwise.
    """
    try:
        column = np.array(numbers, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name}: must be a list of numbers") from None
    if column.ndim != 1 or not 1 <= column.size <= (most or column.size):
        raise ValueError(
            f"{name}: must be a list of {f'1 to {most} numbers' if most else 'at least one number'}"
        )
    if not np.all(np.abs(column) <= limit):
        raise ValueError(f"{name}: must be finite and within ±{limit:g}")
    column.setflags(write=False)
    return column
