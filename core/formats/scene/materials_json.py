"""The library of haptic materials in a scene file.

Objects name theirs in their extras, under ``material``, and have values of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from ...scene.bands import BAND_COUNT
from ..io.error import FormatError


@dataclass(frozen=True, slots=True)
class LibraryMaterial:
    """``wave_speed`` [m/s] and ``band_decays`` [1/m] count where ``use_delay`` and ``use_bands`` say so; ``conductivity`` [W/(m K)]."""

    name: str
    kappa: float
    rho: float
    use_delay: bool = False
    wave_speed: float = 0.0
    use_bands: bool = False
    band_decays: tuple[float, ...] = (0.0,) * BAND_COUNT
    conductivity: float = 1.0


def material_to_dict(material: LibraryMaterial) -> dict[str, Any]:
    """As the file has it, without what has its default."""
    values = {item.name: (getattr(material, item.name), item.default) for item in fields(LibraryMaterial)}
    return {key: list(value) if isinstance(value, tuple) else value for key, (value, default) in values.items() if value != default}


def materials_from_dict(document: Mapping[str, Any], file: str | Path) -> tuple[LibraryMaterial, ...]:
    """The materials of a validated document. Raises FormatError."""
    found: dict[str, LibraryMaterial] = {}
    for i, form in enumerate(document.get("materials", [])):
        if form["name"] in found:
            raise FormatError(file, f"/materials/{i}/name", f"there is a material {form['name']!r} already")
        values: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in form.items()}
        found[form["name"]] = LibraryMaterial(**values)
    return tuple(found.values())
