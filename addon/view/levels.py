"""How much each listener feels: what the meters show, as numbers and as words."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from bpy.app.translations import pgettext_iface as iface_

from ...core.perception import sensation_level
from ...core.render.frame_result import FrameResult
from ...core.render.history import History

FLOOR = -60.0
"""Decibels of full scale at which a meter begins."""
PEAK_SECONDS, RMS_SECONDS = 0.1, 0.25


@dataclass(frozen=True, slots=True)
class Level:
    """What a listener feels, in decibels of full scale, minus infinity for silence. ``sensation``: decibels above the threshold of feeling;
    ``threshold``: the RMS level at which a vibration of this kind would just be felt, None for silence."""

    listener: str
    body_part: str
    peak: float
    rms: float
    sensation: float
    threshold: float | None

    @property
    def is_felt(self) -> bool:
        return self.sensation > 0

    @property
    def place(self) -> float:
        """Where the RMS level is on the meter, 0 to 1."""
        return place_of(self.rms)

    def words(self) -> str:
        """Peak and RMS in decibels: "−12, −20", "silent" """
        return iface_("silent") if self.peak == -math.inf else f"{_number(self.peak)}, {_number(self.rms)}"

    def feeling(self) -> str:
        """How far above or below the threshold of feeling: "23 dB felt", "5 dB too weak", "" for silence."""
        if self.sensation == -math.inf:
            return ""
        return iface_("{:.0f} dB felt" if self.is_felt else "{:.0f} dB too weak").format(abs(self.sensation))


def place_of(level: float) -> float:
    """Where a level in decibels is on a meter, 0 to 1."""
    return min(max(1 - level / FLOOR, 0.0), 1.0)


def decibels(level: float) -> str:
    """A level as text: "−12 dB"."""
    return iface_("silent") if level == -math.inf else f"{_number(level)} dB"


def _number(level: float) -> str:
    return f"\N{MINUS SIGN}{-level:.0f}" if round(level) < 0 else f"{max(level, 0.0):.0f}"


def levels(result: FrameResult, history: History) -> tuple[Level, ...]:
    """The levels of all listeners of a frame."""
    names = [listener.name for listener in result.listeners]
    if list(history.listeners) != names:
        history = History()
        history.feed(result)
    recent, latest = history.all(RMS_SECONDS), history.all(PEAK_SECONDS)
    peak = np.abs(latest).max(axis=1, initial=0.0)
    rms = np.sqrt((recent**2).mean(axis=1)) if recent.shape[1] else np.zeros(len(names))
    sensation = sensation_level(recent, result.sample_rate)
    with np.errstate(divide="ignore"):
        loud, mean = 20 * np.log10(peak), 20 * np.log10(rms)
    return tuple(
        Level(
            listener.name, listener.body_part, p, r, s, r - s if math.isfinite(s) and math.isfinite(r) else None
        )
        for listener, p, r, s in zip(result.listeners, loud.tolist(), mean.tolist(), sensation.tolist(), strict=True)
    )  # fmt: skip
