"""The modulation functions of objects and of rules for contacts, from their properties."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ...core.scene.functions import TRANSMISSIONS, Identity, ModulationFunction, Spectrum
from ..properties.declared import read_values
from .imported import fields_of, stored_item


def read_function(haptics: Any, stored: ModulationFunction | None = None) -> ModulationFunction:
    """The propagation function of an object's properties; ``stored``: that of the file that the
    object comes from. Raises ValueError."""
    stored = stored if stored is not None and stored.name == haptics.function else None
    known = fields_of(None if stored is None else stored.spectrum)
    values = read_values(Spectrum, haptics, known)
    bands = (
        read_values(Spectrum, haptics.material, known)["band_decays"]
        if haptics.material.use_bands
        else ()
    )
    return function_of(haptics, stored, Spectrum(**{**values, "band_decays": bands}))


def function_of(
    group: Any, stored: ModulationFunction | None, spectrum: Spectrum
) -> ModulationFunction:
    """The function that a group's properties choose, with their parameters. Raises ValueError."""
    cls = TRANSMISSIONS[group.function]
    known = fields_of(stored) if isinstance(stored, cls) else {}
    values = read_values(cls, group, known)
    return _made(group.function, tuple(values), (spectrum, *values.values()))


@lru_cache(maxsize=1024)
def _made(kind: str, names: tuple[str, ...], values: tuple[Any, ...]) -> ModulationFunction:
    """A function of a kind with its spectrum and the named values: the same one for all objects
    like it."""
    return TRANSMISSIONS[kind](**dict(zip(("spectrum", *names), values, strict=True)))


def read_transmission(row: Any) -> tuple[ModulationFunction, str]:
    """The function of a rule of contacts; the identity and the reason if it is invalid."""
    try:
        stored = stored_item(row.imported, "contact").get("transmission")
        return function_of(row, stored, stored.spectrum if stored is not None else Spectrum()), ""
    except ValueError as error:
        return Identity(), str(error)
