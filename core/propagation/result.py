"""What propagation returns: gains of every (source, listener) pair with their error bounds, paths
and counts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from ..message import Message


@frozen(eq=False)
class Propagation:
    """Gains from s sources to l listeners; amplitudes of the sources are not included.

    Attributes:
        gain: (s, l).
        error_bound: (s, l) absolute: the best path or the sum over all paths lies within ``gain ±
            error_bound``, whatever the limits leave out; infinite where nothing bounds it.
        paths: (s, l) number of paths summed, -1 where they were not counted.
        limited: (s, l) whether the limits may leave out a better path, or more than the tolerance
            of a sum.
        silenced: (s, l) whether a setting silences the listener for the source, so that nothing was
            computed: mode SD, *Localise*, or amplitude 0.
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
    silenced: BoolArray
    best_path: Mapping[tuple[int, int], tuple[int, ...]]
    strategy: tuple[str, ...]
    band_gain: FloatArray | None = None
    delay: FloatArray | None = None
    taps: Mapping[tuple[int, int], tuple[tuple[float, float], ...]] = field(default_factory=dict)
    warnings: tuple[Message, ...] = ()
    statistics: Mapping[str, int | float] = field(default_factory=dict)

    @classmethod
    def of_gains(
        cls, gain: FloatArray, band_gain: FloatArray | None = None, delay: FloatArray | None = None
    ) -> Propagation:
        """Gains that were stored without their paths and error bounds."""
        no = np.zeros(gain.shape, dtype=np.bool_)
        return cls(
            gain,
            np.full(gain.shape, math.inf),
            np.full(gain.shape, -1),
            no,
            no,
            {},
            ("",) * len(gain),
            band_gain,
            delay,
        )

    def longest_delays(self, names: Sequence[str]) -> dict[str, float]:
        """The longest delay [s] of each source, by its name, at the listeners that it reaches;
        empty without delays. ``names``: of all sources."""
        if self.delay is None:
            return {}
        return dict(
            zip(
                names,
                np.where(self.gain > 0, self.delay, 0.0).max(axis=1, initial=0.0).tolist(),
                strict=True,
            )
        )
