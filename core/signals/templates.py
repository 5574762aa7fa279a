"""Predefined signals: the defaults, and those of impacts between materials, whose values are in
`impact_materials.json`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ..frozen import frozen
from .base import Gain, Product, Signal, Sum
from .envelopes import Decay
from .impacts import DecayingSine, Impulse
from .noise import Noise
from .oscillators import Sine

DEFAULT_PERSISTENT: Signal = Sine(60.0)
DEFAULT_IMPACT: Signal = DecayingSine(150.0, 0.03)


@frozen
class ImpactMaterial:
    """The response of a material to an impact.

    frequency: hertz, of its ringing within the tactile range. decay: seconds, time constant of the
    ringing. softness: seconds that it adds to the contact's duration (compliances in series add
    up). ring, grain: shares (0 to 1) of ringing and of crumbling noise.

    Measured: frequency and decay of wood and rubber and the frequency of metal, which are those of
    taps with a stylus on wood, rubber and aluminium (Okamura, Cutkosky and Dennerlein,
    "Reality-Based Models for Vibration Feedback in Virtual Environments", IEEE/ASME Trans.
    Mechatronics 6, 2001: 100 Hz and 80 1/s, 18.8 Hz and 60 1/s, 300 Hz; as they are commonly
    quoted). The decay of metal lies between that of the tap, damped by the hand (90 1/s), and that
    of a free body of steel (2.6 1/s at 300 Hz by the damping of the KleinPAT materials). Chosen:
    all else, so that hard and stiff materials have high frequencies, strongly damped ones short
    decays, and neighbours differ by a quarter in frequency or by half in decay, more than the
    skin's difference thresholds. In that study, the parameters rated most realistic differed from
    the measured ones.
    """

    frequency: float
    decay: float
    softness: float
    ring: float
    grain: float = 0.0


_TABLE = json.loads(Path(__file__).with_name("impact_materials.json").read_text("utf-8"))
_MATERIALS = {name: ImpactMaterial(**row) for name, row in _TABLE["materials"].items()}
IMPACT_MATERIALS: Mapping[str, ImpactMaterial] = MappingProxyType(_MATERIALS)


def impact_material(name: str) -> str | None:
    """The name in IMPACT_MATERIALS for a material of `core.scene.materials`, its own or a similar
    one; None for air and unknown names."""
    known = str(_TABLE["kindred"].get(name, name))
    return known if known in IMPACT_MATERIALS else None


@lru_cache(maxsize=512)
def impact_template(first: str, second: str) -> Signal:
    """Return the signal of an impact between two materials of IMPACT_MATERIALS, in either order;
    its largest sample is 1.

    The sum of a half-sine shock with the duration of the contact, of each material's ringing,
    attenuated by the envelope of the half-sine's spectrum, 1 / (1 + (2 f w)²), and of grain that
    decays with the ringing. Raises ValueError that names the argument.
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
            terms.append(
                Product(
                    (
                        Noise(material.grain, seed=number, rate=8.0 * material.frequency),
                        Decay(material.decay),
                    )
                )
            )
    total = Sum(tuple(terms))
    fine_rate = 48_000.0
    peak = float(np.max(np.abs(total.sample(0, int(total.duration * fine_rate) + 1, fine_rate))))
    return Gain(total, 1.0 / peak)
