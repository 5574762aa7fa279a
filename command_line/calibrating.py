"""The full scale of an actuator, from what it was played and what an accelerometer recorded."""

from __future__ import annotations

import math

import numpy as np

from ..core.arrays import FloatArray

SWEEP = (30.0, 400.0)
"""Ends of the test sweep [Hz]: from the lowest frequency that a hand feels as vibration to the
upper limit of most actuators."""
SWEEP_AMPLITUDE = 0.6
"""Amplitude of the test sweep, moderate."""
_WINDOW = 0.25
_BANDS = tuple(1000 * 2 ** (k / 3) for k in range(-18, 1))
"""Centres of the thirds of an octave that are measured [Hz], 16 to 1000."""
_PLAYED = 0.1
"""A window belongs to a band if so much of the strongest energy of the band was played in it, and a
band counts if so much of the strongest energy of all was."""
_NOISE = 10.0
"""Least ratio of energies of a band while it is played and while nothing is."""


def sweep(seconds: float, sample_rate: float) -> FloatArray:
    """The test sweep (n,): a sine whose frequency rises exponentially."""
    growth = math.log(SWEEP[1] / SWEEP[0])
    part = np.arange(round(seconds * sample_rate)) / (seconds * sample_rate)
    phase = 2 * math.pi * SWEEP[0] * seconds / growth * np.expm1(growth * part)
    return SWEEP_AMPLITUDE * np.sin(phase)


def measured_full_scale(
    played: FloatArray, recorded: FloatArray, sample_rate: float
) -> tuple[tuple[float, float], ...]:
    """Frequencies [Hz], thirds of an octave, and the amplitude that is ``recorded`` (m,) there of a
    sine of amplitude 1, from what was ``played`` (n,) meanwhile, at any time.

    Each band counts only while it is played, so that overtones do not count, and only if it is 10
    dB above what is recorded while nothing is played. Raises ValueError if no band is.
    """
    aligned = _aligned(played, recorded)
    given, taken = (_energies(samples, sample_rate) for samples in (aligned, recorded))
    frequency = np.fft.rfftfreq(round(_WINDOW * sample_rate), 1 / sample_rate)
    silent = given.sum(axis=1) < 1e-6 * given.sum(axis=1).max(initial=0.0)
    found = []
    for centre in _BANDS:
        inside = (frequency >= centre * 2 ** (-1 / 6)) & (frequency < centre * 2 ** (1 / 6))
        energy = given[:, inside].sum(axis=1)
        answer = taken[:, inside].sum(axis=1)
        sounding = energy > _PLAYED * energy.max(initial=0.0)
        noise = answer[silent].mean() if silent.any() else 0.0
        if energy.max(initial=0.0) < _PLAYED * given.sum(axis=1).max(initial=0.0) or (
            answer[sounding].mean() <= _NOISE * noise
        ):
            continue
        found.append((centre, math.sqrt(answer[sounding].sum() / energy[sounding].sum())))
    if not found:
        raise ValueError(
            "no frequency of what was played stands 10 dB above the rest of the recording"
        )
    return tuple(found)


def _aligned(played: FloatArray, recorded: FloatArray) -> FloatArray:
    """``played`` at the time (m,) at which it is heard in ``recorded`` (m,), silence around it."""
    length = len(played) + len(recorded)
    product = np.fft.rfft(recorded, length) * np.conj(np.fft.rfft(played, length))
    lag = int(np.abs(np.fft.irfft(product, length)).argmax())
    shifted = np.zeros(length)
    shifted[: len(played)] = played
    return np.roll(shifted, lag)[: len(recorded)]


def _energies(samples: FloatArray, sample_rate: float) -> FloatArray:
    """Energies (w, f) of overlapping windows."""
    width = round(_WINDOW * sample_rate)
    starts = range(0, max(len(samples) - width, 0) + 1, width // 2)
    window = np.hanning(width)
    rows = [
        np.pad(samples[at : at + width], (0, max(at + width - len(samples), 0))) for at in starts
    ]
    return np.abs(np.fft.rfft(np.array(rows) * window, axis=1)) ** 2
