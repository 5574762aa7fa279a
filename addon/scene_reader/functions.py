"""The propagation function of an object, from its properties."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from ...core.scene.functions import TRANSMISSIONS, Identity, ModulationFunction, Spectrum, function_from_dict
from ..blender.single_precision import authored, shortest
from ..properties.function import CONTACT_PARAMETERS, PARAMETERS
from .imported import imported_object


def read_function(haptics: Any) -> ModulationFunction:
    """The propagation function of an object's properties: the imported one until one of its properties is edited, and except in frames in
    which one is animated to another value. Raises ValueError."""
    imported = imported_object(haptics.imported).function
    if imported is not None and haptics.id_data.animation_data is None:
        return imported
    function = function_of_properties(haptics)
    return imported if imported is not None and stands_for(function, imported) else function


def stands_for(function: ModulationFunction, imported: ModulationFunction) -> bool:
    """Whether the ``function`` of rounded properties, without band gains, represents the ``imported`` one."""
    numbers = {f.name: getattr(imported, f.name) for f in fields(imported) if f.init}
    floats = {name: shortest(value) for name, value in numbers.items() if isinstance(value, float)}
    wave_speed, decays = imported.spectrum.wave_speed, imported.spectrum.band_decays
    spectrum = Spectrum(wave_speed=shortest(wave_speed), band_decays=tuple(map(shortest, decays)))
    try:
        return replace(imported, **floats, spectrum=spectrum) == function
    except ValueError:  # too small for single precision
        return False


def function_of_properties(haptics: Any) -> ModulationFunction:
    """The propagation function defined by an object's properties. Raises ValueError."""
    parameters = {key: authored(getattr(haptics, name)) for key, name in PARAMETERS.get(haptics.function, {}).items()}
    if haptics.wave_speed > 0:
        parameters["wave_speed"] = shortest(haptics.wave_speed)
    if haptics.material.use_bands:
        parameters["band_decays"] = authored(haptics.material.band_decays)
    return function_from_dict({"function": haptics.function, **parameters})


def read_transmission(row: Any) -> tuple[ModulationFunction, str]:
    """The function of a rule of contacts; the identity and the reason if it is invalid."""
    parameters = {key: authored(getattr(row, name)) for key, name in CONTACT_PARAMETERS.get(row.function, {}).items()}
    try:
        return function_from_dict({"function": row.function, **parameters}, TRANSMISSIONS), ""
    except ValueError as error:
        return Identity(), str(error)
