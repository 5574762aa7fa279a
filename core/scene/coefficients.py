"""The paper's two coefficients of an object, κ and ρ, and their product ``(1 - κ) ρ``."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from ..arrays import FloatArray

_Value = TypeVar("_Value", float, "FloatArray")


def transfer_coefficient(kappa: _Value, rho: _Value) -> _Value:
    """Return ``K = (1 - kappa) rho``: the gain at distance 0 and, down to ε, the attenuation per
    metre of the paper's function."""
    return (1.0 - kappa) * rho


def coefficients_of(k: float, rho: float) -> tuple[float, float]:
    """Return κ and ρ in [0, 1] with ``(1 - kappa) rho = k``; ρ is kept if possible."""
    k = min(max(k, 0.0), 1.0)
    return (1.0 - k / rho, rho) if rho >= k and rho > 0 else (0.0, k)
