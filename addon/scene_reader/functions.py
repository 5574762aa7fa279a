"""The modulation functions of objects and of rules for contacts, from their properties."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ...core.scene.functions import TRANSMISSIONS, Identity, ModulationFunction, Spectrum
from ..properties.declared import read_values


def read_function(haptics: Any) -> ModulationFunction:
    """The propagation function of an object's properties. Raises ValueError."""
    return function_of(haptics, Spectrum(**read_values(Spectrum, haptics)))


def function_of(group: Any, spectrum: Spectrum) -> ModulationFunction:
    """The function that a group's properties choose, with their parameters. Raises ValueError."""
    values = read_values(TRANSMISSIONS[group.function], group)
    return _made(group.function, tuple(values), (spectrum, *values.values()))


@lru_cache(maxsize=1024)
def _made(kind: str, names: tuple[str, ...], values: tuple[Any, ...]) -> ModulationFunction:
    """A function of a kind with its spectrum and the named values: the same one for all objects
    like it."""
    return TRANSMISSIONS[kind](**dict(zip(("spectrum", *names), values, strict=True)))


def read_transmission(row: Any) -> tuple[ModulationFunction, str]:
    """The function of a rule of contacts; the identity and the reason if it is invalid."""
    try:
        return function_of(row, Spectrum()), ""
    except ValueError as error:
        return Identity(), str(error)
