"""Energy of sources by frequency band."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..arrays import FloatArray
from ..signals import Signal
from .bands import BAND_COUNT, BAND_EDGES
from .values import Source

_RATE = 2000
_SECONDS = 1.0
_STRONG = 0.1
"""Least fraction of a source's energy in a strong band."""


def leading_band(source: Source) -> int:
    """The lowest strong band of a source, which usually carries furthest; band 0 if it is silent in
    its first second."""
    energies = _energies(source.emitted)
    return int((energies > _STRONG * energies.sum()).argmax())


@lru_cache(maxsize=256)
def _energies(signal: Signal) -> FloatArray:
    """Energies (bands,) of the first second; energy outside all bands is added to the outermost
    ones."""
    count = round(_RATE * _SECONDS)
    band = np.clip(
        np.searchsorted(BAND_EDGES, np.fft.rfftfreq(count, 1 / _RATE), side="right") - 1,
        0,
        BAND_COUNT - 1,
    )
    energies = (
        np.bincount(band, np.abs(np.fft.rfft(signal.sample(0, count, _RATE))) ** 2, BAND_COUNT)
        / count**2
    )
    energies.setflags(write=False)
    return energies
