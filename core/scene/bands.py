"""The frequency bands of the vibrotactile range, shared by propagation, rendering and devices."""

from itertools import pairwise

BAND_EDGES: tuple[float, ...] = (20.0, 40.0, 80.0, 160.0, 320.0, 640.0, 1000.0)
"""Edges in hertz: band `i` lies between `BAND_EDGES[i]` and `BAND_EDGES[i + 1]`; frequencies
outside belong to the outermost bands."""

BAND_COUNT: int = len(BAND_EDGES) - 1

BAND_CENTRES: tuple[float, ...] = tuple((low * high) ** 0.5 for low, high in pairwise(BAND_EDGES))
"""Geometric centre of each band in hertz."""
