"""Transmission functions of contacts: by impedance, by a resilient layer, and by contact force."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import FloatArray
from ..bands import BAND_CENTRES
from .modulation import ModulationFunction, OnContact, Value


@dataclass(frozen=True, slots=True, kw_only=True)
class Impedance(ModulationFunction):
    """``2 sqrt(Z1 Z2) / (Z1 + Z2)``: the square root of the transmitted power at the interface of two materials with impedance ``Z =
    density speed``. 1 if either is unknown (`ModulationFunction.impedance`)."""

    name: ClassVar[str] = "impedance"

    def gain(self, distance: FloatArray, kappa: Value, rho: Value, epsilon: float, contact: OnContact = None) -> FloatArray:
        return np.ones(np.shape(distance)) * (contact or {}).get("match", 1.0)

    def bounds(self, max_distance: float, kappa: float, rho: float, epsilon: float) -> tuple[float, float]:
        return 0.0, 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Resilient(ModulationFunction):
    """A resilient layer under a load: the transmissibility of a mass on a damped spring,
    ``sqrt((1 + n^2) / ((1 - (f / f0)^2)^2 + n^2))`` with ``f0 = sqrt(stiffness / load) / (2 pi)`` and loss factor n, at most 1.

    stiffness: N/m. load: kg. fall_off: decibels per octave far above the resonance; 12 is the spring's own.
    """

    name: ClassVar[str] = "resilient"
    positive: ClassVar[tuple[str, ...]] = ("stiffness", "load")
    stiffness: float = 1e5
    load: float = 10.0
    loss_factor: float = 0.2
    fall_off: float = 12.0

    @property
    def resonance(self) -> float:
        """f0 in hertz."""
        return math.sqrt(self.stiffness / self.load) / (2 * math.pi)

    def transmissibility(self, frequency: float) -> float:
        """The gain at a frequency in hertz."""
        ratio, damped = (frequency / self.resonance) ** 2, self.loss_factor**2
        passed = (1 + damped) / ((1 - ratio) ** 2 + damped) if ratio != 1 or damped else math.inf
        return float(min(1.0, passed) ** (self.fall_off / 24))

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> tuple[float, float]:
        return max(map(self.transmissibility, BAND_CENTRES)), 0.0

    def band_gains(self) -> tuple[float, ...]:
        """The gain of each band relative to the highest one."""
        bands = np.array([self.transmissibility(centre) for centre in BAND_CENTRES])
        return tuple((bands / bands.max() * np.array(self.spectrum.band_gains or 1.0)).tolist())


@dataclass(frozen=True, slots=True, kw_only=True)
class NormalForce(ModulationFunction):
    """``(force / reference) ** exponent``, at most 1: an exponent of 1/3 follows the stiffness of smooth round bodies (Hertz), 1 that of
    rough ones (Greenwood and Williamson). reference: newtons. The gain is 1 if the force is unknown."""

    name: ClassVar[str] = "normal_force"
    positive: ClassVar[tuple[str, ...]] = ("reference",)
    reference: float = 10.0
    exponent: float = 1 / 3

    @property
    def uses_force(self) -> bool:
        return True

    def gain(self, distance: FloatArray, kappa: Value, rho: Value, epsilon: float, contact: OnContact = None) -> FloatArray:
        force = np.nan_to_num((contact or {}).get("force", math.nan), nan=self.reference)
        return np.ones(np.shape(distance)) * np.minimum(force / self.reference, 1.0) ** self.exponent

    def bounds(self, max_distance: float, kappa: float, rho: float, epsilon: float) -> tuple[float, float]:
        return 0.0, 1.0
