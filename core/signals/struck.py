"""A template with modified pitch, decay and brightness, for impacts of other strength."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import parameter
from .base import Modified, Signal
from .envelopes import SILENCE

LONGEST = 60.0
"""Longest template [s]."""
CORNER = 100.0
"""Frequency above which brightness acts [Hz]."""
_FINE, _MOST = 32_000.0, 480_000
"""Sample rate of the analysis of a template [Hz], and largest number of samples, which lowers the
rate for longer ones. Linear interpolation of a low-pass filtered tone of f Hz has the relative
error (pi f / rate)^2 / 2: -60 dB of the template at 1 kHz."""


@frozen
class Struck(Modified, kind="struck"):
    """`of`, played `pitch` times as fast, which multiplies all its frequencies, with its decay time
    times `decay` and its amplitude above `CORNER` times `brightness`.

    The decay time of any signal is that of the decaying tone whose energy has the same centre in
    time, the integral of t x² over that of x² being half of it. A shorter one takes an envelope
    exp(-t (1 / decay - 1) / decay time). Brightness b is a shelf of first order, (1 + b j f /
    CORNER) / (1 + j f / CORNER), of the template before its pitch is changed.

    pitch: 0.25 to 4. decay: 0.01 to 1. brightness: 0 to 1. of: ends within `LONGEST` seconds.
    """

    pitch: float = parameter(1.0, "Playback speed of struck", 0.25, 4.0)
    decay: float = parameter(1.0, "Factor of the decay time of struck", 0.01, 1.0)
    brightness: float = parameter(1.0, "Gain of struck above 100 Hz", 0.0, 1.0)

    def __post_init__(self) -> None:
        Modified.__post_init__(self)
        if not self.of.duration <= LONGEST:
            raise ValueError(f"of: must end within {LONGEST:g} seconds")

    @property
    def duration(self) -> float:
        whole = self.of.duration / self.pitch
        damping = self._damping
        return min(whole, -math.log(SILENCE) / damping) if damping else whole

    @property
    def _damping(self) -> float:
        """1/s."""
        return (
            0.0
            if self.decay == 1.0
            else (1.0 / self.decay - 1.0) * self.pitch / _analysed(self.of)[0]
        )

    def values(self, times: FloatArray, step: float) -> FloatArray:
        own = times * self.pitch
        step = step * self.pitch
        result = self.of.at(own, step)
        if self.brightness < 1.0:
            _, rate, dull = _analysed(self.of)
            before = np.minimum(own * rate, len(dull) - 2).astype(np.intp)
            dulled = dull[before] + (own * rate - before) * (dull[before + 1] - dull[before])
            result = self.brightness * result + (1.0 - self.brightness) * dulled
        return result if self.decay == 1.0 else result * np.exp(times * -self._damping)


@lru_cache(maxsize=128)
def _analysed(template: Signal) -> tuple[float, float, NDArray[np.float32]]:
    """The decay time of a template [s]; a rate [1/s]; and the template after a low-pass of first
    order at `CORNER`, sampled at that rate (at most 2 MB, 128 kB per second of the template)."""
    rate = min(_FINE, _MOST / template.duration)
    samples = template.sample(0, max(round(template.duration * rate), 1), rate)
    energy = samples * samples
    times = np.arange(len(samples)) / rate
    centre = float(energy @ times) / max(float(energy.sum()), 1e-300)
    # Response of y' = 2 pi corner (x - y) to an impulse, by the trapezoidal rule.
    part = math.exp(-2.0 * math.pi * CORNER / rate)
    response = (1.0 - part) / 2.0 * part ** np.arange(math.ceil(math.log(SILENCE) / math.log(part)))
    response[1:] += response[:-1]
    size = 1 << (len(samples) + len(response)).bit_length()
    dull = np.fft.irfft(np.fft.rfft(samples, size) * np.fft.rfft(response, size), size)[
        : len(samples)
    ]
    return max(2.0 * centre, 1.0 / rate), rate, np.append(dull, 0.0).astype(np.float32)
