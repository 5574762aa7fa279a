"""Gains over time: straight lines from frame to frame, smoothed where they bend.

The corners of the lines would cause broadband artefacts. Therefore each gain is its line convolved
with a Hann window over the last `SMOOTHING` seconds: it never leaves the range of the line's
values, is straight where the line has been straight for that long, and has two continuous
derivatives. It lags behind the line by half the window: with slope b at time t and changes of slope
c at the times u before,

    gain(t) = line(t) - b SMOOTHING / 2 + sum of c corner(t - u)

A line to 0 arrives there `SMOOTHING` before the frame's end, so that the gain is 0 at its end.
"""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..frozen import frozen

SMOOTHING = 0.008
"""Seconds of the window. From 250 Hz on it passes less than -31 dB of a corner."""
_CLOSING = 1.5 * SMOOTHING
"""Frames shorter than this [s] are too short for a line to reach 0 early: it does so at the frame's
end, and the smoothed gain in the frames after."""
_INSTANT = 1e-9
"""Frames shorter than this [s] count as instants, in which gains jump."""


@frozen
class FrameSamples:
    """The samples `first` to `last - 1` at `times` [s], and how far (0 to 1) each is from the
    frame's start to its end."""

    start: float
    end: float
    first: int
    last: int
    times: FloatArray
    ramp: FloatArray

    @property
    def count(self) -> int:
        return self.last - self.first


@frozen
class Bend:
    """At `time` [s] the slopes of some lines change by `amount` [1/s], of the gains' shape."""

    time: float
    amount: FloatArray


@frozen
class Gains:
    """Gains of a group of voices during a frame; arrays of shape (n_voices, n_listeners), or
    (n_voices, n_listeners, 6) by band. A *line* is a gain before smoothing, see the module.

    start, end: the lines at the frame's start and end. slope, last_slope: their slopes there [1/s].
    bends: the latest first: that within the frame where lines arrive at 0, that at the frame's
    start, and those less than `SMOOTHING` before it.
    """

    start: FloatArray
    end: FloatArray
    slope: FloatArray
    last_slope: FloatArray
    bends: tuple[Bend, ...] = ()

    @classmethod
    def of_frame(
        cls,
        frame: FrameSamples,
        start: FloatArray,
        end: FloatArray,
        slope: FloatArray,
        bends: tuple[Bend, ...],
    ) -> Gains:
        """Return the gains whose lines go straight from `start` to `end` of a frame, and arrive
        there `SMOOTHING` earlier where that is 0.

        Args:
            frame: the frame.
            start: the lines at its start.
            end: the lines at its end, of the same shape.
            slope: of the lines at the end of the frame before [1/s].
            bends: less than `SMOOTHING` before the frame.
        """
        seconds = frame.end - frame.start
        if seconds < _INSTANT:
            return cls(end, end, np.zeros_like(end), np.zeros_like(end))
        now = (end - start) / seconds
        last = now
        closing = (end == 0.0) & (start != 0.0)
        if seconds > _CLOSING and closing.any():
            now = np.where(closing, now * (seconds / (seconds - SMOOTHING)), now)
            last = np.where(closing, 0.0, now)
            bends = (
                Bend(frame.end - SMOOTHING, last - now),
                Bend(frame.start, now - slope),
                *bends,
            )
        elif (now != slope).any():
            bends = (Bend(frame.start, now - slope), *bends)
        return cls(start, end, now, last, bends)

    def chosen(self, index: list[int]) -> Gains:
        """Return the gains of some voices."""
        bends = tuple(Bend(bend.time, bend.amount[index]) for bend in self.bends)
        return Gains(
            self.start[index], self.end[index], self.slope[index], self.last_slope[index], bends
        )

    def terms(self, frame: FrameSamples) -> tuple[FloatArray, list[FloatArray]]:
        """Return the gains in a frame as a sum of products: factors and curves over time.

        The factors have the shape (n_terms, n_voices, n_listeners, 1 or 6). Term by term there is a
        curve, shape (m,), for the frame's first m samples, and nothing after them, in order of
        falling m. The first curve is 1 throughout.
        """
        factors = [self.start]
        curves = [np.ones(frame.count)]
        if self.slope.any():
            factors = [
                self.start - self.slope * (SMOOTHING / 2.0),
                self.slope * (frame.end - frame.start),
            ]
            curves.append(frame.ramp)
        for bend in self.bends:
            affected = int(frame.times.searchsorted(bend.time + SMOOTHING))
            if bend.time > frame.start:
                factors.append(bend.amount)
                curves.append(_bent(frame.times - bend.time))
            elif affected:
                factors.append(bend.amount)
                curves.append(corner(frame.times[:affected] - bend.time))
        voices, listeners, *bands = self.start.shape
        return np.concatenate(factors).reshape(
            len(factors), voices, listeners, *(bands or (1,))
        ), curves

    def audible(self) -> BoolArray:
        """Return where a voice reaches a listener during the frame, shape (n_voices,
        n_listeners)."""
        return any_gain(self.start, self.end, *(bend.amount for bend in self.bends))

    def is_fading(self, voice: int, time: float) -> bool:
        """Return whether a voice whose lines have come to 0 is still heard after `time` [s], as
        smoothed gains lag behind."""
        return bool(
            self.last_slope[voice].any()
            or any(bend.amount[voice].any() for bend in self.bends_after(time))
        )

    def bends_after(self, time: float) -> tuple[Bend, ...]:
        """Return the bends that affect smoothed gains after `time` [s]."""
        return tuple(bend for bend in self.bends if bend.time > time - SMOOTHING)


def corner(since: FloatArray) -> FloatArray:
    """Return how far a smoothed line is from the straight line that it tends to, `since` 0 to
    `SMOOTHING` seconds after its slope has changed by 1."""
    left = SMOOTHING - since
    return left * left / (2.0 * SMOOTHING) - (SMOOTHING / (4.0 * np.pi**2)) * (
        1.0 - np.cos(2.0 * np.pi / SMOOTHING * since)
    )


def _bent(since: FloatArray) -> FloatArray:
    """Return a smoothed line of slope 0 before and 1 after a bend, `since` seconds after it: 0 up
    to the bend, straight from `SMOOTHING` seconds after it on."""
    return np.where(
        since > 0.0, since - SMOOTHING / 2.0 + corner(np.clip(since, 0.0, SMOOTHING)), 0.0
    )


def any_gain(*gains: FloatArray) -> BoolArray:
    """Return where any of some arrays of gains differs from 0, shape (n_voices, n_listeners)."""
    found = gains[0] != 0.0
    for more in gains[1:]:
        found |= more != 0.0
    return np.asarray(found if found.ndim == 2 else found.any(axis=2))
