"""The ride in the four modes: levels, samples, and the sources of each frame."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..core.arrays import FloatArray, IntArray
from ..core.formats.tracks.listener_tracks import Tracks
from ..core.frozen import frozen
from ..core.scene.values import Mode
from .measures import mean_margin

MODES = (Mode.HT, Mode.SD, Mode.MD, Mode.MN)

TITLES: Mapping[Mode, str] = {
    Mode.HT: "Haptic tracing",
    Mode.SD: "Single actuator, distance",
    Mode.MD: "Multiple actuators, distance",
    Mode.MN: "Multiple actuators, no attenuation",
}
"""The paper's names of the modes."""


@frozen(eq=False)
class ActiveSource:
    """An active source in a frame.

    ``objects``: the one it is on, or the two that struck each other. ``began``: it is temporary,
    and this is its first frame. ``distance`` (l,) in metres, straight from its nearer side.
    ``amplitudes`` (4, l) that arrive, by `MODES`. ``paths``: objects of the best path in HT to each
    listener, where it began, else empty. ``loudness``: margin of its signal at amplitude 1 [dB];
    ``hertz``: the frequency that is felt most of it.
    """

    frame: int
    name: str
    objects: tuple[str, ...]
    began: bool
    amplitude: float
    distance: FloatArray
    amplitudes: FloatArray
    paths: tuple[tuple[str, ...], ...]
    loudness: float
    hertz: float

    @property
    def margins(self) -> FloatArray:
        """Decibels (4, l) above the threshold of feeling, by `MODES`."""
        with np.errstate(divide="ignore"):
            return 20 * np.log10(self.amplitudes) + self.loudness

    @property
    def persists(self) -> bool:
        """Whether it is a persistent source, not an impact."""
        return len(self.objects) == 1


@frozen(eq=False)
class Rendition:
    """The ride in one mode. ``rms`` and ``peak`` (f, l) of each frame's samples at each listener,
    ``margin`` (f, l) of the quarter second up to its end [dB]; ``tracks``: the samples."""

    mode: Mode
    rms: FloatArray
    peak: FloatArray
    margin: FloatArray
    tracks: Tracks


@frozen(eq=False)
class Ride:
    """A range of the ride's frames in all modes.

    ``frames`` (f,) are numbers. ``listeners`` are body parts; ``positions`` (l, 3) [m] where they
    were in the first frame. ``sections``: name, title, first and last frame of those in the range.
    ``largest_difference``: between any two listeners' samples at any time, by mode.
    """

    frames: IntArray
    frame_rate: float
    listeners: tuple[str, ...]
    positions: FloatArray
    renditions: Mapping[Mode, Rendition]
    soundings: tuple[ActiveSource, ...]
    sections: tuple[tuple[str, str, int, int], ...]
    largest_difference: Mapping[Mode, float]

    def rows(self, first: int, last: int) -> slice:
        """Where the frames from ``first`` to ``last`` are in ``frames``."""
        return slice(
            int(np.searchsorted(self.frames, first)),
            int(np.searchsorted(self.frames, last, side="right")),
        )

    def began(self, *words: str) -> tuple[ActiveSource, ...]:
        """Impacts in which an object takes part whose name begins with one of ``words``, in the
        order of time."""
        return tuple(
            s
            for s in self.soundings
            if s.began and any(name.startswith(words) for name in s.objects)
        )

    def effects(self, first: int = 0, last: int = 2**31) -> tuple[ActiveSource, ...]:
        """Consecutive effects: every impact at its beginning, every other source once per
        second."""
        each = round(self.frame_rate)
        return tuple(
            s
            for s in self.soundings
            if first <= s.frame <= last and (s.began or (s.persists and s.frame % each == 0))
        )

    def margins(self, mode: Mode, first: int = 0, last: int = 2**31) -> FloatArray:
        """The margins (e, l) of the effects in a mode."""
        number = MODES.index(mode)
        rows = [s.margins[number] for s in self.effects(first, last)]
        return np.array(rows, dtype=np.float64).reshape(-1, len(self.listeners))

    def equalising_gain(self, mode: Mode) -> float:
        """Decibels that make the mean energy felt in a mode that of the first of `MODES`; 0 where
        either is silent."""
        wanted, own = (mean_margin(self.renditions[one].margin) for one in (MODES[0], mode))
        return wanted - own if math.isfinite(wanted) and math.isfinite(own) else 0.0
