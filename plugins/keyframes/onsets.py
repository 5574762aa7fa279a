"""Sudden rises of a vibration: onsets, and the short pulses among them."""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ...core.arrays import FloatArray, IntArray

RATE = 1000
"""Rate (hertz) of the levels."""
QUIET, RISING = 8, 5
"""Milliseconds that are quiet, before an onset rises and after a pulse: half a period of 60 Hz, so
that no tone has onsets; and the longest rise."""
PROMINENT, FAINT = 16.0, 0.0025
"""Least power of an onset relative to that of the quiet around it, and to the largest power."""
DECAYED = 4.0
"""Least largest power of a pulse relative to that after it."""
TOGETHER = 20
"""Milliseconds within which an onset belongs to an impact."""


def onsets(power: FloatArray) -> IntArray:
    """The milliseconds at which ``power`` (n,), the mean square of each, gets 12 dB above that of
    all that are shortly before."""
    loudest = sliding_window_view(np.pad(power, (QUIET + RISING, 0)), QUIET).max(axis=1)
    least = FAINT * power.max(initial=0.0)
    found = np.flatnonzero((power > PROMINENT * loudest[: len(power)]) & (power > least))
    return found[np.diff(found, prepend=-RISING - 1) > RISING]


def pulses(power: FloatArray, longest: float) -> IntArray:
    """The onsets of what decays within ``longest`` seconds to less than a part of its largest
    power, as a blow or a pulse does, and no tone."""
    begins = onsets(power)
    length = math.ceil(longest * RATE) + 1
    padded = np.pad(power, (0, length + QUIET))
    peaks = sliding_window_view(padded, length)[begins].max(axis=1)
    after = sliding_window_view(padded[1:], QUIET).max(axis=1)
    ends = sliding_window_view(after, length)[begins].min(axis=1)
    return np.asarray(begins[ends * DECAYED < peaks])


def away_from(found: IntArray, impacts: FloatArray) -> IntArray:
    """The onsets (milliseconds) that are not near one of the ``impacts``, ascending seconds."""
    near = np.searchsorted(impacts, (found + TOGETHER) / RATE) > np.searchsorted(
        impacts, (found - TOGETHER) / RATE
    )
    return found[~near]
