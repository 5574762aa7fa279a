"""The predefined modulation functions and the designers' expression.

Five of them have the form ``gain(d) = factor * exp(-decay * d)``: a metric plus a constant in the
log domain. They report the two numbers (`log_linear`), so that whole graphs are evaluated as
arrays; `linear` and `expression` are called with arrays of distances.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, field, fields
from functools import cache
from typing import ClassVar

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...declaration import Declared, declared, number, numbers, share, text
from ...forms import JsonObject
from ...frozen import frozen
from ..bands import BAND_COUNT
from ..coefficients import transfer_coefficient
from .body import Body
from .expression import MAX_LENGTH, CompiledExpression, compile_expression
from .spreading import NO_SPREADING, Law

Value = float | FloatArray
LogLinear = tuple[float, float]
"""Factor and decay of a gain ``factor * exp(-decay * d)``."""
OnContact = Mapping[str, Value] | None
"""Quantities of a contact by the names of the variables of expressions."""


BAND_DECAYS = numbers(
    MISSING,
    "Band Attenuation",
    "Extra attenuation per metre in this band of frequencies; 0 adds none",
    BAND_COUNT,
    0.0,
    soft=(0.0, 5.0),
    digits=3,
    optional=True,
).metadata
WAVE_SPEED = number(
    MISSING,
    "Wave Speed",
    "Speed of vibration in this material; 0 passes signals on without delay",
    0.0,
    soft=(0.0, 5000.0),
    unit="m/s",
).metadata


@frozen
class Spectrum(Declared):
    """Frequency bands and delay of a connection, in addition to its plain gain.

    ``band_gains``: one factor per frequency band, each in [0, 1] (see `core.scene.bands`), applied
    once per connection. ``band_decays``: extra attenuation per band in 1/m (>= 0): factor
    ``exp(-band_decay * d)``. ``wave_speed``: metres per second; the connection delays by ``d /
    wave_speed``. 0 means no delay.
    """

    band_gains: tuple[float, ...] = numbers(
        (),
        "",
        "Factor per frequency band, applied once per connection; default 1 each",
        BAND_COUNT,
        0.0,
        1.0,
        optional=True,
    )
    band_decays: tuple[float, ...] = field(default=(), metadata=BAND_DECAYS)
    wave_speed: float = field(default=0.0, metadata=WAVE_SPEED)

    @property
    def is_plain(self) -> bool:
        """True if neither bands nor delay are used."""
        return not self.band_gains and not self.band_decays and self.wave_speed == 0

    def to_dict(self) -> JsonObject:
        """The non-default values by the keys of the scene file."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {
            key: list(value) if isinstance(value, tuple) else value
            for key, value in values.items()
            if value
        }


@cache
def parameters_of(cls: type[ModulationFunction]) -> Mapping[str, str]:
    """The fields of a function's parameters by their keys in files."""
    return {declaration.key or name: name for name, declaration in declared(cls).items()}  # type: ignore[arg-type]


@frozen(kw_only=True)
class ModulationFunction(Declared):
    """Base of all modulation functions. Immutable, hashable, compared by content."""

    name: ClassVar[str] = ""
    label: ClassVar[str] = ""
    """The function's name in menus."""
    about: ClassVar[str] = ""
    """What it computes, as the menu says."""
    spectrum: Spectrum = field(default_factory=Spectrum)

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear | None:
        """``(factor, decay)`` where the gain is ``factor * exp(-decay * d)``, times that of
        `spreading_law`; None for another form."""
        return None

    def spreading_law(self) -> Law:
        """The geometric spreading, a factor of the gain in addition to `log_linear`."""
        return NO_SPREADING

    def loss(self, kappa: float, rho: float, epsilon: float) -> float:
        """``-log(factor)`` of `log_linear`, infinite for factor 0; accurate also for factors close
        to 1."""
        pair = self.log_linear(kappa, rho, epsilon)
        assert pair is not None
        return -math.log(pair[0]) if pair[0] > 0 else math.inf

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        """Gains over distances.

        Args:
            distance: [m], 0 or more, of any shape.
            kappa: of the object, a number or an array of the shape of ``distance``, as ``rho`` and
                the values of ``contact``.
            rho: of the object.
            epsilon: the paper's least attenuation [1/m].
            contact: None in an object. Of a contact: area [m^2], depth [m], angle [rad], if used
                and force [N] (NaN if unknown).
        """
        pair = self.log_linear(0.0, 0.0, epsilon)
        assert pair is not None
        factor, decay = pair
        return factor * np.exp(-decay * np.asarray(distance, dtype=np.float64))

    def band_gains(self) -> tuple[float, ...]:
        """Factor of each frequency band in addition to the gain, applied once; () if all are 1."""
        return self.spectrum.band_gains

    @property
    def body(self) -> Body | None:
        """What decides the impedance of a body with this function; None if it has none."""
        return None

    @property
    def between_bodies(self) -> tuple[float, float] | None:
        """Of a contact that passes on what both bodies can take, stiffness [N/m] and loss factor of
        a spring in it, infinite and 0 without one; None for other functions."""
        return None

    @property
    def uses_force(self) -> bool:
        """Whether the gain of a contact depends on its normal force."""
        return False

    def band_decays(self, kappa: float, rho: float) -> tuple[float, ...]:
        """Attenuation of each frequency band in addition to that of the gain [1/m]; () if it is 0
        in all bands."""
        return self.spectrum.band_decays

    def to_dict(self) -> JsonObject:
        """The form of the scene file: ``{"function": name, parameters...}``."""
        values = {key: getattr(self, name) for key, name in parameters_of(type(self)).items()}  # type: ignore[arg-type]
        return {"function": self.name, **values, **self.spectrum.to_dict()}


@frozen(kw_only=True)
class Identity(ModulationFunction):
    """Gain 1. The default of inter-connections."""

    name, label, about = "identity", "Identity", "Passes everything on unchanged"

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return 1.0, 0.0


@frozen(kw_only=True)
class Constant(ModulationFunction):
    """The same gain over any distance."""

    name, label, about = "constant", "Constant", "The same gain over any distance"
    gain_value: float = share(0.5, "Gain", "The gain over any distance", key="gain")

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return self.gain_value, 0.0


@frozen(kw_only=True)
class Exponential(ModulationFunction):
    """``exp(-alpha d)``; alpha = 0.2 is the distance-only function of the paper (equation 4)."""

    name, label, about = "exponential", "Exponential", "e^(-α d): fades with distance alone"
    alpha: float = number(
        0.2,
        "Alpha",
        "Attenuation per metre; 0.2 is the paper's distance-only function",
        0.0,
        soft=(0.0, 5.0),
        unit="1/m",
        digits=3,
    )

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        return 1.0, self.alpha


@frozen(kw_only=True)
class HapticTracing(ModulationFunction):
    """``K exp(-max(K, epsilon) d)`` with ``K = (1 - kappa) rho``: the paper's propagation function
    (equation 2). The default of objects."""

    name, label = "haptic_tracing", "Haptic Tracing"
    about = "K e^(-max(K, ε) d) with K = (1 - κ) ρ: fades with distance as the two properties say"

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        k = transfer_coefficient(kappa, rho)
        return k, max(k, epsilon)

    def loss(self, kappa: float, rho: float, epsilon: float) -> float:
        return -(math.log1p(-kappa) + math.log(rho)) if kappa < 1 and rho > 0 else math.inf

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        k = transfer_coefficient(np.asarray(kappa), np.asarray(rho))
        return np.asarray(
            k * np.exp(-np.maximum(k, epsilon) * np.asarray(distance, dtype=np.float64))
        )


@frozen(kw_only=True)
class Linear(ModulationFunction):
    """``max(0, 1 - d / range)``."""

    name, label, about = "linear", "Linear", "1 - d / range: silent from the range on"
    range: float = number(
        10.0,
        "Range",
        "Distance from which on nothing is felt",
        0.0,
        soft=(0.001, 100.0),
        unit="m",
        above=True,
    )

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        with np.errstate(over="ignore"):  # of a range near 0
            return np.maximum(0.0, 1.0 - np.asarray(distance, dtype=np.float64) / self.range)


@frozen(kw_only=True)
class Expression(ModulationFunction):
    """A designer's formula over ``x, d, kappa, rho, epsilon`` and, on a contact, ``area, depth,
    angle, force`` (1 N if it is unknown).

    With ``x`` (a sample of the signal) the formula must be proportional to it, as in ``x *
    exp(-d)``; without, it is the gain itself, as in ``exp(-d)``.
    """

    name, label, about = "expression", "Expression", "Your own formula of x, d, kappa, rho, epsilon"
    expression: str = text(
        "x * exp(-0.2 * d)",
        "Expression",
        "Formula of x (the signal), d (metres), kappa, rho, epsilon. "
        "Functions: exp, log, sqrt, tanh, atan, sin, cos, abs, min, max, where",
        least=1,
        most=MAX_LENGTH,
    )
    compiled: CompiledExpression = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "compiled", compile_expression(self.expression))

    @property
    def uses_force(self) -> bool:
        return self.compiled.uses("force")

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        """At most 1. Raises ValueError if the formula gives a negative or non-finite gain."""
        values = {"kappa": kappa, "rho": rho, "epsilon": epsilon, **_NO_CONTACT, **(contact or {})}
        values["force"] = np.nan_to_num(values["force"], nan=1.0)
        gains = self.compiled.evaluate(np.asarray(distance, dtype=np.float64), values)
        if not np.all(np.isfinite(gains)):
            raise ValueError(
                f"expression: {self.expression!r} has no finite value at d = "
                f"{_first(distance, ~np.isfinite(gains)):g} m"
            )
        if np.any(gains < 0):
            raise ValueError(
                f"expression: {self.expression!r} is negative at d = "
                f"{_first(distance, gains < 0):g} m; a gain is 0 or more"
            )
        return np.minimum(gains, 1.0)


_NO_CONTACT: Mapping[str, Value] = {"area": 0.0, "depth": 0.0, "angle": 0.0, "force": 1.0}


def _first(distance: FloatArray, where: BoolArray) -> float:
    values = np.broadcast_to(np.asarray(distance, dtype=np.float64), where.shape)
    return float(values[where].flat[0])
