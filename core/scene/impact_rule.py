"""Rules for impacts: their conditions and their signals."""

from __future__ import annotations

import enum
import math
import struct
from dataclasses import MISSING, field
from hashlib import blake2b
from typing import TYPE_CHECKING

from .. import signals
from ..declaration import Declared, check, number, numbers, part, share
from ..frozen import frozen

if TYPE_CHECKING:
    from ..signals import Signal


class ImpactTemplates(enum.StrEnum):
    """The signals that impacts play."""

    PLAIN = "plain"  # one template for all
    BY_MATERIAL = (
        "by_material"  # that of the two impact materials, the plain one if either is unknown
    )


TEMPLATES = {
    ImpactTemplates.BY_MATERIAL: (
        "By Material",
        "By the two materials: metal on stone rings, wood on soil thuds; plain if unknown",
    ),
    ImpactTemplates.PLAIN: ("Plain", "A short knock of 150 Hz, the same for all objects"),
}
Curve = tuple[float, float]
"""A value that depends on the strength of an impact: at the least and at the full energy."""
CURVES = ("gain", "pitch", "decay", "brightness")
"""The fields of a rule that are curves."""
LEAST_PITCH, MOST_PITCH, LEAST_DECAY = 0.25, 4.0, 0.01
QUIETEST = 1e-4
"""Least peak of a signal that is played once."""
_STEPS = 48
"""Pitches per octave, 1.5 % apart (a tenth of the skin's difference threshold), because recordings
need a kernel for each."""


def require_template(key: str, signal: Signal) -> None:
    """Raise ValueError that names ``key`` if impacts and triggers cannot play the signal."""
    if not signal.duration <= signals.LONGEST:
        raise ValueError(
            f"{key}: the signal of an impact or a trigger must end within {signals.LONGEST:g} "
            "seconds"
        )
    if not signal.peak >= QUIETEST:
        raise ValueError(f"{key}: the signal of an impact or a trigger must not be silent")


LEAST_ENERGY = number(
    MISSING,
    "Least Energy",
    "Collisions weaker than this, in joules, make no source; 0: 0.05 J, as in the paper 5 J",
    0.0,
    soft=(0.0, 100.0),
    unit="J",
    optional=True,
    shown=0.0,
).metadata
FULL_ENERGY = number(
    MISSING,
    "Full Energy",
    "A collision of this energy, in joules, plays the impact signal at full strength; 0: as "
    "strong a one as the heaviest body that moves makes in a fall of half a metre, as in the "
    "paper 100 J",
    0.0,
    soft=(0.0, 1000.0),
    unit="J",
    above=True,
    optional=True,
    shown=0.0,
).metadata
REFRACTORY = number(
    MISSING,
    "",
    "Time in seconds after an impact in which the same two objects make no further impact",
    0.0,
    unit="s",
).metadata


@frozen
class ImpactLimits(Declared):
    """Conditions of an impact: a new contact with at least ``least_energy`` (E_min) joules;
    ``full_energy`` (E_max) gives amplitude 1; None: those of the scene's kind of energy. A pair has
    no second impact within ``refractory`` seconds."""

    least_energy: float | None = field(default=None, metadata=LEAST_ENERGY)
    full_energy: float | None = field(default=None, metadata=FULL_ENERGY)
    refractory: float = field(default=0.1, metadata=REFRACTORY)


@frozen
class ImpactRule:
    """Signal of impacts: the ``template`` with amplitude ``gain``, modified by ``pitch``, ``decay``
    and ``brightness`` as in `Struck`. Each of these is weak + (full - weak) s at strength s =
    min(energy / E_max, 1). ``variation`` in [0, 1]: largest relative deviation of single impacts,
    drawn by ``seed``. ``limits``: None for those of the scene."""

    template: ImpactTemplates | Signal = part(
        ImpactTemplates.BY_MATERIAL,
        "template",
        "Signal that impacts play: by_material, plain, or a signal that ends",
    )
    gain: Curve = numbers(
        (0.0, 1.0),
        "Gain",
        "Amplitude of the weakest collisions, and of those of full energy",
        2,
        0.0,
        1.0,
    )
    pitch: Curve = numbers(
        (1.0, 1.0),
        "",
        "How many times as fast the signal plays in the weakest collisions, and in those of "
        "full energy",
        2,
        LEAST_PITCH,
        MOST_PITCH,
    )
    decay: Curve = numbers(
        (1.0, 1.0),
        "",
        "Part of its decay time that the signal has in the weakest collisions, and in those "
        "of full energy",
        2,
        LEAST_DECAY,
        1.0,
    )
    brightness: Curve = numbers(
        (1.0, 1.0),
        "Brightness",
        "Gain above 100 Hz in the weakest collisions, and in those of full energy",
        2,
        0.0,
        1.0,
    )
    variation: float = share(
        0.0,
        "Variation",
        "Largest relative variation of impacts: higher or lower, shorter and weaker",
        soft=(0.0, 0.3),
    )
    seed: int = number(0, "", "Another number gives other variations", 0, 10**9, whole=True)
    limits: ImpactLimits | None = part(
        None, "impact_limits", "Limits of these impacts; default: those of the scene's rules"
    )

    def __post_init__(self) -> None:
        if isinstance(self.template, signals.Signal):
            require_template("template", self.template)
        else:
            object.__setattr__(self, "template", ImpactTemplates(self.template))
        check(self)

    @property
    def slowest(self) -> float:
        """The least pitch of any impact."""
        return max(min(self.pitch) * (1.0 - self.variation), LEAST_PITCH)

    def played(
        self, template: Signal, energy: float, names: tuple[str, str], onset: float
    ) -> tuple[Signal, float]:
        """The signal and the amplitude of an impact between two objects at ``onset`` [s];
        ``energy``: fraction of the full energy, at most 1."""
        gain, pitch, decay, brightness = (
            weak + (full - weak) * energy for weak, full in (getattr(self, key) for key in CURVES)
        )
        higher, shorter, weaker = (
            _chances(self.seed, names, onset) if self.variation else (0.5, 0.0, 0.0)
        )
        pitch *= 1.0 + self.variation * (2.0 * higher - 1.0)
        decay *= 1.0 - self.variation * shorter
        amplitude = gain * (1.0 - self.variation * weaker)
        if pitch == decay == brightness == 1.0:
            return template, amplitude
        step = round(_STEPS * math.log2(min(max(pitch, LEAST_PITCH), MOST_PITCH)))
        return signals.Struck(
            template, 2.0 ** (step / _STEPS), max(decay, LEAST_DECAY), brightness
        ), amplitude


def _chances(seed: int, names: tuple[str, str], onset: float) -> tuple[float, float, float]:
    """Three pseudo-random numbers in [0, 1] that depend only on the arguments, so that an impact is
    the same in every rendering."""
    first, second = sorted(names)
    text = f"{seed}\0{first}\0{second}\0{round(1000.0 * onset)}"
    a, b, c = (
        number / (2**32 - 1)
        for number in struct.unpack("<3I", blake2b(text.encode(), digest_size=12).digest())
    )
    return a, b, c
