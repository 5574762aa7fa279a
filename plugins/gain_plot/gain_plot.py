"""Plot of the gain over distance in the panel."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...addon.session.derived import Background, Latest
from ...addon.view.panel_picture import SIZE, Canvas, Colour, Picture, Pixels
from ...core.arrays import FloatArray
from ...core.scene.bands import BAND_COUNT, BAND_EDGES
from ...core.scene.functions import ModulationFunction, Resilient

FLOOR = -60.0
"""Gain at the bottom of the picture [dB]."""

LOADS = (1.0, 10.0, 100.0)
"""Masses on springs whose curves are drawn [kg]."""
_HIGHEST = 200.0

_MARGIN = 10

_FAINT = 0.001
"""A curve is shown until its gain is a thousandth: -60 dB."""
_SHOWN_BANDS = np.searchsorted(BAND_EDGES, (30.0, 100.0, 300.0)) - 1
_LENGTHS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


@dataclass(frozen=True, eq=False)
class GainCurve:
    """``gains`` (n,) at ``distances`` (n,) [m], from 0 to ``length``; of a spring at frequencies
    [Hz]. ``bands`` (3, n): those at 30, 100 and 300 Hz, or None if the function does not depend on
    frequency; of a spring those under the `LOADS`, or None if these do not matter."""

    length: float
    distances: FloatArray
    gains: FloatArray
    bands: FloatArray | None
    unit: str = "m"

    def at(self, distance: float) -> float:
        """The gain at a distance up to ``length``."""
        return float(np.interp(distance, self.distances, self.gains))


def gain_curve(
    function: ModulationFunction, kappa: float, rho: float, epsilon: float, count: int = 128
) -> GainCurve:
    """The gain of a function over distance, up to a round distance at which it falls to `_FAINT`,
    at most 100 metres. Raises ValueError if an expression gives no valid gain.

    Args:
        function: of an object.
        kappa: of the object.
        rho: of the object.
        epsilon: the paper's least attenuation [1/m].
        count: number of points.
    """
    if isinstance(function, Resilient):
        return _spring_curve(function, count)
    probe = np.array([0.0, *_LENGTHS])
    gains = function.gain(probe, kappa, rho, epsilon)
    faint = np.flatnonzero(gains[1:] <= _FAINT)
    length = (
        _LENGTHS[int(faint[0])]
        if len(faint) and gains.max() > 0
        else (_LENGTHS[-1] if gains.max() > 0 else 1.0)
    )
    distances = np.linspace(0.0, length, count)
    plain = function.gain(distances, kappa, rho, epsilon)
    factors = function.band_gains()
    decays = function.band_decays(kappa, rho)
    bands = None
    if factors or decays:
        factor, decay = (
            np.array(values or (default,) * BAND_COUNT)[_SHOWN_BANDS]
            for values, default in ((factors, 1.0), (decays, 0.0))
        )
        bands = plain * factor[:, None] * np.exp(-decay[:, None] * distances)
    return GainCurve(length, distances, plain, bands)


def _spring_curve(function: Resilient, count: int) -> GainCurve:
    frequencies = np.linspace(0.0, _HIGHEST, count)
    gains = np.array(
        [[function.transmissibility(f, mass) for f in frequencies.tolist()] for mass in LOADS]
    )
    return GainCurve(
        _HIGHEST, frequencies, gains[1], None if function.frequency else gains, unit="Hz"
    )


_curve: Background[GainCurve | None] = Background()
_picture = Picture()


def picture(curve: GainCurve, colour: Colour, ink: Colour) -> Pixels:
    """The curve as pixels (SIZE, SIZE, 4), colours times opacity, the first row at the bottom: from
    `FLOOR` to 0 dB upwards, the curve's length across.

    Lines every 20 dB and at quarters of the length, in ``ink``; the curve in ``colour``, filled
    below; those at 30, 100 and 300 Hz as thin lines.
    """
    builder = Canvas()
    side = SIZE - 2 * _MARGIN - 1
    for count, step in ((4, (0.0, 1.0)), (5, (1.0, 0.0))):
        for part in np.linspace(0, side, count).tolist():
            start = [_MARGIN + 0.5 + part * to for to in step]
            end = [at + side * (1 - to) for at, to in zip(start, step, strict=True)]
            builder.line(start, end, (*ink, 0.2 if part else 0.5), 1.0)
    columns = np.arange(0, side + 1, 3)
    at = columns * curve.length / side
    bands = () if curve.bands is None else curve.bands
    for gains, width in [(curve.gains, 3.2), *((band, 1.4) for band in bands)]:
        decibels = 20 * np.log10(np.maximum(np.interp(at, curve.distances, gains), 1e-9))
        heights = _MARGIN + 0.5 + np.clip(1 - decibels / FLOOR, -0.02, 1) * side
        corners = np.column_stack([_MARGIN + 0.5 + columns, heights]).tolist()
        for (x, y), corner in pairwise(corners):
            if gains is curve.gains:
                builder.plate((x, _MARGIN), (corner[0], y), (*colour, 0.22), 0.0)
            builder.line((x, y), corner, (*colour, 1.0), width)
    return builder.painted()


def latest_curve(
    key: tuple[ModulationFunction, float, float, float],
) -> Latest[GainCurve | None] | None:
    """The curve of (function, κ, ρ, ε), without waiting; its value is None if the function gives no
    valid gain."""

    def compute(before: GainCurve | None) -> GainCurve | None:
        try:
            return gain_curve(*key)
        except ValueError:
            return None

    return _curve.latest(key, compute)


def icon(curve: GainCurve, colour: Colour, ink: Colour) -> int:
    """The identifier of the icon with the curve."""
    return _picture.icon((curve, colour, ink), lambda: picture(curve, colour, ink))
