"""What propagation returns: gains of every (source, listener) pair with their error bounds, paths and counts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..message import Message


@dataclass(frozen=True, slots=True)
class Propagation:
    """Gains from s sources to l listeners; amplitudes of the sources are not included.

    Attributes:
        gain: (s, l).
        error_bound: (s, l) absolute: what was asked for lies within ``gain ± error_bound``; infinite where nothing bounds it. Of a sum over
            paths, limited or not, that is the sum over all paths.
        paths: (s, l) number of paths summed, -1 where they were not counted.
        limited: (s, l) whether the limits of a sum over paths may leave out more than the tolerance of it.
        best_path: nodes of the best path by (source, listener).
        strategy: of each source.
        band_gain: (s, l, bands), or None where no function uses bands.
        delay: (s, l) [s] of the best path, or None where no function has a wave speed.
        taps: (delay, gain) pairs of the strongest paths by (source, listener), the strongest first.
        warnings: what the user should know about these gains.
        statistics: counts of what was done; ``walk_radius`` where paths were summed.
    """

    gain: FloatArray
    error_bound: FloatArray
    paths: IntArray
    limited: BoolArray
    best_path: Mapping[tuple[int, int], tuple[int, ...]]
    strategy: tuple[str, ...]
    band_gain: FloatArray | None = None
    delay: FloatArray | None = None
    taps: Mapping[tuple[int, int], tuple[tuple[float, float], ...]] = field(default_factory=dict)
    warnings: tuple[Message, ...] = ()
    statistics: Mapping[str, int | float] = field(default_factory=dict)

    def latest(self, names: Sequence[str]) -> dict[str, float]:
        """The longest delay [s] of each source, by its name, at the listeners that it reaches; nothing where there are no delays."""
        if self.delay is None:
            return {}
        return dict(zip(names, np.where(self.gain > 0, self.delay, 0.0).max(axis=1, initial=0.0).tolist(), strict=True))
