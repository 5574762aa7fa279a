"""A recording as a signal."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import parameter
from .base import Signal
from .interpolation import interpolate
from .limits import MAX_PEAK, checked_column

MAX_SAMPLES = 4_000_000
_OVERSHOOT = 4.0


@frozen(eq=False)
class Sampled(Signal, kind="sampled"):
    """`samples` at `rate` a second, band-limited between them, 0 outside.

    samples: shape (n,), 1 to 4,000,000 finite numbers. rate: hertz, 1 to 192,000.
    """

    samples: FloatArray
    rate: float = parameter(8000.0, "Sample rate of sampled", 1.0, 192_000.0)
    peak: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        Signal.__post_init__(self)
        object.__setattr__(
            self,
            "samples",
            checked_column("samples", self.samples, MAX_PEAK / _OVERSHOOT, MAX_SAMPLES),
        )
        # The largest sum of the kernel's magnitudes bounds the overshoot of interpolation.
        object.__setattr__(self, "peak", _OVERSHOOT * float(np.max(np.abs(self.samples))))

    @property
    def duration(self) -> float:
        return len(self.samples) / self.rate

    def values(self, times: FloatArray, step: float) -> FloatArray:
        return np.asarray(
            interpolate(self.samples[None, :], times * self.rate, max(1.0, step * self.rate))[0]
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sampled):
            return NotImplemented
        return self is other or (
            self.rate == other.rate and np.array_equal(self.samples, other.samples)
        )

    def __hash__(self) -> int:
        return hash((self.rate, self.samples.size, self.samples[:64].tobytes()))
