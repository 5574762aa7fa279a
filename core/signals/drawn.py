"""Drawn vibrations: curves of amplitude and frequency, with added short bursts."""

from __future__ import annotations

import math

import numpy as np

from ..declaration import Declared
from ..frozen import frozen
from .automation import Automation, parameter, ramp
from .base import Delay, Loop, Product, Signal, Sum
from .envelopes import Keyed
from .oscillators import Sine

LOWEST, HIGHEST = 65.0, 300.0
"""Frequencies of sharpness 0 and 1 of Core Haptics [Hz], between which frequency rises with the
square of sharpness."""
EMPHASIS_SECONDS = 0.02
"""Duration of an emphasis: that of a transient of Core Haptics."""


@frozen
class Emphasis(Declared):
    """A short burst at ``time`` seconds, of a ``strength`` and a ``sharpness`` from 0 to 1, like
    the transients of phones."""

    time: float
    strength: float = parameter(1.0, "Strength of the burst", 0.0, 1.0)
    sharpness: float = parameter(0.5, "Sharpness of the burst", 0.0, 1.0)

    def to_signal(self) -> Signal:
        """A sine of constant amplitude for `EMPHASIS_SECONDS`."""
        frequency = LOWEST + (HIGHEST - LOWEST) * self.sharpness**2
        return Delay(
            Sine(frequency) * Keyed(ramp(self.strength, self.strength, EMPHASIS_SECONDS)), self.time
        )


@frozen
class Drawing:
    """A sine whose amplitude (0 to 1) and frequency (hertz) are drawn over ``duration`` seconds,
    and bursts that are added to it.

    Endless if it loops. The phase is the integral of the frequency.
    """

    amplitude: Automation
    frequency: Automation
    duration: float = 1.0
    emphases: tuple[Emphasis, ...] = ()
    loops: bool = False

    def to_signal(self) -> Signal:
        """The drawing in the signal algebra, as readers of haptic clips return it. Raises
        ValueError for parameters beyond the limits of signals."""
        frequency, hertz = self.frequency, self.frequency.values
        sine = Sine(float(hertz[0]) if (hertz == hertz[0]).all() else frequency)
        parts = [
            sine * Keyed(cut(self.amplitude, self.duration)),
            *(emphasis.to_signal() for emphasis in self.emphases),
        ]
        signal = Sum(tuple(parts)) if len(parts) > 1 else parts[0]
        return Loop(signal) if self.loops else signal

    @staticmethod
    def of(signal: Signal | None) -> Drawing | None:
        """The drawing whose signal this is; None if it cannot be drawn."""
        loops = isinstance(signal, Loop) and (signal.count, signal.crossfade) == (None, 0.0)
        inner = signal.of if isinstance(signal, Loop) and loops else signal
        parts = inner.of if isinstance(inner, Sum) else (inner,)
        bursts = [_emphasis(part) for part in parts]
        emphases = tuple(burst for burst in bursts if burst is not None)
        end = max((part.duration for part in parts if part is not None), default=0.0)
        match [part for part, burst in zip(parts, bursts, strict=True) if burst is None]:
            case []:
                return Drawing(
                    Automation((0.0,), (0.0,)), Automation((0.0,), (HIGHEST,)), end, emphases, loops
                )
            case [
                Product(
                    of=(
                        Sine(frequency=hertz, amplitude=1.0, phase=0.0),
                        Keyed(automation=track) as keyed,
                    )
                )
            ]:
                if track.values.min() < 0.0 or track.values.max() > 1.0:
                    return None
                if keyed.duration < end:
                    track = Automation((*track.times, track.times[-1]), (*track.values, 0.0))
                frequency = hertz if isinstance(hertz, Automation) else Automation((0.0,), (hertz,))
                return Drawing(track, frequency, end, emphases, loops)
        return None


def _emphasis(part: Signal | None) -> Emphasis | None:
    """The emphasis whose signal this is, or None."""
    match part:
        case Delay(
            of=Product(
                of=(Sine(frequency=float(hertz), amplitude=1.0, phase=0.0), Keyed(automation=track))
            ),
            seconds=time,
        ):
            strength = float(track.values[0])
            plain = (
                math.isclose(track.times[-1], EMPHASIS_SECONDS, rel_tol=1e-9)
                and (track.values == strength).all()
            )
            if plain and LOWEST <= hertz <= HIGHEST and 0.0 <= strength <= 1.0:
                return Emphasis(
                    time, strength, float(np.sqrt((hertz - LOWEST) / (HIGHEST - LOWEST)))
                )
    return None


def cut(curve: Automation, duration: float) -> Automation:
    """The curve from 0 to ``duration`` seconds."""
    inside = (curve.times > 0.0) & (curve.times < duration)
    ends = curve.at(np.array([0.0, np.nextafter(duration, 0.0)]))
    times = curve.times[inside]
    values = curve.values[inside]
    return Automation(
        np.concatenate([[0.0], times, [duration]]), np.concatenate([ends[:1], values, ends[1:]])
    )
