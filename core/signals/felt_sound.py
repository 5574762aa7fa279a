"""A sound as vibration: a carrier whose amplitude follows the sound, and a burst at every onset."""

from __future__ import annotations

import math

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from .automation import Automation
from .base import Signal
from .envelopes import Keyed
from .keys import needed_keys
from .oscillators import Sine
from .sound import HOP, Heard

BURST_CYCLES = 2
"""Sine cycles of a burst, as the reference renderer of MPEG haptics (ISO/IEC 23090-31) plays
transients."""
SLOWEST_BURST = 80.0
"""Least frequency of a burst [Hz], so that it ends before the next one can begin."""
_STEADY = 2
"""Half-width of the median filter of pitches."""
_ROUGH, _OFF = 0.02, 0.005
"""Relative and absolute error of the amplitude due to omitted keys; the relative one also applies
to the pitch."""


@frozen
class Feel:
    """Settings of the conversion of a sound.

    frequency: that of the carrier [Hz], also while there is no pitch. pitch: whether the carrier
    follows the sound's pitch, transposed by octaves into ``band`` [Hz]. gate: level below which the
    output is 0 [dB of full scale]. gain: factor of the level. release: time constant of the decay
    of the amplitude [s]. bursts: amplitude of onsets, 0 to 1.
    """

    frequency: float = 160.0
    pitch: bool = False
    band: tuple[float, float] = (40.0, 400.0)
    gate: float = -40.0
    gain: float = 1.0
    release: float = 0.03
    bursts: float = 1.0


def felt_onsets(heard: Heard, feel: Feel) -> tuple[FloatArray, FloatArray]:
    """The times [s] of the onsets above the gate, and the amplitudes of their bursts."""
    loud = heard.strengths >= 10 ** (feel.gate / 20)
    return heard.onsets[loud], feel.bursts * np.minimum(feel.gain * heard.strengths[loud], 1.0)


def amplitudes(heard: Heard, feel: Feel) -> FloatArray:
    """The carrier's amplitude every `HOP` seconds: the level with release, gate and gain, minus the
    amplitude of a burst.

    A peak detector with exponential release (U. Zölzer, DAFX, 2011, chapter 4), written as a
    running maximum.
    """
    steps = np.arange(len(heard.levels)) * (HOP / max(feel.release, 1e-4))
    held = np.exp(np.maximum.accumulate(np.log(np.maximum(heard.levels, 1e-9)) + steps) - steps)
    result = np.minimum(feel.gain * np.where(held >= 10 ** (feel.gate / 20), held, 0.0), 1.0)
    times, bursts = felt_onsets(heard, feel)
    first = np.floor(times / HOP).astype(np.intp)
    for later in range(math.ceil(_burst_seconds(feel) / HOP) + 2):
        place = np.minimum(first + later, len(result) - 1)
        result[place] = np.minimum(result[place], 1.0 - bursts)
    return result


def frequencies(heard: Heard, feel: Feel) -> FloatArray:
    """The carrier's frequency [Hz] every `HOP` seconds where it follows the pitch; without one, the
    last pitch is kept."""
    voiced = np.flatnonzero(heard.pitches)
    if not len(voiced):
        return np.full(len(heard.pitches), feel.frequency)
    last = np.searchsorted(voiced, np.arange(len(heard.pitches)), side="right") - 1
    known = np.pad(heard.pitches[voiced[np.maximum(last, 0)]], _STEADY, mode="edge")
    pitch = np.median(np.lib.stride_tricks.sliding_window_view(known, 2 * _STEADY + 1), axis=1)
    low, high = feel.band
    octaves = np.minimum(np.floor(np.log2(high / pitch)), 0.0) + np.maximum(
        np.ceil(np.log2(low / pitch)), 0.0
    )
    return np.clip(pitch * 2.0**octaves, low, high)


def vibration(heard: Heard, feel: Feel) -> Signal:
    """The vibration of a sound, as long as it; its largest value is about 1 at most. Raises
    ValueError if nothing is above the gate."""
    level = np.round(amplitudes(heard, feel), 4)
    level[-1] = 0.0
    times, bursts = felt_onsets(heard, feel)
    if not level.any() and not bursts.any():
        raise ValueError("nothing in the sound is louder than the gate")
    seconds = np.minimum(np.arange(len(level)) * HOP, heard.seconds)
    kept = needed_keys(seconds, level, _OFF + _ROUGH * level)
    frequency: float | Automation = feel.frequency
    if feel.pitch:
        followed = np.round(frequencies(heard, feel), 2)
        keyed = needed_keys(seconds, followed, _ROUGH * followed)
        frequency = Automation(seconds[keyed], followed[keyed])
    carrier = Keyed(Automation(seconds[kept], level[kept])) * Sine(frequency)
    return carrier + _bursts(times, bursts, feel, heard.seconds) if bursts.any() else carrier


def _burst_seconds(feel: Feel) -> float:
    return BURST_CYCLES / max(feel.frequency, SLOWEST_BURST)


def _bursts(times: FloatArray, strengths: FloatArray, feel: Feel, seconds: float) -> Signal:
    """All bursts as one sine with whole cycles between them, so that each begins at phase 0."""
    length = _burst_seconds(feel)
    begins = np.append(times, max(seconds, times[-1] + length))
    ends = np.append(0.0, times + length)
    zero = np.zeros(len(times))
    one = np.ones(len(times))
    keys = np.column_stack([times, times, ends[1:], ends[1:]]).ravel()
    levels = np.column_stack([zero, strengths, strengths, zero]).ravel()
    gaps = begins - ends
    between = np.divide(
        np.round(gaps * BURST_CYCLES / length), gaps, out=np.zeros_like(gaps), where=gaps > 1e-9
    )
    rates = np.column_stack(
        [between[:-1], one * BURST_CYCLES / length, one * BURST_CYCLES / length, between[1:]]
    ).ravel()
    return Keyed(
        Automation(np.append(keys, begins[-1]), np.append(np.round(levels, 4), 0.0))
    ) * Sine(Automation(keys, rates))
