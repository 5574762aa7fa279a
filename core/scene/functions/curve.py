"""The gain of a function over distance, as a curve to look at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .modulation import ModulationFunction

FAINT = 0.001
"""A curve is shown until its gain is a thousandth: -60 dB."""
_REACHES = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


@dataclass(frozen=True, slots=True)
class Curve:
    """``gains`` (n,) at ``distances`` (n,) [m], from 0 to ``reach``. ``bands`` (2, n): those of the lowest and the highest frequency band,
    or None where the function treats all alike."""

    reach: float
    distances: FloatArray
    gains: FloatArray
    bands: FloatArray | None

    def at(self, distance: float) -> float:
        """The gain at a distance within reach."""
        return float(np.interp(distance, self.distances, self.gains))


def gain_curve(function: ModulationFunction, kappa: float, rho: float, epsilon: float, count: int = 128) -> Curve:
    """The curve over a round distance in which the gain becomes faint, 100 metres at most.

    Raises ValueError where an expression gives no gain.
    """
    probe = np.array([0.0, *_REACHES])
    gains = function.gain(probe, kappa, rho, epsilon)
    faint = np.flatnonzero(gains[1:] <= FAINT)
    reach = _REACHES[int(faint[0])] if len(faint) and gains.max() > 0 else (_REACHES[-1] if gains.max() > 0 else 1.0)
    distances = np.linspace(0.0, reach, count)
    plain = function.gain(distances, kappa, rho, epsilon)
    spectrum, bands = function.spectrum, None
    if spectrum.band_gains or spectrum.band_decays:
        factor = np.array(spectrum.band_gains or (1.0,))[[0, -1]]
        decay = np.array(spectrum.band_decays or (0.0,))[[0, -1]]
        bands = plain * factor[:, None] * np.exp(-decay[:, None] * distances)
    return Curve(reach, distances, plain, bands)
