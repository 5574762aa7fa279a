"""Transmission functions of contacts: by impedance, by a spring, and by contact force."""

from __future__ import annotations

import math

import numpy as np

from ...arrays import FloatArray
from ...declaration import number
from ...frozen import frozen
from ..bands import BAND_CENTRES
from .body import Body
from .modulation import LogLinear, ModulationFunction, OnContact, Value


@frozen(kw_only=True)
class Impedance(ModulationFunction):
    """What both bodies can take, by their impedances at the contact, in the direction of travel
    (`core.graph.impedances`). 1 if either has none (`ModulationFunction.body`)."""

    name, label = "impedance", "Impedance"
    about = (
        "What both bodies can take: what is light rides on what is heavy, what is heavy hardly "
        "heeds what is light"
    )

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return 1.0, 0.0

    @property
    def between_bodies(self) -> tuple[float, float]:
        return math.inf, 0.0


@frozen(kw_only=True)
class Resilient(ModulationFunction):
    """A spring: the transmissibility of a mass on a damped spring, ``sqrt((1 + n^2) / ((1 - (f /
    f0)^2)^2 + n^2))`` with loss factor n, at most 1: what a resonance amplifies is left out, so
    that the gain is 1 up to ``sqrt(2) f0``.

    frequency: f0 [Hz]; 0: by the ``stiffness`` [N/m] and the impedance of what it drives, of a mass
    m ``f0 = sqrt(stiffness / m) / (2 pi)``.
    """

    name, label = "resilient", "Spring"
    about = (
        "Transmissibility of a mass on a spring: everything up to its resonance, less and "
        "less above it"
    )
    frequency: float = number(
        0.0,
        "Resonance",
        "Frequency of the resonance; 0: by the stiffness, from the mass that the spring carries",
        0.0,
        soft=(0.0, 100.0),
        unit="Hz",
    )
    stiffness: float = number(
        1e5,
        "Stiffness",
        "Force by which the spring gives way a metre: a seat's cushion 50,000, a tyre 200,000",
        0.0,
        1e15,
        soft=(1e-3, 1e8),
        unit="N/m",
        above=True,
    )
    loss_factor: float = number(
        0.2,
        "Loss Factor",
        "Damping of the spring: rubber 0.1, foam 0.2; a greater one passes more far above the "
        "resonance",
        0.0,
        soft=(0.0, 1.0),
    )

    def transmissibility(self, frequency: float, mass: float = 0.0) -> float:
        """The gain at a frequency [Hz]; ``mass``: carried by the stiffness [kg]."""
        square = self.frequency**2 or self.stiffness / (4 * math.pi**2 * max(mass, 1e-12))
        return float(sprung(np.array(frequency**2 / square), self.loss_factor))

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return (max(map(self.transmissibility, BAND_CENTRES)) if self.frequency else 1.0), 0.0

    def band_gains(self) -> tuple[float, ...]:
        """The gain of each band relative to the highest one."""
        if not self.frequency:
            return self.spectrum.band_gains
        bands = np.array([self.transmissibility(centre) for centre in BAND_CENTRES])
        return tuple((bands / bands.max() * np.array(self.spectrum.band_gains or 1.0)).tolist())

    @property
    def body(self) -> Body | None:
        if self.frequency:
            return None
        return Body(stiffness=self.stiffness, loss_factor=self.loss_factor)

    @property
    def between_bodies(self) -> tuple[float, float] | None:
        return None if self.frequency else (self.stiffness, self.loss_factor)


def sprung(ratio: FloatArray, loss_factor: FloatArray | float) -> FloatArray:
    """Gain of a damped spring into a load, at most 1: ``sqrt((1 + n^2) / ((1 - ratio)^2 + n^2))``.

    ``ratio``: the impedance of the load over that of the spring, of a mass ``(f / f0)^2``; the gain
    is 1 up to a ratio of 2, as the resonance would exceed 1.
    """
    square = np.square(loss_factor)
    above = np.maximum(ratio, 2.0) - 1
    return np.asarray(np.sqrt((1 + square) / (above**2 + square)))


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
