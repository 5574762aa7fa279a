"""Samples as 16-bit integers, as bakes keep them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray

FULL_SCALE = 32767
"""The integer that stands for a sample of 1.0. Steps of 1/32767 are 90 dB below full scale, far
below the threshold of feeling."""


def as_integers(samples: FloatArray) -> NDArray[np.int16]:
    """Samples in [-1, 1] as integers."""
    return np.rint(np.clip(samples, -1, 1) * FULL_SCALE).astype(np.int16)
