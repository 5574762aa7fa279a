"""The material library: named materials and their propagation properties.

The values are in `materials.json`, designations of standards in `designations.json`. Measured,
from the tables named below: ``density``, ``wave_speed`` and, to an order of
magnitude, ``loss_factor``. Chosen by design: ``kappa`` and ``rho``, which are coefficients of the
paper without physical meaning (only ``(1 - kappa) rho`` counts), so that neighbouring materials
differ by more than the skin's difference threshold; and ``absorption`` of materials without a
single wave speed.

Wave speeds of solids are those of extensional waves in rods: CRC Handbook of Chemistry and Physics,
"Speed of Sound in Various Media"; of building materials, cork, rubber and wood along the grain: The
Engineering ToolBox, "Speed of Sound in common Solids". Densities: EN ISO 10456,
CIBSE Guide A tables 3.36 and 3.37; rocks: CRC Handbook. Loss factors: the usual values of
Cremer, Heckl and Petersson, "Structure-Borne Sound"; they vary by a factor of 2 to 10 between
specimens. Loose soil and sand: shear waves near the surface.

Textures have measured periods where available: planed wood 14 marks of the knife an inch, finely
planed 21 (Architectural Woodwork Institute); gravel and sand the mean grain sizes of medium gravel
and coarse sand (ISO 14688-1); asphalt within the macrotexture of roads, 0.5 to 50 mm (ISO 13473-1);
flesh the ridges of fingertips. All other values of textures are chosen.
"""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from ..forms import Form
from ..frozen import frozen
from .coefficients import transfer_coefficient

_REFERENCE = 100.0
"""The frequency of ``absorption``, in hertz."""


@frozen
class Material:
    """A material of the library.

    name: identifier in files and properties. title: name in menus. kappa, rho: the paper's
    coefficients, in [0, 1]. density: kg/m^3. wave_speed: m/s, 0 if there is no single speed.
    absorption: extra attenuation at 100 Hz, in 1/m. words: names
    of the material, things: names of objects usually made of it, in lower case.
    """

    name: str
    title: str
    kappa: float
    rho: float
    density: float
    wave_speed: float
    absorption: float
    words: tuple[str, ...] = ()
    things: tuple[str, ...] = ()

    @property
    def k(self) -> float:
        """The transfer coefficient (1 - κ) ρ of the paper's function."""
        return transfer_coefficient(self.kappa, self.rho)


def absorption(loss_factor: float, wave_speed: float) -> float:
    """Attenuation of a plane wave at 100 Hz in 1/m: ``pi f eta / c`` (amplitude; from the complex
    wave number ``k (1 - i eta / 2)``)."""
    return math.pi * _REFERENCE * loss_factor / wave_speed


TABLE: Mapping[str, Form] = json.loads(
    Path(__file__).with_name("materials.json").read_text("utf-8")
)
"""The rows of `materials.json` by name of the material."""


def _material(name: str, row: Form) -> Material:
    """A material from its row; absorption follows from wave speed and loss factor, or is given if
    there is no single wave speed."""
    return Material(
        name=name,
        **{key: row[key] for key in ("title", "kappa", "rho", "density")},
        wave_speed=row.get("wave_speed", 0.0),
        absorption=absorption(row["loss_factor"], row["wave_speed"])
        if "wave_speed" in row
        else row["absorption"],
        words=(name, *row.get("words", "").split()),
        things=tuple(row.get("things", "").split()),
    )


MATERIALS: Mapping[str, Material] = MappingProxyType(
    {name: _material(name, row) for name, row in TABLE.items()}
)
"""The materials by name."""

_TITLES = {material.title: material for material in MATERIALS.values()}


def preset_named(name: str) -> Material | None:
    """The material of the library with a name or title, which may be followed by Blender's number:
    "steel", "Steel", "Steel.001"; None of another name."""
    stem = name.partition(".")[0]
    return MATERIALS.get(stem) or _TITLES.get(stem)


def _folded(text: str) -> str:
    """Without case and accents, however they are encoded: file names may have them apart."""
    return "".join(
        mark
        for mark in unicodedata.normalize("NFKD", text.casefold())
        if not unicodedata.combining(mark)
    )


_WORDS = {_folded(word): material for material in MATERIALS.values() for word in material.words}
_THINGS = {_folded(word): material for material in MATERIALS.values() for word in material.things}
_PARTS = {
    _folded(part): MATERIALS[name]
    for name, row in TABLE.items()
    for part in row.get("parts", "").split()
}
"""Names of materials that count also as the beginning or the end of a longer word, as in the
German compound "Holztisch"."""

_ENDINGS = ("", "s", "es", "en", "y", "ic", "ed")


_DESIGNATIONS = tuple(
    (re.compile(f"(?<![A-Za-z0-9])({row['pattern']})(?![A-Za-z0-9])"), MATERIALS[row["material"]])
    for row in json.loads(Path(__file__).with_name("designations.json").read_text("utf-8"))
)
"""Designations of standards and trade names, each with its source in `designations.json`."""


@lru_cache(maxsize=1024)
def named_in(text: str) -> Material | None:
    """The material suggested by an object's name: by a standard's designation in it ("S235_zinc",
    "PA66-GF30"), else by a material ("Oak Bench.001", "rustyMetal_2"), else by a part of a word
    ("Holztisch"), else by the kind of object ("Anvil").

    Of several designations the first counts, which is that of the base, of several words the last
    ("Glass Table"); None without any.
    """
    places = ((pattern.search(text), material) for pattern, material in _DESIGNATIONS)
    found = [(place.start(), material) for place, material in places if place is not None]
    if found:
        return min(found, key=lambda item: item[0])[1]
    apart = _folded(re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])", " ", text))
    words = re.findall(r"[^\W\d_]+", apart)[::-1]
    return _in_any_form(words, _WORDS) or _with_part(words) or _in_any_form(words, _THINGS)


def _in_any_form(words: Iterable[str], known: Mapping[str, Material]) -> Material | None:
    """The material of the first word that is known, in any form of it."""
    for word in words:
        for ending in _ENDINGS:
            stem = word.removesuffix(ending)
            # "Tiny" is not of tin.
            is_same = len(stem) > 3 or ending in ("", "s", "en")
            if word.endswith(ending) and is_same and stem in known:
                return known[stem]
    return None


def _with_part(words: Iterable[str]) -> Material | None:
    """The material of the longest part of the first word that has one."""
    for word in words:
        parts = [
            part
            for part in _PARTS
            if word.startswith(part) or word.endswith((part, part + "s", part + "n"))
        ]
        if parts:
            return _PARTS[max(parts, key=len)]
    return None


def texture_in(text: str) -> Mapping[str, float]:
    """The values of a `Texture` of the material suggested by an object's name; empty without one,
    and for a fluid."""
    material = named_in(text)
    return {} if material is None else TABLE[material.name].get("texture", {})


_GROUND_EXTENT, _GROUND_FLATNESS = 4.0, 0.15
_BY_DENSITY = ("foam", "cork", "softwood", "hardwood", "plastic", "stone", "steel")


def is_wide_and_flat(size: tuple[float, float, float]) -> bool:
    """True for a ground or a floor: metres along x, y and z."""
    x, y, z = size
    return min(x, y) >= _GROUND_EXTENT and z <= _GROUND_FLATNESS * min(x, y)


def guess(
    names: Iterable[str], size: tuple[float, float, float] | None = None, mass: float | None = None
) -> Material | None:
    """The probable material of an object, or None.

    names: those of its surfaces, itself and its mesh, the most specific first. size: extent along
    x, y and z in metres; a wide and flat object is ground. mass: kg, if the author has set it;
    without a match by name, the density of the bounding box then decides.
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
    density = math.log(mass) - math.log(volume)  # the quotient may be too small for a number
    return min(
        (MATERIALS[name] for name in _BY_DENSITY),
        key=lambda material: abs(math.log(material.density) - density),
    )
