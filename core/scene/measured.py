"""Measured loss factors and wave speeds of materials, with their ranges and sources, and the propagation function that follows from them.

Loss factors and speeds of metals: the tables of Cremer and Heckl as transcribed by Irvine, "Damping Properties of Materials" (2004).
Soil, sand and gravel: DIN 4150-1:2001 and DIN 45672-1:2009 (material damping and wave speeds of ground). Flesh: surface waves on skin,
doi 10.1117/1.1803843 and, for their 7 m/s, doi 10.1371/journal.pone.0031203; shear waves in muscle, PMC9631468. Concrete's loss factor:
EN 12354-1. What is built into a house loses 1 to 3 dB per metre at 150 to 3000 Hz (Acustica 2, 1952, "Absorption of structure-borne
sound in building materials"). Where no source is named the values are the usual ranges of Cremer, Heckl and Petersson, "Structure-Borne
Sound", and count as estimated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .functions import Physical, Wave
from .materials import MATERIALS

IN_A_BUILDING = 0.23
"""Attenuation of walls and floors in place, in 1/m: 2 dB/m, the middle of the measured range."""


@dataclass(frozen=True, slots=True)
class Damping:
    """Damping of vibration in a material. ``loss_factor`` with its ``loss_range``; ``speed`` of its waves [m/s] with its ``speed_range``:
    extensional waves, or shear and surface waves of what is soft or loose. ``ground``: lies on the ground, and its waves run along the
    surface. ``building``: walls and floors are made of it. ``estimated``: no published number is at hand."""

    loss_factor: float
    loss_range: tuple[float, float]
    speed: float
    speed_range: tuple[float, float]
    ground: bool = False
    building: bool = False
    estimated: bool = True


DAMPING: Mapping[str, Damping] = MappingProxyType(
    {
        "steel": Damping(2e-4, (2e-5, 3e-4), 5100, (5050, 5200), estimated=False),
        "aluminium": Damping(5e-5, (3e-6, 1e-4), 5200, (5000, 5200), estimated=False),
        "brass": Damping(5e-4, (2e-4, 1e-3), 3200, (3100, 3500), estimated=False),
        "lead": Damping(0.02, (0.02, 0.3), 1250, (1200, 1300), estimated=False),
        "stone": Damping(0.005, (0.001, 0.01), 4000, (3000, 5000)),
        "concrete": Damping(0.01, (0.004, 0.01), 3400, (3100, 3500), building=True, estimated=False),
        "brick": Damping(0.015, (0.01, 0.02), 2800, (2500, 3000), building=True),
        "plaster": Damping(0.008, (0.005, 0.01), 2250, (2000, 2500), building=True),
        "asphalt": Damping(0.3, (0.05, 0.4), 1900, (1500, 2200), ground=True),
        "ceramic": Damping(0.003, (0.002, 0.01), 5000, (4500, 5500)),
        "glass": Damping(0.001, (6e-4, 0.002), 5200, (5000, 5400)),
        "hardwood": Damping(0.012, (0.008, 0.02), 4100, (3800, 4500)),
        "softwood": Damping(0.01, (0.006, 0.015), 5000, (4500, 5500), building=True),
        "plywood": Damping(0.02, (0.01, 0.03), 3000, (2500, 3500), building=True),
        "plastic": Damping(0.04, (0.02, 0.1), 1800, (1400, 2200)),
        "rubber": Damping(0.15, (0.03, 1.0), 60, (40, 150)),
        "cork": Damping(0.15, (0.13, 0.17), 450, (430, 500)),
        "soil": Damping(0.06, (0.02, 0.1), 200, (100, 300), ground=True, estimated=False),
        "sand": Damping(0.09, (0.06, 0.12), 150, (100, 250), ground=True),
        "gravel": Damping(0.06, (0.04, 0.1), 300, (180, 500), ground=True),
        "ice": Damping(0.01, (0.005, 0.03), 3200, (3000, 3400)),
        "snow": Damping(0.1, (0.05, 0.2), 150, (50, 300), ground=True),
        "foam": Damping(0.2, (0.1, 0.3), 50, (30, 80)),
        "fabric": Damping(0.2, (0.1, 0.4), 60, (30, 120)),
        "ribbon": Damping(0.05, (0.03, 0.1), 1000, (500, 2000)),
        "leather": Damping(0.15, (0.1, 0.2), 350, (240, 470)),
        "paper": Damping(0.03, (0.02, 0.05), 1900, (1700, 2100)),
        "flesh": Damping(0.3, (0.14, 0.5), 7, (2.4, 9.7), estimated=False),
        "bone": Damping(0.02, (0.01, 0.03), 3500, (3000, 4000)),
        "water": Damping(1e-9, (5e-10, 5e-9), 1480, (1450, 1500)),
        "air": Damping(5e-5, (4e-5, 6e-5), 343, (331, 350)),
    }
)
"""By name of the library's materials."""

_THIN = 0.25
"""Of an extent to the next greater one: below this a body is a plate, or a rod."""


def wave_in(name: str, size: tuple[float, float, float]) -> tuple[Wave, float]:
    """How vibration travels in a body of a material with bounding box ``size`` [m], and its thickness [m]."""
    small, middle, large = sorted(size)
    if name == "flesh":
        return Wave.LIMB, small
    if DAMPING[name].ground and small < middle:
        return Wave.SURFACE, small
    if small < _THIN * middle:
        return Wave.PLATE, small
    return (Wave.ROD if middle < _THIN * large else Wave.SOLID), small


def physical(name: str, size: tuple[float, float, float], in_a_building: bool = False) -> Physical:
    """The propagation function of a body of a material of the library, from its bounding box ``size`` [m].

    ``in_a_building``: a wall or floor in place, whose edges and joints take what the material alone would pass on.
    """
    damping, material = DAMPING[name], MATERIALS[name]
    wave, thickness = wave_in(name, size)
    return Physical(
        wave=wave,
        loss_factor=damping.loss_factor,
        phase_speed=damping.speed,
        density=material.density,
        thickness=max(thickness, 1e-4),
        absorption=IN_A_BUILDING if in_a_building else 0.0,
        material_k=material.k,
        extent=max(max(size), 1e-3),
    )
