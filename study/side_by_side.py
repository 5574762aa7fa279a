"""The ride with the paper's function and with measured materials, side by side.

No material is tuned: objects have the library's values, and impacts the templates of their
materials. All statements are measurements, whether or not they agree with the paper.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from ..core.arrays import FloatArray
from ..core.forms import JsonObject
from ..core.perception import are_felt_alike, are_felt_different
from ..core.scene.materials import MATERIALS
from ..core.scene.measured import physical
from ..core.scene.values import Mode
from ..core.signals.templates import impact_template
from .checks import HT, felt_anywhere, walls_felt
from .measures import loudness
from .rendition import MODES, Ride

TITLES: Mapping[str, str] = {
    "paper": "the paper's function",
    "physical": "measured materials",
}
"""Titles of `physical_scenes.WAYS`."""

_LIMB = (0.15, 0.15, 0.45)


def sensations(ride: Ride, mode: Mode = MODES[HT]) -> list[tuple[str, FloatArray]]:
    """By section: its title, and the highest margin (l,) [dB] of each listener in a mode."""
    margin = ride.renditions[mode].margin
    return [
        (title, margin[ride.rows(first, last)].max(axis=0))
        for _, title, first, last in ride.sections
    ]


def walls_apart(ride: Ride) -> list[tuple[str, FloatArray]]:
    """For each two kinds of walls, at every listener (l,) by how many decibels the first is felt
    more in HT, NaN where neither is; () without walls of both."""
    felt, _ = felt_anywhere(ride)
    mean = {name: np.mean(amplitudes, axis=0) for name, amplitudes in walls_felt(ride, HT).items()}
    with np.errstate(divide="ignore", invalid="ignore"):
        return [
            (
                f"{one} and {other}",
                np.where(felt[one] | felt[other], 20 * np.log10(mean[one] / mean[other]), np.nan),
            )
            for one, other in itertools.combinations(mean, 2)
        ]


def wall_verdict(difference: FloatArray, hertz: float) -> str:
    """Number of listeners (l,) at which most people notice a ``difference`` in decibels at
    ``hertz``, and at which few do; NaN where nothing is felt."""
    sizes = np.abs(difference[~np.isnan(difference)]).tolist()
    if not sizes:
        return "not felt"
    most = sum(are_felt_different(size, hertz) for size in sizes)
    few = sum(are_felt_alike(size, hertz) for size in sizes)
    return (
        f"{max(sizes):.1f} dB at most; most notice it at {most} of {len(sizes)} that feel "
        f"either, few at {few}"
    )


def felt_verdict(levels: FloatArray) -> str:
    """The strongest of the sensation levels (l,) [dB], and the number that are felt."""
    strongest = float(np.max(levels))
    return (
        f"{strongest:+.1f} dB; {int((levels > 0).sum())} of {len(levels)} felt"
        if math.isfinite(strongest)
        else "silent"
    )


def reasons() -> Iterator[str]:
    """The losses of materials and contacts, computed from the values of the ride."""
    losses = ", ".join(
        f"{name} {20 * math.log10(MATERIALS[name].k):.1f}"
        for name in ("stone", "steel", "hardwood", "flesh")
    )
    yield (
        "The paper's function takes a part of the signal in every body, whatever its size "
        f"({losses} dB, and more with distance). From a "
        "blow on the ground to a leg there are ground, rail, wheels, floor, seat and leg."
    )
    limb = physical("flesh", _LIMB, part="upper_leg")
    decays = ", ".join(
        f"{20 * math.log10(math.e) * limb.material_damping(hertz):.0f} dB/m at {hertz:g} Hz"
        for hertz in (31.25, 100, 250)
    )
    yield (
        f"A thigh of measured flesh damps {decays}: what skin feels best gets no further than "
        "where the body touches the cart."
    )
    plate = physical("stone", (0.35, 2.9, 1.57))
    lost = 20 * math.log10(math.e) * plate.material_damping(100) * 2.9
    yield (
        f"Measured walls lose {lost:.2g} dB of 100 Hz over their whole width: what they are "
        "made of can't be told from their damping."
    )
    blows = ", ".join(
        f"{first} on {second} {loudness(impact_template(first, second))[0]:+.1f} dB"
        for first, second in _BLOWS
    )
    yield (
        f"A blow of full scale lies above the threshold by: {blows}. Flesh is so soft that a "
        "blow lasts 15 to 27 ms whatever strikes it, "
        "which is a push below 50 Hz."
    )


_BLOWS = (
    ("stone", "stone"),
    ("wood", "flesh"),
    ("stone", "flesh"),
    ("ribbon", "flesh"),
    ("fabric", "flesh"),
)


def numbers(rides: Mapping[str, Ride]) -> JsonObject:
    """All results as JSON, with None for minus infinity and undefined values."""
    return {
        way: {
            "above_threshold": {title: _listed(levels) for title, levels in sensations(ride)},
            "walls": {pair: _listed(difference) for pair, difference in walls_apart(ride)},
        }
        for way, ride in rides.items()
    }


def _listed(values: FloatArray) -> list[float | None]:
    return [round(value, 2) if math.isfinite(value) else None for value in values.tolist()]
