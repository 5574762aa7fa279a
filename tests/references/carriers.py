"""The values of carriers at any times, for comparison with their samples."""

import math

import numpy as np
from haptic_tracing.plugins.keyframes.carrier import _OSCILLATORS


def values_at(carrier, times):
    """The values at ``times`` (seconds, n), 0 outside [start, end)."""
    local = times - carrier.start
    oscillator, offset = _OSCILLATORS[carrier.wave]
    cycles = carrier.cycles(local) + (carrier.phase / (2 * math.pi) + offset)
    sounding = (times >= carrier.start) & (times < carrier.end)
    return np.where(
        sounding,
        np.interp(local, carrier.amplitude_times, carrier.amplitudes)
        * oscillator.wave(cycles, 0.0),
        0.0,
    )
