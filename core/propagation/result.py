"""What propagation returns: gains of every (source, listener) pair, paths and counts."""

from __future__ import annotations

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
        gain: (s, l); of a sum over paths a lower bound where it is ``limited``.
        paths: (s, l) number of paths summed.
        limited: (s, l) whether limits have cut off paths from the source of a sum.
        silenced: (s, l) whether a setting silences the listener for the source, so that nothing was
            computed: mode SD, or amplitude 0.
        best_path: nodes of the best path by (source, listener).
        strategy: of each source.
        band_gain: (s, l, bands), or None where no function uses bands.
        delay: (s, l) [s] of the best path, or None where no function has a wave speed.
        warnings: what the user should know about these gains.
        statistics: counts of what was done.
    """

    gain: FloatArray
    paths: IntArray
    limited: BoolArray
    silenced: BoolArray
    best_path: Mapping[tuple[int, int], tuple[int, ...]]
    strategy: tuple[str, ...]
    band_gain: FloatArray | None = None
    delay: FloatArray | None = None
    warnings: tuple[Message, ...] = ()
    statistics: Mapping[str, int | float] = field(default_factory=dict)

    @classmethod
    def of_gains(
        cls, gain: FloatArray, band_gain: FloatArray | None = None, delay: FloatArray | None = None
    ) -> Propagation:
        """Gains that were stored without their paths."""
        no = np.zeros(gain.shape, dtype=np.bool_)
        uncounted = np.zeros(gain.shape, dtype=np.int64)
        return cls(gain, uncounted, no, no, {}, ("",) * len(gain), band_gain, delay)

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
