"""Propagation function with geometric spreading and material damping."""

from __future__ import annotations

import enum
import math

import numpy as np

from ...arrays import FloatArray
from ...declaration import choice, number
from ...frozen import frozen
from ..bands import BAND_CENTRES
from ..coefficients import transfer_coefficient
from .body import Body
from .modulation import LogLinear, ModulationFunction, OnContact, Value
from .spreading import NO_SPREADING, Law, Spreading

_FELT = 0.06
"""Nepers (0.5 dB) by which the loss of any band must differ from the lowest one's over `_FAR`
metres; below this, bands are left out."""

_FAR = 10.0

_SLOWEST = 1.0
"""Least resonance of a limb [Hz] that counts for its impedance."""

BOUNDS_OF_K = 0.01, 0.99
"""Within these a material's own coefficient is held, by which the damping is divided."""


class Wave(enum.StrEnum):
    """What a wave runs in: the sizes of a body say how it spreads there, those of the ground and of
    a limb do not."""

    BOUNDED = "bounded"  # in a body, until the wave fills it
    SURFACE = "surface"  # along the ground
    LIMB = "limb"  # along a limb, which moves as a whole at low frequencies


WAVES = {
    Wave.BOUNDED: (
        "Body",
        "Spreads from the source until it fills the body's thickness and width, and no further",
    ),
    Wave.SURFACE: (
        "Half-Space",
        "Waves along the surface of something without end, as of the ground, whatever its "
        "thickness",
    ),
    Wave.LIMB: ("Limb", "Along a part of a body, which moves as a whole up to its resonance"),
}


@frozen(kw_only=True)
class Physical(ModulationFunction):
    """``min(1, K / K0) spreading(d) exp(-alpha(f) d ln K / ln K0)`` with ``K = (1 - kappa) rho``:
    geometric spreading up to the sizes of the body, and damping. kappa and rho are dials over the
    material, whose own coefficient is ``K0 = material_k``: there they change nothing, below it they
    act as the paper's factor once per body and damp more, above it they only damp less.

    In a body whose least size is ``thickness`` and next one ``extent``, a wave spreads through the
    volume from r0 until it fills the thickness, then over the surface until it fills the width, and
    no further: ``(1 + min(d, A) / r0)^-1 (1 + (min(d, A + B) - min(d, A)) / q)^-1/2`` with ``A =
    max(thickness - r0, 0)``, ``q = max(r0, thickness)`` and ``B = max(extent - q, 0)``. Along the
    surface of a half-space it is ``(1 + d / r0)^-1/2``, along a limb 1. In every case ``-log`` is 0
    at 0, concave and non-decreasing in d.

    Bodies bend: ``alpha = pi f loss_factor / (2 c_B)`` with ``c_B = sqrt(1.8 phase_speed thickness
    f)`` (Cremer, Heckl and Petersson, *Structure-Borne Sound*, for a Poisson ratio of 0.3), and ``2
    c_B`` at most ``phase_speed``. On a half-space ``alpha = pi f loss_factor / phase_speed``, along
    a limb ``pi (f - resonance) loss_factor / phase_speed``, 0 below its ``resonance`` [Hz], up to
    which the limb moves as a whole. ``absorption`` [1/m] is added at every frequency; it represents
    edges and joints of a building. The plain gain is that of the lowest frequency band, which is
    the highest; the other bands follow the formula, unless none of them differs by half a decibel
    over ten metres of the material.

    Waves begin at a contact as fronts that are as large as its patch, if that is larger than r0
    (`Spreading.cost`).

    Lengths in metres. ``reference_distance``: r0, the radius of the driven area. ``extent``: the
    width of a body, of a half-space the distance of its edge (0: infinite). ``length``: volume over
    width and thickness (0: infinite). ``phase_speed`` in m/s,
    of extensional, surface or shear waves; it causes no delay (`Spectrum.wave_speed` does).
    ``density`` in kg/m^3, phase speed and sizes determine the impedance at contacts.
    """

    name, label = "physical", "Physical"
    about = "Spreading and damping of measured materials, by loss factor, wave speed and wave type"
    wave: Wave = choice(Wave.BOUNDED, "Wave", "What vibration runs in", WAVES)
    loss_factor: float = number(
        0.01,
        "Loss Factor",
        "Part of the energy that a cycle turns into heat, over 2π: steel 0.0002, wood 0.01, "
        "rubber 0.15",
        0.0,
        soft=(0.0, 1.0),
        digits=5,
    )
    phase_speed: float = number(
        1000.0,
        "Speed (m/s)",
        "Speed of the waves in metres per second, for plates that of extensional waves: "
        "steel 5100, soil 200",
        0.0,
        soft=(0.1, 6000.0),
        above=True,
    )
    density: float = number(
        1000.0,
        "Density",
        "With the sizes it gives the mass that contacts depend on: steel 7850, water 1000, foam 40",
        0.0,
        soft=(0.1, 20000.0),
        unit="kg/m³",
        above=True,
    )
    thickness: float = number(
        0.1,
        "Thickness",
        "Thickness of the plate, or of the wall of a hollow body",
        0.0,
        soft=(1e-4, 100.0),
        unit="m",
        digits=4,
        above=True,
    )
    absorption: float = number(
        0.0,
        "Loss at Joints",
        "Attenuation per metre that edges and joints add at every frequency; walls and "
        "floors of a building 0.12 to 0.35",
        0.0,
        soft=(0.0, 1.0),
        unit="1/m",
        digits=3,
    )
    material_k: float = number(
        0.5,
        "Holds at (1 - κ) ρ",
        "The material's own coefficient, at which the numbers above hold: a lower one passes on "
        "less and damps more, a higher one only damps less",
        *BOUNDS_OF_K,
        digits=3,
    )
    reference_distance: float = number(
        0.5,
        "Source Radius",
        "Radius of the region that a source drives; spreading begins there",
        0.0,
        soft=(0.001, 10.0),
        unit="m",
        above=True,
    )
    extent: float = number(
        0.0,
        "Extent",
        "Distance over which vibration spreads in the body: the width of a bounded one, else "
        "its length; 0: without end",
        0.0,
        soft=(0.0, 100.0),
        unit="m",
    )
    length: float = number(
        0.0,
        "Length",
        "Volume over width and thickness; with them and the density it is the mass that contacts "
        "depend on. 0: without end",
        0.0,
        soft=(0.0, 100.0),
        unit="m",
    )
    resonance: float = number(
        20.0,
        "Resonance",
        "A limb moves as a whole up to this frequency: trunk 5, elbow 8, knee 25, wrist 30, "
        "fingertip 200",
        0.0,
        soft=(0.0, 300.0),
        unit="Hz",
    )

    def material_damping(self, frequency: float) -> float:
        """Attenuation alpha [1/m] at ``frequency`` [Hz] of the material itself, at ``K =
        material_k``."""
        speed = self.phase_speed
        if self.wave is Wave.BOUNDED:
            speed = min(2 * math.sqrt(1.8 * speed * self.thickness * frequency), speed)
        waves = max(frequency - self.resonance, 0.0) if self.wave is Wave.LIMB else frequency
        return math.pi * waves * self.loss_factor / speed + self.absorption

    def damping(self, frequency: float, kappa: Value, rho: Value) -> FloatArray:
        """Attenuation alpha [1/m] at ``frequency`` [Hz]; infinite where K is 0."""
        parts = self._parts_of_material(kappa, rho)
        infinite = np.full(np.shape(parts), math.inf)
        alpha = self.material_damping(frequency)
        return np.asarray(np.multiply(alpha, parts, out=infinite, where=parts < math.inf))

    def _parts_of_material(self, kappa: Value, rho: Value) -> FloatArray:
        """Attenuation, in parts of that of the material itself; infinite where K is 0."""
        k = np.asarray(transfer_coefficient(np.asarray(kappa), np.asarray(rho)), dtype=np.float64)
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(k) / math.log(self.material_k))

    def dial(self, kappa: Value, rho: Value) -> FloatArray:
        """The factor of kappa and rho once per body, whatever the distance: ``min(1, K / K0)``."""
        k = transfer_coefficient(np.asarray(kappa), np.asarray(rho))
        return np.asarray(np.minimum(k / self.material_k, 1.0), dtype=np.float64)

    @property
    def body(self) -> Body:
        return Body(
            self.density,
            self.phase_speed,
            self.reference_distance if self.wave is Wave.SURFACE else 0.0,
            max(self.resonance, _SLOWEST) if self.wave is Wave.LIMB else math.inf,
            length=self.length or math.inf,
            width=self.extent or math.inf,
            thickness=self.thickness,
        )

    def spreading(self, distance: FloatArray) -> FloatArray:
        """The gain by spreading alone."""
        law = Spreading.of([self.spreading_law()])
        return np.ones(np.shape(distance)) if law is None else np.exp(-law.cost(0, distance))

    def gain(
        self,
        distance: FloatArray,
        kappa: Value,
        rho: Value,
        epsilon: float,
        contact: OnContact = None,
    ) -> FloatArray:
        away = np.asarray(distance, dtype=np.float64)
        damped = np.where(away > 0, self.damping(BAND_CENTRES[0], kappa, rho), 0.0) * away
        return self.dial(kappa, rho) * self.spreading(away) * np.exp(-damped)

    def log_linear(self, kappa: float, rho: float, epsilon: float) -> LogLinear:
        factor = float(self.dial(kappa, rho))
        return factor, float(self.damping(BAND_CENTRES[0], kappa, rho)) if factor else 0.0

    def spreading_law(self) -> Law:
        start = self.reference_distance
        end = self.extent or math.inf
        match self.wave:
            case Wave.BOUNDED:
                width = max(start, self.thickness)
                over = max(end - start, 0.0)  # where it fills thickness and width
                if self.thickness > start:
                    near = self.thickness - start
                    return Law(1.0, start, near, width, max(over, near), start)
                return Law(0.5, start, over, start + over, over, start)
            case Wave.SURFACE:
                return Law(0.5, start, end, start + end, end, start)
        return NO_SPREADING

    def _relative_decays(self, kappa: float, rho: float) -> tuple[float, ...]:
        """Attenuation of each band beyond that of the lowest one [1/m], at the centres of the
        bands; () if the difference is negligible (`_FELT`)."""
        parts = float(self._parts_of_material(kappa, rho))
        alpha = np.array([self.material_damping(centre) for centre in BAND_CENTRES])
        if parts == math.inf or not (alpha - alpha[0]).max() * _FAR >= _FELT:
            return ()
        return tuple(((alpha - alpha[0]) * parts).tolist())

    def band_decays(self, kappa: float, rho: float) -> tuple[float, ...]:
        relative = self._relative_decays(kappa, rho)
        authored = self.spectrum.band_decays
        if not relative:
            return authored
        return (
            tuple(a + b for a, b in zip(relative, authored, strict=True)) if authored else relative
        )
