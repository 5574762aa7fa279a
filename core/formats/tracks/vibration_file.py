"""What a file of another tool holds for us: vibrations to use as templates of sources."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...signals import Automation, Delay, Keyed, Sampled, Saw, Signal, Sine, Square, Sum, Triangle
from ...signals.interpolation import resample
from ...signals.oscillators import Oscillator
from .carrier import Carrier, rendered

SAMPLED_RATE = 4000
"""Rate (hertz) of the samples that stand for more carriers than a signal may be made of."""
MOST_CARRIERS = 100
MOST_SAMPLES = 2**25
MOST_LAYERS = 64

_WAVES: dict[str, type[Oscillator]] = {"sine": Sine, "square": Square, "triangle": Triangle, "saw": Saw}


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """One vibration of a file: ``carriers`` to be added up, or ``samples`` (n,) at ``sample_rate``. ``duration`` in seconds.
    ``body_part`` is empty where the file does not say whose it is."""

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
        """The vibration as a template: oscillators with envelopes where they are few enough to be edited, else a recording.
        Raises ValueError for what is silent or too long."""
        if self.samples is None and 0 < len(self.carriers) <= MOST_CARRIERS:
            parts = [signal_of(carrier) for carrier in self.carriers]
            return parts[0] if len(parts) == 1 else Sum(tuple(parts))
        samples = self.at_rate(self.sample_rate or SAMPLED_RATE)
        if not samples.any():
            raise ValueError(f"{self.name}: there is no vibration in it")
        return Sampled(samples, self.sample_rate or SAMPLED_RATE)


@dataclass(frozen=True, slots=True, eq=False)
class VibrationFile:
    """The vibrations of a file, and what of it could not be taken over, in words."""

    channels: tuple[Channel, ...]
    losses: tuple[str, ...] = ()


def signal_of(carrier: Carrier) -> Signal:
    """A carrier as a signal that can be edited: an oscillator with a keyed frequency times a keyed envelope."""
    oscillator = _WAVES[carrier.wave](_automation(carrier.frequency_times, carrier.frequencies), phase=carrier.phase / (2 * math.pi))
    length = carrier.end - carrier.start
    before = carrier.amplitude_times < length
    times = np.append(carrier.amplitude_times[before], length)
    values = np.append(carrier.amplitudes[before], np.interp(length, carrier.amplitude_times, carrier.amplitudes))
    signal = oscillator * Keyed(Automation(times, values))
    return Delay(signal, carrier.start) if carrier.start else signal


def _automation(times: FloatArray, values: FloatArray) -> float | Automation:
    return float(values[0]) if (values == values[0]).all() else Automation(times, values)
