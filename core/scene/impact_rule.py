"""Rules for impacts: their conditions and their signals."""

from __future__ import annotations

import enum
import math
import struct
from dataclasses import dataclass
from hashlib import blake2b
from typing import TYPE_CHECKING

from .. import signals
from .functions.modulation import require

if TYPE_CHECKING:
    from ..signals import Signal


class ImpactTemplates(enum.StrEnum):
    """The signals that impacts play."""

    PLAIN = "plain"  # one template for all
    BY_MATERIAL = "by_material"  # that of the two impact materials, the plain one if either is unknown


Curve = tuple[float, float]
"""A value that depends on the strength of an impact: at the least and at the full energy."""

RANGES = {"gain": (0.0, 1.0), "pitch": (0.25, 4.0), "decay": (0.01, 1.0), "brightness": (0.0, 1.0)}
"""Ranges of the curves' values."""
BENDS = (0.1, 10.0)
QUIETEST = 1e-4
"""Least peak of a signal that is played once."""
_STEPS = 48
"""Pitches per octave, 1.5 % apart (a tenth of the skin's difference threshold), because recordings need a kernel for each."""


def require_template(key: str, signal: Signal) -> None:
    """Raise ValueError that names ``key`` if impacts and triggers cannot play the signal."""
    if not signal.duration <= signals.LONGEST:
        raise ValueError(f"{key}: the signal of an impact or a trigger must end within {signals.LONGEST:g} seconds")
    if not signal.peak >= QUIETEST:
        raise ValueError(f"{key}: the signal of an impact or a trigger must not be silent")


@dataclass(frozen=True, slots=True)
class ImpactLimits:
    """Conditions of an impact: a new contact with at least ``least_energy`` (E_min) joules; ``full_energy`` (E_max) gives amplitude 1. A
    pair has no second impact within ``refractory`` seconds."""

    least_energy: float = 5.0
    full_energy: float = 100.0
    refractory: float = 0.1

    def __post_init__(self) -> None:
        for key in ("least_energy", "refractory"):
            require(key, getattr(self, key))
        if not 0 < self.full_energy < math.inf:
            raise ValueError(f"full_energy: must be finite and > 0, got {self.full_energy!r}")


@dataclass(frozen=True, slots=True)
class ImpactRule:
    """Signal of impacts: the ``template`` with amplitude ``gain``, modified by ``pitch``, ``decay`` and ``brightness`` as in `Struck`.
    Each of these is weak + (full - weak) s at strength s = min(energy / E_max, 1)^``bend``. ``variation`` in [0, 1]: largest relative
    deviation of single impacts, drawn by ``seed``. ``limits``: None for those of the scene."""

    template: ImpactTemplates | Signal = ImpactTemplates.BY_MATERIAL
    gain: Curve = (0.0, 1.0)
    pitch: Curve = (1.0, 1.0)
    decay: Curve = (1.0, 1.0)
    brightness: Curve = (1.0, 1.0)
    bend: float = 1.0
    variation: float = 0.0
    seed: int = 0
    limits: ImpactLimits | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.template, signals.Signal):
            object.__setattr__(self, "template", ImpactTemplates(self.template))
        else:
            require_template("template", self.template)
        for key, (low, high) in {**RANGES, "bend": BENDS, "variation": (0.0, 1.0)}.items():
            values = getattr(self, key) if key in RANGES else (getattr(self, key),)
            if not all(low <= value <= high for value in values):
                raise ValueError(f"{key}: must be from {low:g} to {high:g}, got {getattr(self, key)!r}")

    @property
    def slowest(self) -> float:
        """The least pitch of any impact."""
        return max(min(self.pitch) * (1.0 - self.variation), RANGES["pitch"][0])

    def played(self, template: Signal, energy: float, names: tuple[str, str], onset: float) -> tuple[Signal, float]:
        """The signal and the amplitude of an impact between two objects at ``onset`` [s]; ``energy``: fraction of the full energy, at most
        1."""
        strength = energy**self.bend
        gain, pitch, decay, brightness = (weak + (full - weak) * strength for weak, full in (getattr(self, key) for key in RANGES))
        higher, shorter, weaker = _chances(self.seed, names, onset) if self.variation else (0.5, 0.0, 0.0)
        pitch *= 1.0 + self.variation * (2.0 * higher - 1.0)
        decay *= 1.0 - self.variation * shorter
        amplitude = gain * (1.0 - self.variation * weaker)
        if pitch == decay == brightness == 1.0:
            return template, amplitude
        low, high = RANGES["pitch"]
        step = round(_STEPS * math.log2(min(max(pitch, low), high)))
        return signals.Struck(template, 2.0 ** (step / _STEPS), max(decay, RANGES["decay"][0]), brightness), amplitude


def _chances(seed: int, names: tuple[str, str], onset: float) -> tuple[float, float, float]:
    """Three pseudo-random numbers in [0, 1] that depend only on the arguments, so that an impact is the same in every rendering."""
    first, second = sorted(names)
    text = f"{seed}\0{first}\0{second}\0{round(1000.0 * onset)}"
    a, b, c = (number / (2**32 - 1) for number in struct.unpack("<3I", blake2b(text.encode(), digest_size=12).digest()))
    return a, b, c
