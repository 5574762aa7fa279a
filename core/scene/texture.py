"""Textures: the signals of objects that slide or roll on each other.

Fundamental: speed over spatial period, as measured at the wrist (Delhaye et al., Front. Behav. Neurosci. 6, 2012). Levels: of dry sliding
surfaces the power 3/4 of the speed ("Influence of sliding speed on roughness noise", 2019), of rolling wheels 30 lg v (Thompson, "Railway
Noise and Vibration", 2009). The power of the force is chosen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .. import signals

if TYPE_CHECKING:
    from ..signals import Signal

OF_FORCE, OF_SLIDING, OF_ROLLING = 0.5, 0.75, 1.5
"""Powers of force and speed in the amplitude."""

RANGES = {
    "period": (1e-5, 10.0),
    "sliding": (0.0, 1.0),
    "rolling": (0.0, 1.0),
    "noise": (0.0, 1.0),
    "bandwidth": (0.05, 4.0),
    "stick_speed": (0.0, 100.0),
    "full_force": (1e-3, 1e9),
    "full_speed": (1e-3, 1e3),
}
"""Ranges of a texture's values."""

_ROUNDING = 1e-9
"""Seconds by which a piece ends early, so that nothing of it remains in the following frame."""
_AS_STRONG = 1.5 * math.sqrt(2.0)
"""Amplitude of interpolated uniform noise whose product with a sine has the power of the sine."""


@dataclass(frozen=True, slots=True)
class Texture:
    """The texture of two surfaces: at v m/s they emit a tone of v / ``period`` hertz.

    ``period`` [m]: distance of ridges or grains. ``noise`` in [0, 1]: fraction of the power in a band of noise around the tone, as wide as
    ``bandwidth`` times its frequency, but at least the frame rate. Below ``stick_speed`` [m/s] they stick and slip: the slower, the more
    the sine changes to a sawtooth. The amplitude is ``sliding`` (F / ``full_force``)^(1/2) (v / ``full_speed``)^(3/4) where they slide, and
    ``rolling`` (F / full_force)^(1/2) (v / full_speed)^(3/2) where they roll, with F newtons between them; at most sliding or rolling.
    """

    period: float = 0.005
    sliding: float = 0.5
    rolling: float = 0.2
    noise: float = 0.5
    bandwidth: float = 0.5
    stick_speed: float = 0.0
    full_force: float = 100.0
    full_speed: float = 1.0

    def __post_init__(self) -> None:
        for key, (low, high) in RANGES.items():
            if not low <= getattr(self, key) <= high:
                raise ValueError(f"{key}: must be from {low:g} to {high:g}, got {getattr(self, key)!r}")

    def amplitude(self, speed: float, force: float, rolls: bool) -> float:
        """Amplitude at a speed [m/s] and a force [N]; NaN, an unknown force, counts as the full force."""
        if not speed < self.period * signals.MAX_FREQUENCY:
            return 0.0
        most, power = (self.rolling, OF_ROLLING) if rolls else (self.sliding, OF_SLIDING)
        pressed = 1.0 if math.isnan(force) else force / self.full_force
        return most * min(math.pow(pressed, OF_FORCE) * math.pow(speed / self.full_speed, power), 1.0)

    def piece(self, speed: float, cycles: float, step: float, seed: int) -> Signal:
        """The signal at constant ``speed`` over two frames of ``step`` seconds, with the phase ``cycles`` in the middle. It fades in over
        one frame and out over the other, so that overlapping pieces of consecutive frames add up to one signal."""
        frequency = speed / self.period
        phase = cycles - frequency * step
        phase -= math.floor(phase)
        sticks = max(1.0 - speed / self.stick_speed, 0.0) if self.stick_speed else 0.0
        # The squares of sine and cosine add up to one: the amplitudes of the coherent tone and the powers of the incoherent noises.
        fades = signals.Sine(0.25 / step)
        parts: list[Signal] = []
        for part, wave, shift in ((1.0 - sticks, signals.Sine, 0.0), (sticks, signals.Saw, 0.5)):  # both rise through 0 at the same time
            if part and self.noise < 1.0:
                parts.append(signals.Product((fades, wave(frequency, part * math.sqrt(1.0 - self.noise), phase + shift))))
        if self.noise:
            rate = min(max(self.bandwidth * frequency, 1.0), signals.MAX_FREQUENCY)
            tone = signals.Sine(frequency, _AS_STRONG * math.sqrt(self.noise), phase)
            parts.append(signals.Product((tone, signals.Noise(seed=seed, rate=rate))))
        gate = signals.Constant(1.0, 2.0 * step - _ROUNDING)
        return signals.Product((gate, fades, parts[0] if len(parts) == 1 else signals.Sum(tuple(parts))))
