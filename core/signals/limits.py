"""Bounds on the parameters of signals, which keep every sample finite, and checks of them."""

from __future__ import annotations

import math
from numbers import Integral, Real
from typing import cast

MAX_PEAK = 1e6
"""Largest amplitude that a signal may reach."""
MAX_FREQUENCY = 20_000.0
"""Hertz."""
MAX_SECONDS = 1e6
"""Longest time in a signal's parameters (an endless signal has no duration at all)."""
MIN_SECONDS = 1e-6
"""Shortest duration of a signal that must have one [s]."""


def checked_number(name: str, value: object, low: float, high: float) -> float:
    """Return `value` as a float within [low, high]. Raise ValueError that names `name` otherwise."""
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
    whole = value.is_integer() if isinstance(value, float) else isinstance(value, Integral) and not isinstance(value, bool)
    if not whole:
        raise ValueError(f"{name}: must be a whole number, not {type(value).__name__}")
    number = int(cast(float, value))
    if not low <= number <= high:
        raise ValueError(f"{name}: must be from {low} to {high}")
    return number
