"""All vibration functions by name, and their construction from scene files."""

from __future__ import annotations

from collections.abc import Mapping

from ...forms import Form, JsonObject
from .contacts import Impedance, NormalForce, Resilient
from .modulation import (
    Constant,
    Exponential,
    Expression,
    HapticTracing,
    Identity,
    Linear,
    ModulationFunction,
    Spectrum,
    parameters_of,
)
from .physical import Physical

FUNCTIONS: dict[str, type[ModulationFunction]] = {
    cls.name: cls
    for cls in (
        Identity,
        Constant,
        Linear,
        Exponential,
        HapticTracing,
        Expression,
        Physical,
        Resilient,
    )
}
"""Propagation functions, of objects, by their names in files."""
TRANSMISSIONS: dict[str, type[ModulationFunction]] = {
    **FUNCTIONS,
    **{cls.name: cls for cls in (Impedance, NormalForce)},
}
"""Transmission functions, of contacts, by their names in files."""
_SPECTRUM_KEYS = ("band_gains", "band_decays", "wave_speed")


def function_from_dict(
    form: Form, functions: Mapping[str, type[ModulationFunction]] = FUNCTIONS
) -> ModulationFunction:
    """The function of a scene file's ``{"function": name, parameters...}``; ``functions``: those
    that it may be.

    Raises ValueError that names the key for an unknown name, an unknown parameter or a value out of
    range.
    """
    name = form.get("function")
    cls = functions.get(name) if isinstance(name, str) else None
    if cls is None:
        raise ValueError(f"function: unknown {name!r}; one of {', '.join(functions)}")
    parameters = parameters_of(cls)  # type: ignore[arg-type]
    arguments: JsonObject = {}
    for key, value in form.items():
        if key in parameters:
            arguments[parameters[key]] = value
        elif key not in ("function", *_SPECTRUM_KEYS):
            raise ValueError(f"{key}: unknown parameter of function {name!r}")
    spectrum = Spectrum(
        band_gains=tuple(form.get("band_gains", ())),
        band_decays=tuple(form.get("band_decays", ())),
        wave_speed=form.get("wave_speed", 0.0),
    )
    return cls(spectrum=spectrum, **arguments)
