"""Named materials: what things are made of, and how that passes haptic signals on.

Measured, from the tables named below: ``density``, ``wave_speed``, ``conductivity``, and, to an order of magnitude, ``loss_factor``.
Chosen by design: ``kappa`` and ``rho``, which are the paper's coefficients and no quantities of physics (only ``(1 - kappa) rho`` counts),
so that neighbours differ by more than the skin's difference threshold; and ``absorption`` where no wave speed decides it.

Wave speeds of solids are those of extensional waves in rods: CRC Handbook of Chemistry and Physics, "Speed of Sound in Various Media"; of
building materials, cork, rubber and wood along the grain: The Engineering ToolBox, "Speed of Sound in common Solids". Thermal
conductivities and densities: EN ISO 10456, CIBSE Guide A tables 3.36 and 3.37; rocks: CRC Handbook. Loss factors: the usual values of
Cremer, Heckl and Petersson, "Structure-Borne Sound"; they vary by a factor of 2 to 10 between specimens. Loose soil and sand: shear waves
near the surface.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .bands import BAND_CENTRES
from .coefficients import transfer_coefficient

_REFERENCE = 100.0
"""The frequency of ``absorption``, in hertz."""


@dataclass(frozen=True, slots=True)
class Material:
    """What a thing is made of.

    name: as files and properties say it. title: as menus say it. kappa, rho: the paper's coefficients, in [0, 1].
    density: kg/m^3. wave_speed: m/s, 0 where what is felt has no one speed. absorption: extra attenuation at 100 Hz, in 1/m.
    conductivity: of heat, in W/(m K). words: names of the matter, things: of what is mostly made of it, in lower case.
    """

    name: str
    title: str
    kappa: float
    rho: float
    density: float
    wave_speed: float
    absorption: float
    conductivity: float
    words: tuple[str, ...] = ()
    things: tuple[str, ...] = ()

    @property
    def k(self) -> float:
        """The transfer coefficient, the one number of the two that the paper's function depends on."""
        return transfer_coefficient(self.kappa, self.rho)

    @property
    def band_decays(self) -> tuple[float, ...]:
        """Extra attenuation in each frequency band, in 1/m: proportional to frequency, as a constant loss factor makes it."""
        return tuple(self.absorption * centre / _REFERENCE for centre in BAND_CENTRES)


def absorption(loss_factor: float, wave_speed: float) -> float:
    """Attenuation of a plane wave at 100 Hz in 1/m: ``pi f eta / c`` (amplitude; from the complex wave number ``k (1 - i eta / 2)``)."""
    return math.pi * _REFERENCE * loss_factor / wave_speed


def _solid(
    title: str, kappa: float, rho: float, density: float, speed: float, loss_factor: float, conductivity: float, words: str
) -> Material:
    """Measured wave speed and loss factor."""
    return _named(title, kappa, rho, density, speed, absorption(loss_factor, speed), conductivity, words)


def _soft(title: str, kappa: float, rho: float, density: float, chosen: float, conductivity: float, words: str) -> Material:
    """No one wave speed: the absorption at 100 Hz is ``chosen``."""
    return _named(title, kappa, rho, density, 0.0, chosen, conductivity, words)


def _named(
    title: str, kappa: float, rho: float, density: float, speed: float, absorbed: float, conductivity: float, words: str
) -> Material:
    name = title.lower().replace(" ", "_")
    matter, _, things = words.partition("/")
    return Material(name, title, kappa, rho, density, speed, absorbed, conductivity, (name, *matter.split()), tuple(things.split()))


_TABLE = (
    # title, kappa, rho, density, wave speed, loss factor, conductivity, words for matter / for things
    _solid("Steel", 0.10, 0.90, 7850, 5100, 0.0003, 50.0, "iron metal chrome stahl metall eisen / rail rails anvil hammer nail screw pipe"),
    _solid("Aluminium", 0.12, 0.85, 2700, 5000, 0.0003, 160.0, "aluminum alu / foil"),
    _solid("Brass", 0.12, 0.92, 8500, 3480, 0.001, 120.0, "copper bronze gold silver messing kupfer"),
    _solid("Lead", 0.55, 0.95, 11300, 1210, 0.02, 35.0, "zinc tin blei"),
    _solid("Stone", 0.30, 0.85, 2700, 4000, 0.005, 2.8, "rock granite marble sandstone limestone slate stein fels / cliff boulder hearth"),
    _solid("Concrete", 0.40, 0.75, 2300, 3400, 0.006, 1.65, "cement beton / floor slab fußboden pavement sidewalk bunker foundation"),
    _solid("Brick", 0.45, 0.75, 1800, 3000, 0.015, 0.77, "masonry ziegel / bricks wall chimney mauer"),
    _solid("Plaster", 0.50, 0.65, 1000, 2400, 0.01, 0.4, "gypsum drywall stucco gips putz"),
    _solid("Asphalt", 0.55, 0.75, 2100, 1900, 0.3, 0.7, "tarmac bitumen / road street strasse"),
    _solid("Ceramic", 0.20, 0.80, 2400, 4500, 0.003, 1.4, "porcelain pottery keramik / tile tiles cup plate mug vase"),
    _solid("Glass", 0.15, 0.80, 2500, 5170, 0.002, 1.0, "crystal glas / window bottle mirror"),
    _solid("Hardwood", 0.25, 0.78, 700, 3960, 0.01, 0.18, "oak beech walnut teak mahogany eiche buche / parquet bench table desk"),
    _solid(
        "Softwood",
        0.35,
        0.70,
        500,
        4500,
        0.01,
        0.13,
        "wood pine fir spruce holz kiefer fichte / plank board floorboard deck crate chair door pallet",
    ),
    _solid("Plywood", 0.42, 0.66, 600, 3000, 0.013, 0.14, "chipboard particleboard mdf cardboard sperrholz"),
    _solid("Plastic", 0.40, 0.60, 1200, 1840, 0.03, 0.2, "acrylic pvc nylon polymer vinyl lego kunststoff plastik"),
    _solid("Rubber", 0.80, 0.60, 1100, 60, 0.15, 0.17, "silicone latex gummi / tire tyre reifen"),
    _solid("Cork", 0.75, 0.40, 200, 450, 0.15, 0.05, "kork"),
    _solid("Soil", 0.60, 0.70, 1700, 200, 0.06, 1.0, "earth dirt mud grass clay erde / ground terrain lawn field boden"),
    _solid("Sand", 0.70, 0.55, 1600, 150, 0.10, 0.4, " / beach desert dune"),
    _solid("Gravel", 0.65, 0.65, 1800, 300, 0.06, 0.7, "pebbles kies schotter / ballast rubble scree"),
    _solid("Ice", 0.20, 0.75, 917, 3200, 0.005, 2.2, "glacier frozen eis"),
    _soft("Snow", 0.80, 0.35, 250, 2.0, 0.15, "schnee"),
    _soft("Foam", 0.88, 0.35, 40, 3.0, 0.04, "sponge schaum / cushion mattress pillow sofa couch polster"),
    _soft("Fabric", 0.85, 0.40, 300, 2.5, 0.06, "cloth textile cotton wool felt stoff / carpet rug curtain shirt jacket trousers teppich"),
    _soft("Ribbon", 0.70, 0.45, 300, 1.5, 0.06, " / rope string cord band strap belt seil schnur"),
    _soft("Leather", 0.70, 0.55, 900, 1.2, 0.16, "leder / saddle boot shoe glove"),
    _soft("Paper", 0.72, 0.45, 800, 1.5, 0.1, "papier / book"),
    _soft("Flesh", 0.25, 0.85, 1050, 0.6, 0.5, "skin haut / body avatar human character person man woman hand arm leg mannequin mensch"),
    _solid("Bone", 0.15, 0.85, 1900, 3500, 0.03, 0.4, "ivory knochen / skull skeleton tooth horn antler"),
    _solid("Water", 0.50, 0.70, 1000, 1480, 0.0005, 0.6, "liquid wasser / sea ocean lake pool river"),
    _solid("Air", 0.70, 0.60, 1.2, 343, 0.0005, 0.026, "atmosphere gas luft"),
)

MATERIALS: Mapping[str, Material] = MappingProxyType({material.name: material for material in _TABLE})
"""The materials by name."""

_WORDS = {word: material for material in _TABLE for word in material.words}
_THINGS = {word: material for material in _TABLE for word in material.things}
_ENDINGS = ("", "s", "es", "en", "y", "ic", "ed")


def named_in(text: str) -> Material | None:
    """The material that a name of a thing speaks of: of its matter ("Oak Bench.001", "rustyMetal_2"), else of the thing itself ("Anvil").

    Of several the last counts ("Glass Table"); None where there is none.
    """
    words = re.findall(r"[^\W\d_]+", re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])", " ", text).lower())
    for known in (_WORDS, _THINGS):
        for word in reversed(words):
            for ending in _ENDINGS:
                stem = word.removesuffix(ending)
                if word.endswith(ending) and stem in known:
                    return known[stem]
    return None


_GROUND_EXTENT, _GROUND_FLATNESS = 4.0, 0.15
_BY_DENSITY = ("foam", "cork", "softwood", "hardwood", "plastic", "stone", "steel")


def is_wide_and_flat(size: tuple[float, float, float]) -> bool:
    """True for a ground or a floor: metres along x, y and z."""
    x, y, z = size
    return min(x, y) >= _GROUND_EXTENT and z <= _GROUND_FLATNESS * min(x, y)


def guess(names: Iterable[str], size: tuple[float, float, float] | None = None, mass: float | None = None) -> Material | None:
    """The material that a thing is probably made of, or None.

    names: of its surfaces, itself, its mesh, the most telling first. size: extent along x, y and z in metres; what is wide and flat is
    ground. mass: kg, where the author has set it; what it weighs for the size of its bounding box then decides.
    """
    for name in names:
        material = named_in(name)
        if material is not None:
            return material
    if size is None:
        return None
    if is_wide_and_flat(size):
        return MATERIALS["soil"]
    volume = math.prod(size)
    if mass is None or not mass > 0 or not volume > 0:
        return None
    density = math.log(mass / volume)
    return min((MATERIALS[name] for name in _BY_DENSITY), key=lambda material: abs(math.log(material.density) - density))
