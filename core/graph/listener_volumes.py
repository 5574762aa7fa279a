"""The bounding volume of a listener: the points over which the mean of the power is taken, and
their weights."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..scene.values import Extent, Listener, Vector

_GOLDEN = (1 + 5**0.5) / 2
_CORNERS = np.array(
    [
        vector
        for a in (-1, 1)
        for b in (-_GOLDEN, _GOLDEN)
        for vector in ((0, a, b), (a, b, 0), (b, 0, a))
    ]
)
_CORNERS *= (5 / 7) ** 0.5 / np.linalg.norm(_CORNERS[0])

WEIGHTS: FloatArray = np.array([4 / 25, *[7 / 100] * 12])
"""Weights of the centre and the twelve points around it; the weighted mean over a ball is exact for
polynomials up to degree 5."""


def points_in(listener: Listener) -> list[Vector]:
    """The points other than the centre over which a listener takes the mean: corners of an
    icosahedron in world axes."""
    if listener.extent is not Extent.MEAN_POWER or listener.radius == 0:
        return []
    places = np.array(listener.position) + listener.radius * _CORNERS
    return [tuple(place) for place in places.tolist()]
