"""Upper bounds on the gains of signals at contacts, so that only contacts are computed where a signal can be felt."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, ranges

_FEW = 8
"""Number of starts up to which each is examined by itself."""


@dataclass(frozen=True, slots=True)
class GainBound:
    """Upper bound on the gain of signals, by body.

    Signals start at ``positions`` (k, 3) [m] on ``bodies`` (k,) with at most ``strengths`` (k,); the gain through body b over d metres is
    at most ``factor[b] * exp(-decay[b] * d)``, that of any contact at most ``transmission``. Signals below ``threshold`` are ignored; 0
    wants everything that is connected. The starts are the sources or the listeners, whichever are fewer: paths can be followed in either
    direction. With ``from_impacts`` signals also start at the impacts of the frame, with strength 1.
    """

    bodies: IntArray
    positions: FloatArray
    strengths: FloatArray
    factor: FloatArray
    decay: FloatArray
    threshold: float
    transmission: float = 1.0
    from_impacts: bool = False

    def wanted(self, first: IntArray, second: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
        """Which possible contacts of bodies ``first`` and ``second`` (p,), somewhere between ``low`` and ``high`` (3, p) [world], a signal
        can reach.

        The gain at a contact is at most the product of the factors of the bodies on the path and the least decay of any body over the
        straight distance.
        """
        if len(self.bodies) == 0 or len(first) == 0:
            return np.zeros(len(first), dtype=np.bool_)
        if float(np.max(self.factor, initial=0.0)) > 1 or self.transmission > 1:
            return np.ones(len(first), dtype=np.bool_)
        limit = self.threshold * (1 - 1e-9)
        fading = np.exp(-max(0.0, float(np.min(self.decay))) * self._away(low, high))
        near = np.flatnonzero(float(np.max(self.strengths)) * fading >= limit)
        wanted = np.zeros(len(first), dtype=np.bool_)
        wanted[near[self._reached(first[near], second[near], fading[near], limit)]] = True
        return wanted

    def _away(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Distances (p,) of regions from ``low`` to ``high`` (3, p) from the nearest start; for many starts a lower bound, the distance
        from their bounding box."""
        if len(self.positions) > _FEW:
            begin, end = self.positions.min(axis=0)[:, None], self.positions.max(axis=0)[:, None]
            away = np.maximum(np.maximum(low - end, begin - high), 0.0)
            return np.asarray(np.sqrt(np.einsum("ip,ip->p", away, away)))
        starts = self.positions[:, :, None]
        away = np.minimum(np.maximum(starts, low), high)
        away -= starts
        return np.asarray(np.sqrt(np.einsum("kip,kip->kp", away, away).min(axis=0)))

    def _reached(self, first: IntArray, second: IntArray, fading: FloatArray, limit: float) -> BoolArray:
        """Which pairs a signal reaches through others with a gain of at least ``limit``, of which ``fading`` (p,) is due to distance."""
        count, bodies_in_all = len(first), len(self.factor)
        ends = np.concatenate([first, second])
        order = ends.astype(np.min_scalar_type(bodies_in_all)).argsort(kind="stable")  # short numbers are sorted in linear time
        other = np.concatenate([second, first])[order]
        pair = order % max(count, 1)
        fade = fading[pair]
        many_of = np.bincount(ends, minlength=bodies_in_all)
        begin = many_of.cumsum() - many_of
        entering = np.zeros(bodies_in_all)
        np.maximum.at(entering, self.bodies, self.strengths)
        reached, stronger_now = np.zeros(count, dtype=np.bool_), np.zeros(bodies_in_all, dtype=np.bool_)
        bodies = np.flatnonzero(entering)
        while len(bodies):
            many = many_of[bodies]
            steps = ranges(begin[bodies], many)
            value = (entering[bodies] * self.factor[bodies]).repeat(many)
            arrived = ((value * fade[steps] >= limit) & (value > 0)).nonzero()[0]
            steps, value = steps[arrived], value[arrived] * self.transmission
            reached[pair[steps]] = True
            # Stronger by more than rounding, so that the search ends on rings of bodies.
            ahead = other[steps]
            stronger = (value > entering[ahead] * (1 + 1e-12)).nonzero()[0]
            ahead = ahead[stronger]
            np.maximum.at(entering, ahead, value[stronger])
            stronger_now[ahead] = True
            bodies = stronger_now.nonzero()[0]
            stronger_now[bodies] = False
        return reached
