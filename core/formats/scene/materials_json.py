"""The library of haptic materials in a scene file.

Objects refer to their material in ``material`` and have a copy of its values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...scene.bands import BAND_COUNT
from ...scene.references import require_unique
from ..io.error import errors_in
from .values_json import read_value


@dataclass(frozen=True, slots=True)
class LibraryMaterial:
    """A haptic material.

    ``wave_speed`` [m/s] is used if ``use_delay``, ``band_decays`` [1/m] if ``use_bands``; ``conductivity`` in W/(m K).
    """

    name: str
    kappa: float
    rho: float
    use_delay: bool = False
    wave_speed: float = 0.0
    use_bands: bool = False
    band_decays: tuple[float, ...] = (0.0,) * BAND_COUNT
    conductivity: float = 1.0


def materials_from_dict(document: Mapping[str, Any], file: str | Path) -> tuple[LibraryMaterial, ...]:
    """The materials of a validated document. Raises FormatError."""
    forms = document.get("materials", [])
    with errors_in(file):
        require_unique([form["name"] for form in forms], "material", "materials")
        return tuple(read_value(LibraryMaterial, form, ("materials", i)) for i, form in enumerate(forms))
