"""Vibrations read from a file, to use as templates of sources or to convert."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...frozen import frozen
from ...perception import FullScale
from ...signals import Sampled, Signal, Sum
from ...signals.interpolation import resample
from ...signals.limits import MAX_FREQUENCY, MAX_PEAK, MAX_SECONDS
from ...signals.sampled import MAX_SAMPLES
from .carrier import Carrier, rendered

SAMPLED_RATE = 4000
"""Sample rate (hertz) of a template with more than ``MOST_CARRIERS`` carriers."""
MOST_CARRIERS = 100
MOST_SAMPLES = 2**25
MOST_LAYERS = 64


@frozen(eq=False)
class Channel:
    """One vibration of a file: the sum of ``carriers`` and of ``samples`` (n,) at ``sample_rate``
    (hertz), from time 0.

    ``duration`` in seconds. ``body_part`` is empty, and ``device``, the calibration of its device,
    None, if the file does not give it.
    Raises ValueError for values beyond the limits of signals.
    """

    name: str
    duration: float
    carriers: tuple[Carrier, ...] = ()
    samples: NDArray[np.floating] | None = None
    sample_rate: float = 0.0
    body_part: str = ""
    device: FullScale | None = None

    def __post_init__(self) -> None:
        for carrier in self.carriers:
            for name, values, limit in (
                (
                    "time",
                    (
                        carrier.start,
                        carrier.end,
                        *carrier.amplitude_times[[0, -1]],
                        *carrier.frequency_times[[0, -1]],
                    ),
                    MAX_SECONDS,
                ),
                ("amplitude", carrier.amplitudes, MAX_PEAK),
                ("frequency", carrier.frequencies, MAX_FREQUENCY),
            ):
                if not (np.abs(values) <= limit).all():
                    raise ValueError(f"{self.name}: has a {name} beyond {limit:g}")

    def at_rate(self, sample_rate: float) -> FloatArray:
        """The vibration as samples, shape (ceil(duration * sample_rate),). Raises ValueError for
        more than ``MOST_SAMPLES``."""
        if self.duration * sample_rate > MOST_SAMPLES:
            raise ValueError(f"{self.name}: {self.duration:.6g} seconds are too long")
        if (
            sum(carrier.end - carrier.start for carrier in self.carriers) * sample_rate
            > MOST_LAYERS * MOST_SAMPLES
        ):
            raise ValueError(f"{self.name}: {len(self.carriers)} oscillations are too many at once")
        if self.samples is None:
            return rendered(self.carriers, 0, math.ceil(self.duration * sample_rate), sample_rate)
        samples = np.asarray(self.samples, dtype=np.float64)
        samples = (
            samples
            if self.sample_rate == sample_rate
            else resample(samples, self.sample_rate, sample_rate)
        )
        if self.carriers:
            count = max(math.ceil(self.duration * sample_rate), len(samples))
            samples = np.pad(samples, (0, count - len(samples))) + rendered(
                self.carriers, 0, count, sample_rate
            )
        return samples

    def to_signal(self) -> Signal:
        """The vibration as a template: oscillators with envelopes, or samples if they are more than
        ``MOST_CARRIERS``.

        Raises ValueError for a silent or too long vibration.
        """
        if self.samples is None and 0 < len(self.carriers) <= MOST_CARRIERS:
            parts = [carrier.to_signal() for carrier in self.carriers]
            return parts[0] if len(parts) == 1 else Sum(tuple(parts))
        if self.duration * (self.sample_rate or SAMPLED_RATE) > MAX_SAMPLES:
            raise ValueError(f"{self.name}: {self.duration:.6g} seconds are too long")
        samples = self.at_rate(self.sample_rate or SAMPLED_RATE)
        if not samples.any():
            raise ValueError(f"{self.name}: there is no vibration in it")
        return Sampled(samples, self.sample_rate or SAMPLED_RATE)


@frozen(eq=False)
class VibrationFile:
    """The vibrations of a file; ``losses``: ignored content, one sentence each.

    ``stored``: the samples of all channels (n_channels, n) if the file has such a table.
    """

    channels: tuple[Channel, ...]
    losses: tuple[str, ...] = ()
    stored: NDArray[np.floating] | None = None
