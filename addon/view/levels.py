"""Level and margin of each listener, as numbers and texts.

The *level* is the RMS of a listener's output without its steady part, in decibels of full scale.
The *margin* is the level relative to the threshold of feeling. The *gain* is a property of a path:
neither the source's amplitude nor the listener's own gain is part of it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from ...core.arrays import FloatArray
from ...core.frozen import frozen
from ...core.message import decibels
from ...core.render.frame_result import FrameResult
from ...core.render.history import lasts, still_samples
from ...core.render.levels import LEVEL_SECONDS as LEVEL_SECONDS
from ...core.render.levels import level_and_margin as level_and_margin
from ...core.scene.values import Listener
from ..blender.words import ui_text
from ..session.derived import Derived
from ..session.sessions import Traced

LEAST, MOST = -20.0, 40.0
"""Ends of a meter [dB above the threshold of feeling]."""
_NOTHING = -60.0
"""Margin [dB] that is no longer worth a number."""


@frozen
class Level:
    """The strength at a listener in decibels, minus infinity for silence.

    ``title``: the listener's name, as short as it is unique. ``rms``: of full scale. ``margin``:
    above the threshold of feeling. ``is_assumed``: the device isn't calibrated.
    """

    listener: str
    title: str
    body_part: str
    rms: float
    margin: float
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
        """Position of the margin on a meter, 0 to 1."""
        return place_of(self.margin)

    def margin_text(self) -> str:
        """The margin with its sign: "+23 dB", "−5 dB"; a dash far below feeling."""
        return margin_words(self.margin) if self.margin > _NOTHING else "\N{EM DASH}"

    def words(self) -> str:
        """The margin, or that nothing is felt."""
        return self.verdict() if self.is_silent else self.margin_text()

    def verdict(self) -> str:
        """Whether something is felt, and by how much."""
        if self.is_silent:
            return ui_text("Feels nothing")
        words = ui_text("Felt: {}" if self.is_felt else "Too weak: {}")
        return words.format(margin_words(self.margin))


def titles(listeners: Sequence[Listener]) -> list[str]:
    """Names as short as they are unique: of a listener whose name ends with its body part, the
    part."""
    parts = Counter(item.body_part for item in listeners)
    return [
        item.body_part
        if item.body_part
        and parts[item.body_part] == 1
        and item.name.rstrip(".0123456789").endswith(item.body_part)
        else item.name
        for item in listeners
    ]


def place_of(margin: float) -> float:
    """Position of a margin in decibels on a meter, 0 to 1."""
    return min(max((margin - LEAST) / (MOST - LEAST), 0.0), 1.0)


def change_words(change: float) -> str:
    """What is added to a level, in tenths of decibels with its sign: "−12.3 dB", or "silent"."""
    if change == -math.inf:
        return ui_text("silent")
    return f"{change:+.1f} dB".replace("-", "\N{MINUS SIGN}") if abs(change) >= 0.05 else "0.0 dB"


def margin_words(margin: float) -> str:
    """A margin in decibels with its sign: "+23 dB", "−5 dB", "0 dB", "" for silence."""
    if margin == -math.inf:
        return ""
    return f"{'+' if round(margin) > 0 else ''}{decibels(margin)}"


def levels(result: FrameResult, samples: FloatArray) -> tuple[Level, ...]:
    """The levels of all listeners at the end of ``samples`` (l, n)."""
    mean, margin = level_and_margin(
        _end(samples, LEVEL_SECONDS, result.sample_rate), result.sample_rate, result.listeners
    )
    return tuple(
        Level(listener.name, title, listener.body_part, r, m, listener.device is None)
        for listener, title, r, m in zip(
            result.listeners,
            titles(result.listeners),
            mean.tolist(),
            margin.tolist(),
            strict=True,
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
    return levels(traced.result, felt_samples(traced, is_playing))


def felt_samples(traced: Traced, is_playing: bool) -> FloatArray:
    """The samples (l, n) from which `shown_levels` computes the levels."""
    if _shows_still(traced, is_playing):
        return still_samples(traced.result)
    return _end(traced.samples, LEVEL_SECONDS, traced.result.sample_rate)


def _shows_still(traced: Traced, is_playing: bool) -> bool:
    if traced.reading is None:
        return False
    return not (is_playing and lasts(traced.result, traced.samples.shape[1]))


LEVELS: Derived[bool, tuple[Level, ...]] = Derived(shown_levels, every_frame=True, hears=True)
