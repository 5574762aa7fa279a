"""What propagation returns: gains of every (source, listener) pair with their error bounds, paths and counts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..arrays import FloatArray, IntArray
from ..message import Message


@dataclass(frozen=True, slots=True)
class Propagation:
    """Gains from sources to listeners; amplitudes of the sources are not included.

    ``gain`` (s, l); ``error_bound`` (s, l) absolute: the true value lies within ``gain ± error_bound``; ``paths`` (s, l) number of
    paths counted, -1 where the sum was not an enumeration; ``best_path`` maps (source, listener) indices to the nodes of the best path;
    ``band_gain`` (s, l, bands) or None; ``delay`` (s, l) [s] of the best path or None; ``taps`` maps (source, listener) to
    (delay, gain) pairs of the strongest paths where delays are used; ``strategy`` per source;
    ``statistics`` counts of what was done and what was skipped.
    """

    gain: FloatArray
    error_bound: FloatArray
    paths: IntArray
    best_path: Mapping[tuple[int, int], tuple[int, ...]]
    strategy: tuple[str, ...]
    band_gain: FloatArray | None = None
    delay: FloatArray | None = None
    taps: Mapping[tuple[int, int], tuple[tuple[float, float], ...]] = field(default_factory=dict)
    warnings: tuple[Message, ...] = ()
    statistics: Mapping[str, int | float] = field(default_factory=dict)
