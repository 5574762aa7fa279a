"""Measured loss factors and wave speeds of materials, with their ranges and sources, and the
propagation function that follows from them.

Loss factors and speeds of metals: the tables of Cremer and Heckl as transcribed by Irvine, "Damping
Properties of Materials" (2004). Soil, sand and gravel: DIN 4150-1:2001 and DIN 45672-1:2009
(material damping and wave speeds of ground). Flesh: surface waves on skin, doi 10.1117/1.1803843
and, for their 7 m/s, doi 10.1371/journal.pone.0031203; shear waves in muscle, PMC9631468.
Concrete's loss factor: EN 12354-1. Building elements in place lose 1 to 3 dB per metre at 150 to
3000 Hz (Acustica 2, 1952, "Absorption of structure-borne sound in building materials"). Values
without a source are the usual ranges of Cremer, Heckl and Petersson, "Structure-Borne Sound", and
count as estimated.

Parts of a body move as a whole up to their resonances: ankle 16 to 39 Hz, midfoot 51 to 84, toes 99
to 147 (Goggins, 24 places of the foot of 21 people, wbldb.lievers.net/10176750; ankle 25 to 30 Hz,
metatarsals 50 Hz, doi 10.3233/OER-160236), knee 20 to 30 Hz, where platforms amplify, while little
arrives at the hip (doi 10.3390/app14209516), elbow 8 Hz (Marchetti and others, Int. J. Ind. Ergon.
62, 2017), fingertip 200 Hz (Lundström, J. Biomech. 17, 1984). Cited from memory, without access to
a curve: wrist 20 to 40 Hz and shoulder 10 Hz (doi 10.1016/j.jsv.2010.02.001), head and trunk 4 to 6
Hz, with a transmissibility of 0.5 to 0.7 at 15 to 20 Hz; above the resonances, at most 0.2 at the
elbow from 100 Hz and 0.1 at the shoulder from 50 Hz. A whole body in one mesh has the resonance and
speed that give the loss of its parts along the way from sole to crown, with the heights of the
joints of Drillis and Contini (1966).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from ..frozen import frozen
from .functions import Physical, Resilient, Wave
from .functions.physical import BOUNDS_OF_K
from .materials import MATERIALS, TABLE

IN_A_BUILDING = 0.23
"""Attenuation of walls and floors in place, in 1/m: 2 dB/m, the middle of the measured range."""


@frozen
class Damping:
    """Damping of vibration in a material. ``loss_factor`` with its ``loss_range``; ``speed`` of its
    waves [m/s] with its ``speed_range``: extensional waves, or shear and surface waves in soft or
    loose materials. ``ground``: a ground material, in which waves travel along the surface.
    ``estimated``: without a published value."""

    loss_factor: float
    loss_range: Sequence[float]
    speed: float
    speed_range: Sequence[float]
    ground: bool = False
    estimated: bool = True


DAMPING: Mapping[str, Damping] = MappingProxyType(
    {name: Damping(**row["damping"]) for name, row in TABLE.items() if "damping" in row}
)
"""Damping by the names of the library's materials, but for springs."""


@frozen
class Spring:
    """A spring: ``stiffness`` [N/m] of the whole, or ``modulus`` [Pa] of a layer, whose stiffness
    follows from area and thickness; ``loss_factor``."""

    loss_factor: float
    stiffness: float = 0.0
    modulus: float = 0.0


SPRINGS: Mapping[str, Spring] = MappingProxyType(
    {name: Spring(**row["spring"]) for name, row in TABLE.items() if "spring" in row}
)
"""Springs by the names of the library's materials. Their values are of the usual ranges, and
estimates: tyres of cars 150 to 250 kN/m, springs of their suspensions 15 to 30, engine mounts 100
to 400; rubber of 50 Shore A 2.5 MPa, midsoles of shoes 1 to 3, felt and carpet 0.2 to 1, foam of
seats 20 to 60 kPa, of mattresses 5 to 20."""

_LIMBS = json.loads(Path(__file__).with_name("limbs.json").read_text("utf-8"))
LIMBS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {part: (row["resonance"], row["speed"]) for part, row in _LIMBS.items()}
)
"""By body part: the resonance [Hz] up to which it moves as a whole, and the wave speed [m/s] fitted
to the loss above it."""

SKIN = 0.005
"""Largest thickness of flesh that counts as skin [m]; also the radius of the area of skin that a
small actuator excites."""

_LONGEST_PART = 1.0
"""Length [m] above which flesh that is not named after a part is a whole body."""


def physical(
    name: str,
    size: tuple[float, float, float],
    in_a_building: bool = False,
    part: str = "",
    is_half_space: bool = False,
    volume: float = 0.0,
) -> Physical:
    """The propagation function of a body of a material of the library.

    Args:
        name: of the material.
        size: its three sizes [m] in any order: those of its bounding box, the least of them that of
            the wall if the body is hollow.
        in_a_building: it is a wall or floor in place, whose edges and joints add attenuation.
        part: the body part, without its side, if it is of flesh.
        is_half_space: waves travel along its surface without end, as in materials of the ground.
        volume: [m^3]; 0: the product of its sizes.
    """
    damping = DAMPING[name]
    material = MATERIALS[name]
    small, middle, large = sorted(size)
    function = Physical(
        wave=Wave.BOUNDED,
        loss_factor=damping.loss_factor,
        phase_speed=damping.speed,
        density=material.density,
        thickness=max(small, 1e-4),
        absorption=IN_A_BUILDING if in_a_building else 0.0,
        material_k=min(max(material.k, BOUNDS_OF_K[0]), BOUNDS_OF_K[1]),
        extent=max(middle, 1e-3),
    )
    if name == "flesh":
        function = replace(function, extent=max(large, 1e-3))
    width = function.extent * function.thickness
    function = replace(function, length=(volume or small * middle * large) / width)
    if name == "flesh":
        if small <= SKIN:
            return replace(function, wave=Wave.SURFACE, reference_distance=SKIN)
        part = part or ("body" if large > _LONGEST_PART else "")
        resonance, speed = LIMBS.get(part, (function.resonance, function.phase_speed))
        return replace(function, wave=Wave.LIMB, resonance=resonance, phase_speed=speed)
    return (
        replace(function, wave=Wave.SURFACE, extent=0.0)
        if damping.ground or is_half_space
        else function
    )


def function_of(
    name: str,
    size: tuple[float, float, float],
    in_a_building: bool = False,
    part: str = "",
    is_half_space: bool = False,
    volume: float = 0.0,
) -> Physical | Resilient:
    """The function of a body of a material of the library: of a spring that, else `physical`, as
    whose arguments these are."""
    spring = SPRINGS.get(name)
    if spring is None:
        return physical(name, size, in_a_building, part, is_half_space, volume)
    thickness = max(min(size), 1e-4)
    layer = spring.modulus * (volume or math.prod(size)) / thickness**2
    return Resilient(stiffness=spring.stiffness or layer or 1.0, loss_factor=spring.loss_factor)


def felt_all_over(size: tuple[float, float, float]) -> Physical:
    """The function of a body of flesh that feels all over what shakes any part of it: at every
    frequency the attenuation that the library chooses for flesh at 100 Hz, 5 dB per metre. A design
    choice: a measured body feels a floor at its feet only."""
    return replace(
        physical("flesh", size), loss_factor=0.0, absorption=MATERIALS["flesh"].absorption
    )
