"""Vibrations read from a file, to use as templates of sources."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...arrays import FloatArray
from ...signals import Sampled, Signal, Sum
from ...signals.interpolation import resample
from .carrier import Carrier, rendered

SAMPLED_RATE = 4000
"""Sample rate (hertz) of a template with more than ``MOST_CARRIERS`` carriers."""
MOST_CARRIERS = 100
MOST_SAMPLES = 2**25
MOST_LAYERS = 64


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """One vibration of a file: the sum of ``carriers``, or ``samples`` (n,) at ``sample_rate``.

    ``duration`` in seconds. ``body_part`` is empty if the file does not give it.
    """

    name: str
    duration: float
    carriers: tuple[Carrier, ...] = ()
    samples: FloatArray | None = None
    sample_rate: float = 0.0
    body_part: str = ""

    def at_rate(self, sample_rate: float) -> FloatArray:
        """The vibration as samples, shape (ceil(duration * sample_rate),). Raises ValueError for more than ``MOST_SAMPLES``."""
        if self.duration * sample_rate > MOST_SAMPLES:
            raise ValueError(f"{self.name}: {self.duration:.6g} seconds are too long")
        if sum(carrier.end - carrier.start for carrier in self.carriers) * sample_rate > MOST_LAYERS * MOST_SAMPLES:
            raise ValueError(f"{self.name}: {len(self.carriers)} oscillations are too many at once")
        if self.samples is None:
            return rendered(self.carriers, math.ceil(self.duration * sample_rate), sample_rate)
        return self.samples if self.sample_rate == sample_rate else resample(self.samples, self.sample_rate, sample_rate)

    def to_signal(self) -> Signal:
        """The vibration as a template: oscillators with envelopes, or samples if they are more than ``MOST_CARRIERS``.

        Raises ValueError for a silent or too long vibration.
        """
        if self.samples is None and 0 < len(self.carriers) <= MOST_CARRIERS:
            parts = [carrier.to_signal() for carrier in self.carriers]
            return parts[0] if len(parts) == 1 else Sum(tuple(parts))
        samples = self.at_rate(self.sample_rate or SAMPLED_RATE)
        if not samples.any():
            raise ValueError(f"{self.name}: there is no vibration in it")
        return Sampled(samples, self.sample_rate or SAMPLED_RATE)


@dataclass(frozen=True, slots=True, eq=False)
class VibrationFile:
    """The vibrations of a file; ``losses``: what of it was not read, one sentence each."""

    channels: tuple[Channel, ...]
    losses: tuple[str, ...] = ()
