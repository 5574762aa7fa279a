"""Warmth: heat conduction in the steady state.

Temperatures are excesses over the room's, in kelvin. Along an object they fall as along a long
plate that leaks into the air (the function "conduction"). At a contact, the heat flow through the
joint warms the next plate: with the joint's conductance ``h_c`` and the flux ``k m T`` that a long
plate draws, ``T2 / T1 = h_c / (h_c + k m)``. That is the closed form for a chain of long plates; of
several paths from a source the warmest counts, and the excesses of several sources add up, because
the equation is linear.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..declaration import Declared, number
from ..frozen import frozen
from ..scene.choices import Strategy
from ..scene.functions import Conduction
from .modality import Modality

JOINT = 500.0
"""Conductance of a dry joint between two bodies in contact, W/(m^2 K); that of rough solids is
between 100 and 10,000."""


def joint_gain(values: Mapping[str, float]) -> float:
    """Gain ``h_c / (h_c + k m)`` of a contact into an object with these ``values``, by property."""
    drawn = math.sqrt(2.0 * values["exchange"] * values["conductivity"] / values["thickness"])
    return JOINT / (JOINT + drawn)


@frozen
class Warmth(Declared):
    """The strength of a source of warmth."""

    value: float = number(
        60.0,
        "Temperature",
        "How much warmer than the room the source is, in K",
        -100.0,
        1000.0,
        unit="K",
    )


THERMAL = Modality(
    name="thermal",
    title="Warmth",
    description="Heat that is conducted through touching objects, in the steady state",
    functions=("conduction", "exponential", "linear", "constant", "expression"),
    values=Conduction,
    source=Warmth,
    strategy=Strategy.BEST_PATH,
    # Skin is at about 33 °C: in a room of 21 °C an object feels warm from 12 K above the room on;
    # from 45 °C on it hurts.
    sensations=(
        (0.5, "hardly warmer"),
        (4.0, "lukewarm"),
        (12.0, "warm"),
        (18.0, "hot"),
        (24.0, "burns"),
    ),
    transmission=joint_gain,
)
