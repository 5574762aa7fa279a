"""Signals as samples: once, or as a loop of those that never end."""

from __future__ import annotations

import base64
import math

import numpy as np

from ...core.arrays import FloatArray
from ...core.forms import JsonObject
from ...core.render.filter_bank import bank_reach, bank_response, split_bands
from ...core.render.voices import steady_tone
from ...core.signals import Signal

_SHORTEST, _LONGEST = 1.0, 4.0
"""Seconds of a loop."""
_FADE = 0.1
"""Seconds over which a loop fades from its end into its beginning."""
_SILENT = 1e-4
"""What is left out, in parts of the largest sample: bands, and the end of a signal."""
_FULL = 2**15 - 1


def sampled(signal: Signal, rate: int, lanes: int) -> JsonObject:
    """A signal as rows of samples. ``lanes``: 1, or 7, of which the first is of no signal and the
    others are frequency bands."""
    reach = bank_reach(rate)
    loops = not math.isfinite(signal.duration)
    if loops:
        begin = rate  # what begins with the signal is over
        whole = signal.sample(begin - reach, round(_LONGEST * rate) + 2 * reach, rate)
    else:
        tail = 0 if lanes == 1 else reach  # of the bands' filters
        whole = signal.sample(-reach, math.ceil(signal.duration * rate) + 2 * reach + tail, rate)
    alone = whole[reach:-reach]
    tone = steady_tone(signal, rate)
    if lanes == 1:
        rows, mix = alone[None], np.ones((1, 1))
    elif tone is not None and loops:
        rows = alone[None]
        mix = np.append(0.0, bank_response(float(tone.frequency), rate))[None]  # type: ignore[arg-type]
    else:
        rows, mix = split_bands(whole, rate), np.eye(lanes)[1:]
    peak = float(np.abs(rows).max()) or 1.0
    strength = np.abs(rows)
    heard = np.asarray(strength.max(axis=1) > _SILENT * peak)
    heard[0] |= not heard.any()
    rows, mix = rows[heard], mix[heard]
    if loops:
        rows = _closed(rows, _loop(alone, rate), rate)
    else:
        loud = np.flatnonzero(strength.max(axis=0) > _SILENT * peak)
        rows = rows[:, : 1 + int(loud.max(initial=0))]
    power = rows[:, :rate] @ rows[:, :rate].T
    total = power.sum()
    return {
        "loops": loops,
        "peak": peak,
        "rows": [_base64(row / peak) for row in rows],
        "mix": mix.tolist(),
        "power": (mix.T @ power @ mix / total if total > 0 else mix.T @ mix).tolist(),
    }


def _loop(samples: FloatArray, rate: int) -> int:
    """After how many samples the beginning comes again, as nearly as it does."""
    fade, least = round(_FADE * rate), round(_SHORTEST * rate)
    beginning = samples[:fade]
    size = len(samples)
    spectrum = np.fft.rfft(samples, 2 * size) * np.fft.rfft(beginning, 2 * size).conj()
    likeness = np.fft.irfft(spectrum, 2 * size)[: size - fade]
    energy = np.append(0.0, np.square(samples).cumsum())
    difference = energy[fade:size] - energy[: size - fade] - 2 * likeness
    return least + int(difference[least:].argmin())


def _closed(rows: FloatArray, count: int, rate: int) -> FloatArray:
    """The first ``count`` samples of rows, which fade from what follows them."""
    fade = round(_FADE * rate)
    share = (np.arange(fade) + 0.5) / fade
    loop = rows[:, :count].copy()
    loop[:, :fade] = share * loop[:, :fade] + (1 - share) * rows[:, count : count + fade]
    return loop


def _base64(samples: FloatArray) -> str:
    integers = np.rint(np.clip(samples, -1, 1) * _FULL).astype("<i2")
    return base64.b64encode(integers.tobytes()).decode("ascii")
