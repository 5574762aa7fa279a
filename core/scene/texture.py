"""Textures: the signals of objects that slide or roll on each other.

Fundamental: speed over spatial period, as measured at the wrist (Delhaye et al., Front. Behav.
Neurosci. 6, 2012). Levels: of dry sliding surfaces the power 3/4 of the speed ("Influence of
sliding speed on roughness noise", 2019), of rolling wheels 30 lg v (Thompson, "Railway Noise and
Vibration", 2009). The power of the force is chosen.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .. import signals
from ..declaration import Declared, number, share
from ..frozen import frozen

if TYPE_CHECKING:
    from ..signals import Signal

OF_FORCE, OF_SLIDING, OF_ROLLING = 0.5, 0.75, 1.5
"""Powers of force and speed in the amplitude."""

_ROUNDING = 1e-9
"""Seconds by which a piece ends early, so that nothing of it remains in the following frame."""
_AS_STRONG = 1.5 * math.sqrt(2.0)
"""Amplitude of interpolated uniform noise whose product with a sine has the power of the sine."""


@frozen
class Texture(Declared):
    """The texture of two surfaces: at v m/s they emit a tone of v / ``period`` hertz.

    ``period`` [m]: distance of ridges or grains. ``noise`` in [0, 1]: fraction of the power in a
    band of noise around the tone, as wide as ``bandwidth`` times its frequency, but at least the
    frame rate. Below ``stick_speed`` [m/s] they stick and slip: the slower, the more the sine
    changes to a sawtooth. The amplitude is ``sliding`` (F / ``full_force``)^(1/2) (v /
    ``full_speed``)^(3/4) where they slide, and ``rolling`` (F / full_force)^(1/2) (v /
    full_speed)^(3/2) where they roll, with F newtons between them; at most sliding or rolling.
    """

    period: float = number(
        0.005,
        "Period",
        "From one ridge or grain of the surface to the next: at 1 m/s, 5 mm give 200 Hz",
        1e-5,
        10.0,
        unit="m",
        digits=4,
    )
    sliding: float = share(0.5, "Sliding", "Amplitude of sliding at full force and speed")
    rolling: float = share(0.2, "Rolling", "Amplitude of rolling at full force and speed")
    noise: float = share(
        0.5,
        "Noise",
        "Fraction of the power that is noise around the tone; higher for irregular surfaces",
    )
    bandwidth: float = number(
        0.5, "Bandwidth", "How wide the noise is, relative to the frequency of the tone", 0.05, 4.0
    )
    stick_speed: float = number(
        0.0,
        "Stick Below",
        "Below this speed the surfaces stick and slip, the slower the more; 0: they do not",
        0.0,
        100.0,
        unit="m/s",
        digits=3,
    )
    full_force: float = number(
        100.0,
        "Full Force",
        "Force in newtons at which the amplitude reaches its full value; it grows with the "
        "square root of the force",
        1e-3,
        1e9,
        soft=(1e-3, 1e4),
        unit="N",
    )
    full_speed: float = number(
        1.0,
        "Full Speed",
        "Speed at which the amplitude reaches its full value; it grows with the speed to the "
        "power 3/4 for sliding, 3/2 for rolling",
        1e-3,
        1e3,
        unit="m/s",
    )

    def amplitude(self, speed: float, force: float, rolls: bool) -> float:
        """Amplitude at a speed [m/s] and a force [N]; NaN, an unknown force, counts as the full
        force."""
        if not speed < self.period * signals.MAX_FREQUENCY:
            return 0.0
        most, power = (self.rolling, OF_ROLLING) if rolls else (self.sliding, OF_SLIDING)
        pressed = 1.0 if math.isnan(force) else force / self.full_force
        return most * min(
            math.pow(pressed, OF_FORCE) * math.pow(speed / self.full_speed, power), 1.0
        )

    def piece(self, speed: float, cycles: float, step: float, seed: int) -> Signal:
        """The signal at constant ``speed`` over two frames of ``step`` seconds, with the phase
        ``cycles`` in the middle. It fades in over one frame and out over the other, so that
        overlapping pieces of consecutive frames add up to one signal."""
        frequency = speed / self.period
        phase = cycles - frequency * step
        phase -= math.floor(phase)
        sticks = max(1.0 - speed / self.stick_speed, 0.0) if self.stick_speed else 0.0
        # The squares of sine and cosine add up to one: the amplitudes of the coherent tone and the
        # powers of the incoherent noises.
        fades = signals.Sine(0.25 / step)
        parts: list[Signal] = []
        # Both rise through 0 at the same time.
        for part, wave, shift in ((1.0 - sticks, signals.Sine, 0.0), (sticks, signals.Saw, 0.5)):
            if part and self.noise < 1.0:
                parts.append(
                    signals.Product(
                        (fades, wave(frequency, part * math.sqrt(1.0 - self.noise), phase + shift))
                    )
                )
        if self.noise:
            rate = min(max(self.bandwidth * frequency, 1.0), signals.MAX_FREQUENCY)
            tone = signals.Sine(frequency, _AS_STRONG * math.sqrt(self.noise), phase)
            parts.append(signals.Product((tone, signals.Noise(seed=seed, rate=rate))))
        gate = signals.Constant(1.0, 2.0 * step - _ROUNDING)
        return signals.Product(
            (gate, fades, parts[0] if len(parts) == 1 else signals.Sum(tuple(parts)))
        )
