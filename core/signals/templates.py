"""Predefined signals: the defaults, and those of impacts between materials."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from .base import Gain, Product, Signal, Sum
from .envelopes import Decay
from .impacts import DecayingSine, Impulse
from .noise import Noise
from .oscillators import Sine

DEFAULT_PERSISTENT: Signal = Sine(60.0)
DEFAULT_IMPACT: Signal = DecayingSine(150.0, 0.03)


@dataclass(frozen=True, slots=True)
class ImpactMaterial:
    """The response of a material to an impact.

    frequency: hertz, what it rings at, as far as skin can tell. decay: seconds, the ring's time constant.
    softness: seconds that it adds to the contact's duration (compliances in series add up).
    ring, grain: shares (0 to 1) of ringing and of crumbling noise.

    Measured: frequency and decay of wood and rubber and the frequency of metal, which are those of taps with a stylus on wood, rubber and
    aluminium (Okamura, Cutkosky and Dennerlein, "Reality-Based Models for Vibration Feedback in Virtual Environments", IEEE/ASME Trans.
    Mechatronics 6, 2001: 100 Hz and 80 1/s, 18.8 Hz and 60 1/s, 300 Hz; as they are commonly quoted). The decay of metal lies between
    that of the tap, damped by the hand (90 1/s), and that of a free body of steel (2.6 1/s at 300 Hz by the damping of the KleinPAT
    materials).
    Chosen: all else, so that hard and stiff rings high, what has much damping falls silent soon, and neighbours differ by a quarter in
    frequency or by half in decay, more than skin's difference thresholds. The taps' parameters that people found most real differed from
    the measured ones.
    """

    frequency: float
    decay: float
    softness: float
    ring: float
    grain: float = 0.0


IMPACT_MATERIALS: Mapping[str, ImpactMaterial] = MappingProxyType(
    {
        "stone": ImpactMaterial(320.0, 0.014, 0.0005, 0.8, 0.15),
        "concrete": ImpactMaterial(250.0, 0.010, 0.0006, 0.6, 0.20),
        "brick": ImpactMaterial(280.0, 0.006, 0.0008, 0.6, 0.25),
        "wood": ImpactMaterial(100.0, 0.0125, 0.0020, 0.9),  # measured
        "hardwood": ImpactMaterial(190.0, 0.028, 0.0012, 0.9),
        "metal": ImpactMaterial(300.0, 0.140, 0.0004, 1.0),  # frequency measured
        "glass": ImpactMaterial(560.0, 0.060, 0.0004, 0.9),
        "ceramic": ImpactMaterial(480.0, 0.030, 0.0004, 0.9),
        "plastic": ImpactMaterial(220.0, 0.012, 0.0020, 0.7),
        "rubber": ImpactMaterial(18.8, 0.0167, 0.0080, 0.8),  # measured
        "soil": ImpactMaterial(45.0, 0.010, 0.0100, 0.4, 0.30),
        "sand": ImpactMaterial(60.0, 0.006, 0.0120, 0.2, 0.60),
        "gravel": ImpactMaterial(110.0, 0.020, 0.0040, 0.3, 0.80),
        "fabric": ImpactMaterial(40.0, 0.008, 0.0120, 0.3, 0.15),
        "ribbon": ImpactMaterial(80.0, 0.008, 0.0100, 0.2, 0.10),
        "leather": ImpactMaterial(70.0, 0.012, 0.0060, 0.5, 0.05),
        "flesh": ImpactMaterial(30.0, 0.025, 0.0150, 0.6),
        "bone": ImpactMaterial(270.0, 0.018, 0.0010, 0.8),
        "ice": ImpactMaterial(380.0, 0.010, 0.0006, 0.7, 0.30),
        "water": ImpactMaterial(25.0, 0.060, 0.0200, 0.5, 0.20),
    }
)


# Materials without a template of their own, and the one that stands for them.
_KINDRED = {
    "steel": "metal",
    "aluminium": "metal",
    "brass": "metal",
    "lead": "metal",
    "plaster": "brick",
    "asphalt": "concrete",
    "softwood": "wood",
    "plywood": "wood",
    "cork": "rubber",
    "snow": "sand",
    "foam": "fabric",
    "paper": "fabric",
}


def impact_material(name: str) -> str | None:
    """The name in IMPACT_MATERIALS of a material of `core.materials`; None for air and unknown names."""
    known = _KINDRED.get(name, name)
    return known if known in IMPACT_MATERIALS else None


@lru_cache(maxsize=512)
def impact_template(first: str, second: str) -> Signal:
    """Return what is felt when two materials of IMPACT_MATERIALS hit each other, whichever hits; its largest sample is 1.

    A half-sine shock as long as the contact lasts, and each material's ring, weaker where its frequency is above what so long a contact
    excites (the envelope of a half-sine's spectrum, 1 / (1 + (2 f w)²)), and grain that dies away with the ring.
    Raises ValueError that names the argument.
    """
    for name, value in (("first", first), ("second", second)):
        if value not in IMPACT_MATERIALS:
            raise ValueError(f"{name}: {value!r} is not one of {', '.join(IMPACT_MATERIALS)}")
    materials = [IMPACT_MATERIALS[name] for name in sorted({first, second})]
    width = sum(IMPACT_MATERIALS[name].softness for name in (first, second))
    terms: list[Signal] = [Impulse(width)]
    for number, material in enumerate(materials):
        excited = 1.0 / (1.0 + (2.0 * material.frequency * width) ** 2)
        terms.append(DecayingSine(material.frequency, material.decay, material.ring * excited))
        if material.grain:
            terms.append(Product((Noise(material.grain, seed=number, rate=8.0 * material.frequency), Decay(material.decay))))
    total = Sum(tuple(terms))
    fine_rate = 48_000.0
    peak = float(np.max(np.abs(total.sample(0, int(total.duration * fine_rate) + 1, fine_rate))))
    return Gain(total, 1.0 / peak)
