"""Impacts of pairs of bodies, and when each pair may make the next one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from .body_table import BodyTable
from .impact_energies import impact_energies
from .impacts import Hits, Impact
from .settings import Body, ContactSettings

_STRONGER = 1.25
"""Factor of the last impact's speed (2 dB) above which another one counts within the refractory
time."""

_TIPPING = 1 / 24
"""Seconds after the refractory time within which another part of a body that still touches may
land, whatever the frame rate."""


class RecentImpacts:
    """The last impact of each pair of bodies, as long as it has an effect."""

    def __init__(self, settings: ContactSettings) -> None:
        self._settings = settings
        self._refractory = max(item.refractory for item in settings.all_limits())
        # By the key of the pair: time [s] and speed of approach [m/s].
        self._last: dict[int, tuple[float, float]] = {}

    def keys(self) -> IntArray:
        """The pairs (k,), by key, ascending."""
        return np.array(sorted(self._last), dtype=np.int64)

    def expire(self, time: float, duration: float) -> None:
        """Drop the impacts that can suppress no later one: their refractory time is over at
        ``time`` [s], the end of a frame of this ``duration`` [s]."""
        longest = self._refractory + max(duration, _TIPPING)
        self._last = {key: last for key, last in self._last.items() if time - last[0] <= longest}

    def renumber(self, rows: IntArray, key: IntArray) -> None:
        """Keep those of some of the `keys`, by row, under a new key."""
        last = [self._last[old] for old in self.keys()[rows].tolist()]
        self._last = dict(zip(key.tolist(), last, strict=True))

    def history(self, time: float) -> FloatArray:
        """Pairs, times and speeds (k, 3) that matter from ``time`` on."""
        since = time - self._refractory - _TIPPING
        return np.array(
            [(key, *last) for key, last in sorted(self._last.items()) if last[0] >= since]
        )

    def of(
        self,
        hits: Hits,
        begin: float,
        struck: BoolArray,
        estimated: BoolArray,
        bodies: Sequence[Body],
        table: BodyTable,
    ) -> tuple[Impact, ...]:
        """The impacts that hits with enough energy make, by time.

        Args:
            hits: in the last interval (k,).
            begin: of that interval [s].
            struck: whether the pair has not parted since its last impact (k,). Such a pair, and any
                within its refractory time, makes another one only by a clearly stronger hit.
            estimated: as of `Impact` (k,).
            bodies: by number.
            table: of the bodies.
        """
        energies = (
            impact_energies(hits, bodies, table, self._settings.energy)
            / self._settings.time_scale**2
        )
        keys = table.keys(hits.pairs).tolist()
        impacts = []
        for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.time)).tolist():
            a, b = hits.pairs[k].tolist()
            when = begin + float(hits.time[k])
            last, speed = self._last.get(keys[k], (-np.inf, 0.0))
            limits = self._settings.impact_limits(bodies[a].named, bodies[b].named)
            again = struck[k] or when - last < limits.refractory
            resting = again and hits.approach[k] < _STRONGER * speed
            if energies[k] < (limits.least_energy or 0.0) or resting:
                continue
            self._last[keys[k]] = when, float(hits.approach[k])
            full = limits.full_energy or table.full_energy
            impacts.append(hits.impact(k, when, float(energies[k]), full, bool(estimated[k])))
        return tuple(impacts)
