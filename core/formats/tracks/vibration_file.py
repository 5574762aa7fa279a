"""Vibrations read from a file, to use as templates of sources or to convert."""

from __future__ import annotations

from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...frozen import frozen
from ...perception import FullScale
from ...signals import Sampled, Signal
from ...signals.interpolation import resample
from ...signals.sampled import MAX_SAMPLES

MOST_SAMPLES = 2**25


@frozen(eq=False)
class Channel:
    """One vibration of a file, from time 0: ``samples`` (n,) at ``sample_rate`` (hertz).

    ``duration`` in seconds. ``body_part`` is empty, and ``device``, the calibration of its device,
    None, if the file does not give it. Plug-ins have channels that hold more than samples.
    """

    name: str
    duration: float
    samples: NDArray[np.floating] = field(default_factory=lambda: np.zeros(0))
    sample_rate: float = 0.0
    body_part: str = ""
    device: FullScale | None = None

    def at_rate(self, sample_rate: float) -> FloatArray:
        """The vibration as samples, shape (ceil(duration * sample_rate),). Raises ValueError for
        more than ``MOST_SAMPLES``."""
        if self.duration * sample_rate > MOST_SAMPLES:
            raise ValueError(f"{self.name}: {self.duration:.6g} seconds are too long")
        samples = np.asarray(self.samples, dtype=np.float64)
        if not len(samples) or self.sample_rate == sample_rate:
            return samples
        return resample(samples, self.sample_rate, sample_rate)

    def to_signal(self) -> Signal:
        """The vibration as a template. Raises ValueError for a silent or too long vibration."""
        return self.sampled(self.sample_rate)

    def sampled(self, rate: float) -> Sampled:
        """The vibration as a template of samples. Raises ValueError as `to_signal` does."""
        if self.duration * rate > MAX_SAMPLES:
            raise ValueError(f"{self.name}: {self.duration:.6g} seconds are too long")
        samples = self.at_rate(rate)
        if not samples.any():
            raise ValueError(f"{self.name}: there is no vibration in it")
        return Sampled(samples, rate)


@frozen(eq=False)
class VibrationFile:
    """The vibrations of a file; ``losses``: ignored content, one sentence each.

    ``stored``: the samples of all channels (n_channels, n) if the file has such a table.
    """

    channels: tuple[Channel, ...]
    losses: tuple[str, ...] = ()
    stored: NDArray[np.floating] | None = None
