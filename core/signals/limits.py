"""Limits of the parameters of signals, which keep every sample finite, and their checks."""

from __future__ import annotations

from collections.abc import Sequence

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
