"""How the energy of sources spreads over the frequency bands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..scene.bands import BAND_COUNT, BAND_EDGES
from ..scene.values import Source
from ..signals import DEFAULT_IMPACT

_RATE = 2000
_SECONDS = 1.0


def source_energies(sources: Sequence[Source]) -> FloatArray:
    """Energies (s, bands) of the first second of each source, its amplitude included; what lies outside all bands is in the outer ones."""
    energies = np.zeros((len(sources), BAND_COUNT))
    count = round(_RATE * _SECONDS)
    band = np.clip(np.searchsorted(BAND_EDGES, np.fft.rfftfreq(count, 1 / _RATE), side="right") - 1, 0, BAND_COUNT - 1)
    for row, source in enumerate(sources):
        samples = (source.signal or DEFAULT_IMPACT).sample(0, count, _RATE) * source.amplitude
        energies[row] = np.bincount(band, np.abs(np.fft.rfft(samples)) ** 2, BAND_COUNT) / count**2
    return energies
