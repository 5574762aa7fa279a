"""A vibration in a file as the signal of a source."""

from __future__ import annotations

import numpy as np

from ...core.formats.tracks.vibration_file import Channel, VibrationFile
from ...core.signals import Loop, Sampled, Signal
from ..blender.single_precision import shortest
from ..blender.words import TranslatedError

HIGHEST_RATE = 8000
"""Highest sample rate of a stored recording [Hz]: the rate at which listeners are rendered."""


def chosen_channel(reading: VibrationFile, number: int) -> Channel:
    """A channel by its number, from 1. Raises ValueError if there is none."""
    if not reading.channels:
        raise TranslatedError("There is no vibration in this file")
    if number > len(reading.channels):
        raise TranslatedError(
            "This file has no channel {}; the last one is {}", number, len(reading.channels)
        )
    return reading.channels[number - 1]


def signal_of(channel: Channel, loop: bool) -> Signal:
    """The signal of a channel, as it is stored with a source: a recording at no more than
    `HIGHEST_RATE`, in single precision."""
    signal = channel.to_signal()
    if isinstance(signal, Sampled):
        rate = min(signal.rate, HIGHEST_RATE)
        samples = channel.at_rate(rate) if rate < signal.rate else signal.samples
        signal = Sampled(np.array([shortest(v) for v in samples.tolist()]), rate)
    return Loop(signal) if loop else signal
