"""Transmission functions of contacts: by impedance, by a resilient layer, and by contact force."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from ...declaration import number
from ...frozen import frozen
from ..bands import BAND_CENTRES
from .modulation import LogLinear, ModulationFunction, OnContact, Value


@frozen(kw_only=True)
class Impedance(ModulationFunction):
    """``2 sqrt(Z1 Z2) / (Z1 + Z2)``: the square root of the transmitted power at the interface of
    two materials with impedance ``Z = density speed``. 1 if either is unknown
    (`ModulationFunction.impedance`)."""

    name, label = "impedance", "Impedance"
    about = (
        "2 √(Z1 Z2) / (Z1 + Z2), Z density times speed, of two physical materials; else everything"
    )

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        return np.ones(np.shape(distance)) * (contact or {}).get("match", 1.0)


@frozen(kw_only=True)
class Resilient(ModulationFunction):
    """A resilient layer under a load: the transmissibility of a mass on a damped spring, ``sqrt((1
    + n^2) / ((1 - (f / f0)^2)^2 + n^2))`` with ``f0 = sqrt(stiffness / load) / (2 pi)`` and loss
    factor n, at most 1.

    stiffness: N/m. load: kg. fall_off: decibels per octave far above the resonance; 12 is the
    spring's own.
    """

    name, label = "resilient", "Resilient Layer"
    about = (
        "Transmissibility of a mass on a spring: everything up to its resonance, less and "
        "less above it"
    )
    stiffness: float = number(
        1e5,
        "Stiffness",
        "Stiffness of the layer: a foam mat under a chair's leg 10,000, a rubber pad 1,000,000",
        0.0,
        1e15,
        soft=(1e-3, 1e8),
        unit="N/m",
        above=True,
    )
    load: float = number(
        10.0,
        "Load",
        "Mass that the layer carries",
        0.0,
        1e15,
        soft=(1e-6, 1e4),
        unit="kg",
        above=True,
    )
    loss_factor: float = number(
        0.2,
        "Loss Factor",
        "Damping of the layer: rubber 0.1, foam 0.2; a greater one softens the resonance and "
        "passes more far above it",
        0.0,
        soft=(0.0, 1.0),
    )
    fall_off: float = number(
        12.0,
        "Fall-Off",
        "Loss per octave far above the resonance, in decibels; 12 for a spring",
        0.0,
        1e3,
        soft=(0.0, 48.0),
        unit="dB",
    )

    @property
    def resonance(self) -> float:
        """f0 in hertz."""
        return math.sqrt(self.stiffness / self.load) / (2 * math.pi)

    def transmissibility(self, frequency: float) -> float:
        """The gain at a frequency in hertz."""
        ratio = (frequency / self.resonance) ** 2
        damped = self.loss_factor**2
        passed = (1 + damped) / ((1 - ratio) ** 2 + damped) if ratio != 1 or damped else math.inf
        return float(min(1.0, passed) ** (self.fall_off / 24))

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return max(map(self.transmissibility, BAND_CENTRES)), 0.0

    def band_gains(self) -> tuple[float, ...]:
        """The gain of each band relative to the highest one."""
        bands = np.array([self.transmissibility(centre) for centre in BAND_CENTRES])
        return tuple(
            (bands / (bands.max() or 1.0) * np.array(self.spectrum.band_gains or 1.0)).tolist()
        )


@frozen(kw_only=True)
class NormalForce(ModulationFunction):
    """``(force / reference) ** exponent``, at most 1: an exponent of 1/3 follows the stiffness of
    smooth round bodies (Hertz), 1 that of rough ones (Greenwood and Williamson). reference:
    newtons. The gain is 1 if the force is unknown."""

    name, label = "normal_force", "Pressing Force"
    about = (
        "(F / reference)^exponent, at most 1, with the force that presses resting objects together"
    )
    reference: float = number(
        10.0,
        "Reference",
        "Force in newtons from which on everything passes",
        0.0,
        1e15,
        soft=(1e-6, 1e4),
        unit="N",
        above=True,
    )
    exponent: float = number(
        1 / 3,
        "Exponent",
        "1/3: stiffness of smooth round bodies (Hertz); 1: of rough ones",
        0.0,
        1e3,
        soft=(0.0, 4.0),
        digits=3,
    )

    @property
    def uses_force(self) -> bool:
        return True

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        force = np.nan_to_num((contact or {}).get("force", math.nan), nan=self.reference)
        return (
            np.ones(np.shape(distance)) * np.minimum(force / self.reference, 1.0) ** self.exponent
        )
