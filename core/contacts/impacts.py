"""Impacts: pairs of bodies that begin to touch with enough energy, at a time between two frames.

Until they hit, both bodies follow the paths that their motion before extrapolates to (`motion`).
`time_of_impact` finds where two paths meet; whether the bodies really hit there is judged by their
poses at the end of the interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cache

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from .motion import Paths
from .narrow.frames import turned, turned_back

SLOWEST = 0.05
"""Speed of approach [m/s] below which there is no hit."""

_PIVOT = 0.38
"""Part of a point's initial height that is left at the middle of the interval, above which the
point has swung down at constant speed (which leaves 1/2) rather than rolled down (which leaves
1/4)."""

SWUNG = 0.5
"""Least speed [m/s] at which a part swings down to hit; corners of a faceted wheel and trembling
bodies come down more slowly."""

_MOST_TURN = 2.0
"""Relative rotation in an interval [rad] up to which ``_PIVOT`` tells swinging from rolling."""

_VISIBLE = 1e-3
"""Metres that the bodies would have moved on after a hit, from which on their final poses must show
the hit."""


@frozen
class Impact:
    """Two bodies (numbers, smaller first) that begin to touch at ``time`` [s]: ``positions`` of the
    contact node on either body [m, world], unit ``normal`` from first to second, ``energy`` [J],
    ``amplitude`` = min(energy / E_max, 1). ``estimated``: by poses at frames alone of what is moved
    by something else than physics."""

    objects: tuple[int, int]
    time: float
    positions: tuple[tuple[float, float, float], tuple[float, float, float]]
    normal: tuple[float, float, float]
    energy: float
    amplitude: float
    estimated: bool = False


@frozen
class Hits:
    """Pairs of bodies that hit each other on their paths.

    Attributes:
        pairs: (k, 2) numbers of the bodies.
        after: (k,) time at which the paths meet, from the start of the interval [s].
        time: (k,) time of the hit by the trend of the motion before it, likewise [s].
        distance, normal, centre: (k,) [m], (k, 3) and (k, 3) of the patch there.
        approach: (k,) speed of approach along the normal [m/s].
        poses: (k, 2, 12) of the bodies at the hit.
        velocities, spins: (k, 2, 3) of their origins [m/s], and about them [rad/s].
        expected: (k,) signed distance at the end of the interval on the paths [m].
        actual: (k,) signed distance in the actual poses then [m].
        passes: (k,) whether one body passes right through the other on the paths.
    """

    pairs: IntArray
    after: FloatArray
    time: FloatArray
    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    approach: FloatArray
    poses: FloatArray
    velocities: FloatArray
    spins: FloatArray
    expected: FloatArray
    actual: FloatArray
    passes: BoolArray

    @classmethod
    @cache
    def none(cls) -> Hits:
        """No hits."""
        number = np.zeros(0)
        vector = np.zeros((0, 3))
        no = np.zeros(0, dtype=np.bool_)
        return cls(
            np.zeros((0, 2), dtype=np.int64),
            number,
            number,
            number,
            vector,
            vector,
            number,
            np.zeros((0, 2, 12)),
            np.zeros((0, 2, 3)),
            np.zeros((0, 2, 3)),
            number,
            number,
            no,
        )

    def __len__(self) -> int:
        return len(self.pairs)

    def chosen(self, rows: BoolArray | IntArray) -> Hits:
        """Those hits that ``rows`` select."""
        return Hits(*(getattr(self, f.name)[rows] for f in fields(self)))

    def approaching(self) -> Hits:
        """The hits with a positive speed of approach."""
        return self.chosen(self.approach > SLOWEST)

    def joined(self, other: Hits) -> Hits:
        """These hits followed by those of ``other``."""
        return Hits(
            *(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self))
        )

    def impact(
        self, k: int, time: float, energy: float, full_energy: float, estimated: bool
    ) -> Impact:
        """Hit number ``k`` at ``time`` [s] with ``energy`` [J]; ``full_energy`` [J] gives amplitude
        1."""
        first, second = self.pairs[k].tolist()
        place = self.centre[k], self.normal[k], float(self.distance[k])
        return impact_at((first, second), time, place, energy, full_energy, estimated)


def impact_at(
    objects: tuple[int, int],
    time: float,
    place: tuple[FloatArray, FloatArray, float],
    energy: float,
    full_energy: float,
    estimated: bool,
) -> Impact:
    """The impact of two ``objects`` at ``time`` [s]: its amplitude is ``energy`` divided by
    ``full_energy`` [J], at most 1. ``place``: its centre (3,), normal (3,) and distance [m]."""
    centre, normal, distance = place
    gap = normal * (distance / 2)
    (ax, ay, az), (bx, by, bz) = (centre - gap).tolist(), (centre + gap).tolist()
    nx, ny, nz = normal.tolist()
    return Impact(
        objects,
        time,
        ((ax, ay, az), (bx, by, bz)),
        (nx, ny, nz),
        energy,
        min(energy / full_energy, 1.0),
        estimated,
    )


def landings(
    paths: Paths,
    pairs: IntArray,
    nodes: FloatArray,
    away: FloatArray,
    normal: FloatArray,
    distance: FloatArray,
    apart: float,
) -> Hits:
    """Hits of ``pairs`` (p, 2) that touched throughout, such as a rod that stands on one end and
    falls onto the other.

    A hit needs material at the new contact that swung down: at the start of the interval it was
    more than ``apart`` metres away from the other body. Material that rolls into contact arrives
    without speed; where bodies slide, the material of one of them stays the same.

    The speed of approach is the greater of the means over this interval and the one before: the hit
    that turned the bodies and this one may lie in consecutive intervals. Two hits of a pair within
    one interval count as one.

    Args:
        paths: of all bodies.
        pairs: numbers of the bodies (p, 2).
        nodes: positions of the contact on either body at the end of the interval (2, 3, p) [m,
            world].
        away: distance from the nodes to the nearest material of the former contact, on the body
            where that is less (p,) [m].
        normal: from first to second (3, p).
        distance: of the bodies (p,) [m].
        apart: least distance from which material counts as having swung down [m].
    """
    count = len(pairs)
    before_hit = paths.chosen(pairs.T.reshape(-1))
    ends = before_hit.through_ends()
    before, start, half = _gaps(
        (ends.earlier, ends.start, ends.poses(np.arange(2 * count), ends.duration / 2)),
        ends.end,
        nodes,
        normal,
    )
    spin = ends.spin[:, count:] - ends.spin[:, :count]
    turn = np.sqrt((spin * spin).sum(axis=0)) * paths.duration
    approach = np.maximum(start / paths.duration, (before - start) / paths.earlier_duration)
    swung = (start > apart) & (half >= _PIVOT * start) & (turn < _MOST_TURN) & (away > start)
    rows = np.flatnonzero(swung & (approach > SWUNG))
    if len(rows) == 0:
        return Hits.none()
    pairs = pairs[rows]
    distance = distance[rows]
    approach = approach[rows]
    after = start[rows] / approach
    return Hits(
        pairs=pairs,
        after=after,
        time=after,
        distance=distance,
        normal=normal[:, rows].T,
        centre=nodes[:, :, rows].mean(axis=0).T,
        approach=approach,
        poses=_both(ends.end, rows, count),
        velocities=_both(before_hit.velocity, rows, count),
        spins=_both(before_hit.spin, rows, count),
        expected=distance,
        actual=distance,
        passes=np.zeros(len(rows), dtype=np.bool_),
    )


def _both(values: FloatArray, rows: IntArray, count: int) -> FloatArray:
    """Of ``values`` (..., 2p), of the first and then the second bodies of ``count`` pairs, those
    (k, 2, ...) of both bodies of some."""
    return np.stack([values[:, rows + side * count].T for side in (0, 1)], axis=1)


def _gaps(
    poses: Sequence[FloatArray], end: FloatArray, nodes: FloatArray, normal: FloatArray
) -> FloatArray:
    """Distances (k, p) along ``normal`` between the material that is at ``nodes`` (2, 3, p) at the
    ``end``, in each of the k ``poses``. All poses are (12, 2p): those of the first bodies, then
    those of the second."""
    place = np.concatenate(nodes, axis=1)
    local = turned_back(end[:9].reshape(3, 3, -1), place - end[9:])
    then = np.concatenate(poses, axis=1)
    count = len(poses)
    moved = (
        turned(then[:9].reshape(3, 3, -1), np.tile(local, count)) + then[9:] - np.tile(place, count)
    )
    along = (moved * np.tile(normal, 2 * count)).sum(axis=0).reshape(count, 2, -1)
    return np.asarray(along[:, 1] - along[:, 0])


def confirmed(hits: Hits, paths: Paths, tolerance: FloatArray) -> BoolArray:
    """Which hits agree with the poses of the bodies at the end of the interval, where bodies touch
    up to gaps of ``tolerance`` (k,) [m].

    Where a hit leaves enough time to show, the bodies must be further apart than on their paths, or
    deep in each other, or have passed through each other; otherwise they must touch. What may have
    braked before it touched strikes only where it touches, or something else moves. Of several
    hits of one body the first counts, and later ones only if those bodies touch as well, unless the
    body's path is certain.
    """
    remaining = hits.approach * (paths.duration - hits.after)
    stopped = hits.actual - hits.expected >= 0.3 * remaining
    shows = remaining >= _VISIBLE
    deep = hits.actual <= np.minimum(-_VISIBLE, -0.3 * remaining)
    touching = hits.actual <= tolerance
    real = (hits.approach > SLOWEST) & (
        (shows & stopped) | (~shows & touching) | deep | hits.passes
    )
    # Where what braked is still apart, the motion of the other body must show the hit.
    both = hits.pairs
    still = (paths.start[:, both] == paths.end[:, both]).all(axis=0)
    eased = (paths.eased[both] | paths.certain[both] | still).all(axis=1)
    eased &= paths.eased[both].any(axis=1) & (hits.actual > _VISIBLE)
    real &= ~eased
    deflected: dict[int, float] = dict.fromkeys(np.flatnonzero(paths.turned).tolist(), -np.inf)
    for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.after)).tolist():
        if not real[k]:
            continue
        time = float(hits.after[k])
        if not touching[k] and any(
            deflected.get(body, np.inf) < time - 1e-3 for body in hits.pairs[k].tolist()
        ):
            real[k] = False
            continue
        for body in hits.pairs[k].tolist():
            if not paths.certain[body]:
                deflected.setdefault(body, time)
    return real
