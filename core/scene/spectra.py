"""How the energy of sources spreads over the frequency bands."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..arrays import FloatArray
from ..signals import DEFAULT_IMPACT, DEFAULT_PERSISTENT, Signal
from .bands import BAND_COUNT, BAND_EDGES
from .choices import SourceKind
from .values import Source

_RATE = 2000
_SECONDS = 1.0
_STRONG = 0.1
"""Part of the energy from which on a band counts as one in which a source is strong."""


def source_energies(sources: Sequence[Source]) -> FloatArray:
    """Energies (s, bands) of the first second of each source, its amplitude included; what lies outside all bands is in the outer ones."""
    return np.array([_energies(source) * source.amplitude**2 for source in sources]).reshape(-1, BAND_COUNT)


def leading_band(source: Source) -> int:
    """The lowest band in which a source is strong: of what it emits, what arrives furthest away. The lowest one of all where it is silent
    in its first second."""
    energies = _energies(source)
    return int((energies > _STRONG * energies.sum()).argmax())


def _energies(source: Source) -> FloatArray:
    return _signal_energies(source.signal or (DEFAULT_PERSISTENT if source.kind is SourceKind.PERSISTENT else DEFAULT_IMPACT))


@lru_cache(maxsize=256)
def _signal_energies(signal: Signal) -> FloatArray:
    count = round(_RATE * _SECONDS)
    band = np.clip(np.searchsorted(BAND_EDGES, np.fft.rfftfreq(count, 1 / _RATE), side="right") - 1, 0, BAND_COUNT - 1)
    energies = np.bincount(band, np.abs(np.fft.rfft(signal.sample(0, count, _RATE))) ** 2, BAND_COUNT) / count**2
    energies.setflags(write=False)
    return energies
