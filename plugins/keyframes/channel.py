"""A vibration in a file that is made of keyframed oscillations."""

from __future__ import annotations

import math

import numpy as np

from ...core.arrays import FloatArray
from ...core.formats.tracks.vibration_file import MOST_SAMPLES, Channel
from ...core.frozen import frozen
from ...core.signals import Signal, Sum
from ...core.signals.limits import MAX_FREQUENCY, MAX_PEAK, MAX_SECONDS
from .carrier import Carrier, rendered

SAMPLED_RATE = 4000
"""Sample rate (hertz) of a template with more than ``MOST_CARRIERS`` carriers."""
MOST_CARRIERS = 100
MOST_LAYERS = 64


@frozen(eq=False)
class KeyframedChannel(Channel):
    """The sum of ``carriers`` and, if there are any, of samples. Raises ValueError for values
    beyond the limits of signals."""

    carriers: tuple[Carrier, ...] = ()

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
        """The vibration as samples, as those of a `Channel`. Raises ValueError for too much to
        compute, too."""
        samples = Channel.at_rate(self, sample_rate)
        layers = sum(carrier.end - carrier.start for carrier in self.carriers)
        if layers * sample_rate > MOST_LAYERS * MOST_SAMPLES:
            raise ValueError(f"{self.name}: {len(self.carriers)} oscillations are too many at once")
        count = max(math.ceil(self.duration * sample_rate), len(samples))
        samples = np.pad(samples, (0, count - len(samples)))
        return samples + rendered(self.carriers, 0, count, sample_rate)

    def to_signal(self) -> Signal:
        """The vibration as a template: oscillators with envelopes, or samples if they are more than
        ``MOST_CARRIERS``.

        Raises ValueError for a silent or too long vibration.
        """
        if not len(self.samples) and 0 < len(self.carriers) <= MOST_CARRIERS:
            parts = [carrier.to_signal() for carrier in self.carriers]
            return parts[0] if len(parts) == 1 else Sum(tuple(parts))
        return self.sampled(self.sample_rate or SAMPLED_RATE)
