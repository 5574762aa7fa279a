"""Level, peak and margin of each listener, as numbers and texts.

The *level* is the RMS of a listener's output without its steady part, in decibels of full scale.
The *margin* is the level relative to the threshold of feeling. The *gain* is a property of a path:
neither the source's amplitude nor the listener's own gain is part of it.
"""

from __future__ import annotations

import math

import numpy as np

from ...core.arrays import FloatArray
from ...core.frozen import frozen
from ...core.message import decibels as whole_decibels
from ...core.render.frame_result import FrameResult
from ...core.render.history import lasts, still_samples
from ...core.render.levels import LEVEL_SECONDS as LEVEL_SECONDS
from ...core.render.levels import level_and_margin as level_and_margin
from ..blender.words import ui_text
from ..session.derived import Derived
from ..session.sessions import Traced

FLOOR = -60.0
"""Lower end of a meter [dB of full scale]."""
PEAK_SECONDS = 0.1
"""Durations over which peak and level are computed [s]."""
_LEAST_NAMED = -120.0
"""Level [dB of full scale] under which a list says "silent": about 70 dB below what can be felt."""


@frozen
class Level:
    """The strength at a listener in decibels, minus infinity for silence.

    ``peak`` and ``rms``: of full scale. ``margin``: above the threshold of feeling. ``threshold``:
    the RMS level of this vibration at the threshold of feeling, None for silence. ``is_assumed``:
    the device isn't calibrated.
    """

    listener: str
    body_part: str
    peak: float
    rms: float
    margin: float
    threshold: float | None
    is_assumed: bool = True

    @property
    def is_felt(self) -> bool:
        """True above the threshold of feeling."""
        return self.margin > 0

    @property
    def is_silent(self) -> bool:
        """True for silence."""
        return self.rms == -math.inf

    @property
    def place(self) -> float:
        """Position of the level on a meter, 0 to 1."""
        return place_of(self.rms)

    def level_text(self) -> str:
        """The level in a list: "−12 dB", or "silent" also for what is next to nothing."""
        return decibels(self.rms if self.rms >= _LEAST_NAMED else -math.inf)

    def margin_text(self) -> str:
        """The margin with its sign: "+23 dB", "−5 dB", "" for silence."""
        return margin_words(self.margin)

    def margin_and_basis(self) -> str:
        """The margin, and whether its threshold is assumed: "+23 dB (assumed)"."""
        return basis_words(self.margin_text(), self.is_assumed)


def basis_words(words: str, is_assumed: bool) -> str:
    """Words about a margin, with "(assumed)" if the listener's device isn't calibrated."""
    return ui_text("{} (assumed)", words) if is_assumed else words


def place_of(level: float) -> float:
    """Position of a level in decibels on a meter, 0 to 1."""
    return min(max(1 - level / FLOOR, 0.0), 1.0)


def decibels(level: float) -> str:
    """A level as text: "−12 dB", or "silent"."""
    return ui_text("silent") if level == -math.inf else whole_decibels(level)


def change_words(change: float) -> str:
    """What is added to a level, in tenths of decibels with its sign: "−12.3 dB", or "silent"."""
    if change == -math.inf:
        return ui_text("silent")
    return f"{change:+.1f} dB".replace("-", "\N{MINUS SIGN}") if abs(change) >= 0.05 else "0.0 dB"


def margin_words(margin: float) -> str:
    """A margin in decibels with its sign: "+23 dB", "−5 dB", "0 dB", "" for silence."""
    if margin == -math.inf:
        return ""
    return f"{'+' if round(margin) > 0 else ''}{whole_decibels(margin)}"


def levels(
    result: FrameResult, samples: FloatArray, peak_seconds: float = PEAK_SECONDS
) -> tuple[Level, ...]:
    """The levels of all listeners at the end of ``samples`` (l, n)."""
    peak = np.abs(_end(samples, peak_seconds, result.sample_rate)).max(axis=1, initial=0.0)
    with np.errstate(divide="ignore"):
        loud = 20 * np.log10(peak)
    mean, margin = level_and_margin(
        _end(samples, LEVEL_SECONDS, result.sample_rate), result.sample_rate, result.listeners
    )
    return tuple(
        Level(
            listener.name,
            listener.body_part,
            p,
            r,
            m,
            r - m if math.isfinite(m) and math.isfinite(r) else None,
            listener.device is None,
        )
        for listener, p, r, m in zip(
            result.listeners, loud.tolist(), mean.tolist(), margin.tolist(), strict=True
        )
    )


def _end(samples: FloatArray, seconds: float, sample_rate: float) -> FloatArray:
    """The last ``seconds`` of samples (l, n)."""
    return samples[:, max(samples.shape[1] - round(seconds * sample_rate), 0) :]


def shown_levels(
    traced: Traced, is_playing: bool, before: tuple[Level, ...] | None = None
) -> tuple[Level, ...]:
    """The levels of a frame: during playback those of the last quarter second, otherwise those of
    the frame in the steady state.

    The level of a still frame therefore does not depend on earlier frames. Playback of less than a
    quarter second counts as a still frame; a baked track has only samples.
    """
    return levels(
        traced.result,
        felt_samples(traced, is_playing),
        LEVEL_SECONDS if _shows_still(traced, is_playing) else PEAK_SECONDS,
    )


def felt_samples(traced: Traced, is_playing: bool) -> FloatArray:
    """The samples (l, n) from which `shown_levels` computes the levels."""
    if _shows_still(traced, is_playing):
        return still_samples(traced.result)
    return _end(traced.samples, LEVEL_SECONDS, traced.result.sample_rate)


def _shows_still(traced: Traced, is_playing: bool) -> bool:
    if traced.reading is None:
        return False
    return not (is_playing and lasts(traced.result, traced.samples.shape[1]))


STILL: Derived[None, FloatArray] = Derived(lambda traced, *_: still_samples(traced.result))
"""The samples (l, n) of a frame as if it lasted."""

LEVELS: Derived[bool, tuple[Level, ...]] = Derived(shown_levels, every_frame=True, hears=True)
