"""Modalities: kinds of sensation beside vibration that share the objects, contacts and listeners of
a scene, each with its own functions, values and unit.

A further modality is a module with one `Modality` value, listed in `MODALITIES`. `propagation`
computes its values at listeners.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .modality import Modality
from .thermal import THERMAL

MODALITIES: Mapping[str, Modality] = MappingProxyType(
    {modality.name: modality for modality in (THERMAL,)}
)
"""The modalities by name."""

__all__ = ["MODALITIES", "THERMAL", "Modality"]
