"""Impacts: two bodies that begin to touch with enough energy, at a time between two frames.

Up to the hit both bodies are on the ways that their motion before extrapolates to (`motion`). Where these ways meet, the time is found on
them: by conservative advancement (Mirtich 1996) where the bodies move far compared with their thickness, by regula falsi on their signed
distance otherwise. That they have met is then judged by where the bodies really are at the end of the interval.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from .motion import Paths
from .narrow.frames import relative_pose
from .narrow.narrow_phase import NarrowPhase
from .settings import ImpactEnergy

_TOUCH = 1e-4
"""Metres of distance at which two bodies on their ways count as touching."""

_INSTANT = 1e-4
"""Seconds that the time of a hit may be off."""

_AROUND = 0.05
"""Metres from each other within which bodies are when they hit, the time being as exact as it is."""

_MOST_STEPS = 40

_SLOW = 0.05
"""Metres per second of approach below which nothing is hit."""

_PIVOT = 0.38
"""Share of a point's height at the start of an interval that is left at mid-interval, above which the point has swung down at constant
speed (1/2) rather than rolled down onto its place (1/4)."""

_SWUNG = 0.5
"""Metres per second at which a part must swing down to hit: the corners of a faceted wheel, and what trembles, come down more slowly."""

_MOST_TURN = 2.0
"""Radians of relative rotation in an interval up to which that share tells swinging from rolling."""

_VISIBLE = 1e-3
"""Metres of way after a hit from which on it must show where a body is at the end of the interval."""


@dataclass(frozen=True, slots=True)
class Impact:
    """Two bodies (numbers, smaller first) that begin to touch. ``time`` [s]; ``positions`` of the contact node on either body then
    [m, world]; unit ``normal`` from first to second; ``energy`` [J]; ``amplitude`` = min(energy / E_max, 1)."""

    objects: tuple[int, int]
    time: float
    positions: tuple[tuple[float, float, float], tuple[float, float, float]]
    normal: tuple[float, float, float]
    energy: float
    amplitude: float


@dataclass(frozen=True, slots=True)
class Hits:
    """Pairs (k, 2) whose ways meet ``after`` (k,) seconds, with ``distance`` (k,), ``normal`` (k, 3) and ``centre`` (k, 3) of the patch
    there, ``approach`` (k,) [m/s] along the normal, velocities (k, 2, 3) of the bodies' origins, the signed distances ``ahead`` (k,) at
    the end of the ways and ``actual`` (k,) where they really are then, ``passes`` (k,) whether one goes right through the other."""

    pairs: IntArray
    after: FloatArray
    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    approach: FloatArray
    velocities: FloatArray
    ahead: FloatArray
    actual: FloatArray
    passes: BoolArray

    @classmethod
    def none(cls) -> Hits:
        """No hits."""
        number, vector = np.zeros(0), np.zeros((0, 3))
        no = np.zeros(0, dtype=np.bool_)
        return cls(np.zeros((0, 2), dtype=np.int64), number, number, vector, vector, number, np.zeros((0, 2, 3)), number, number, no)

    def __len__(self) -> int:
        return len(self.pairs)

    def chosen(self, rows: BoolArray | IntArray) -> Hits:
        """Some of the hits."""
        return Hits(*(getattr(self, f.name)[rows] for f in fields(self)))

    def approaching(self) -> Hits:
        """Those at which the bodies come together."""
        return self.chosen(self.approach > _SLOW)

    def joined(self, other: Hits) -> Hits:
        """These and others."""
        return Hits(*(np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)))

    def impact(self, k: int, time: float, energy: float, full_energy: float) -> Impact:
        """Hit number ``k`` at ``time`` [s] with ``energy`` [J], of which ``full_energy`` gives amplitude 1."""
        gap = self.normal[k] * (self.distance[k] / 2)
        a, b = self.pairs[k].tolist()
        (ax, ay, az), (bx, by, bz) = (self.centre[k] - gap).tolist(), (self.centre[k] + gap).tolist()
        nx, ny, nz = self.normal[k].tolist()
        return Impact((a, b), time, ((ax, ay, az), (bx, by, bz)), (nx, ny, nz), energy, min(energy / full_energy, 1.0))


class Meetings:
    """Where the ways of bodies meet. ``bounds`` (n, 2, 3): of the shapes in local space."""

    def __init__(self, narrow: NarrowPhase, bounds: FloatArray) -> None:
        self._narrow = narrow
        self._radius = np.sqrt((np.abs(bounds).max(axis=1) ** 2).sum(axis=1))
        self._thickness = narrow.thickness

    def may_meet(self, paths: Paths, first: IntArray, second: IntArray, low: FloatArray, high: FloatArray) -> BoolArray:
        """Which pairs have bounding boxes that meet when one stands and the other moves as it does relative to it; ``low`` and ``high``
        (3, n) of the boxes at the start."""
        turning = np.minimum(np.sqrt((paths.spin**2).sum(axis=0)) * paths.duration, 2.0) * self._radius
        turning += np.abs(paths.acceleration).sum(axis=0) * (paths.duration**2 / 8)
        move = paths.displacement()
        relative = move[:, second] - move[:, first]
        slack = turning[first] + turning[second]
        below = low[:, second] + np.minimum(relative, 0.0) - slack <= high[:, first]
        above = high[:, second] + np.maximum(relative, 0.0) + slack >= low[:, first]
        return np.asarray((below & above).all(axis=0))

    def hits(self, paths: Paths, pairs: IntArray) -> Hits:
        """The hits among ``pairs`` (p, 2)."""
        if len(pairs) == 0:
            return Hits.none()
        a, b = pairs.T
        relative = paths.velocities(b, paths.duration / 2) - paths.velocities(a, paths.duration / 2)
        travel = np.sqrt((relative * relative).sum(axis=0)) * paths.duration
        far = travel > (self._thickness[a] + self._thickness[b]) / 4
        ways = _Ways(self._narrow, paths, pairs, travel + np.minimum(self._radius[a], self._radius[b]))
        ahead = ways.clearances(np.full(len(pairs), paths.duration))
        rows = np.flatnonzero(far | (ahead <= _TOUCH))
        if len(rows) == 0:
            return Hits.none()
        ways, pairs, far, ahead = ways.chosen(rows), pairs[rows], far[rows], ahead[rows]
        a, b = pairs.T
        start, actual = ways.at_either_end()
        after = np.where(start <= _TOUCH, 0.0, np.inf)
        slow = np.flatnonzero(~far & (start > _TOUCH))
        if len(slow):
            after[slow] = ways.chosen(slow).first_touch(start[slow], ahead[slow])
        fast = np.flatnonzero(far & (start > _TOUCH))
        if len(fast):
            after[fast] = ways.chosen(fast).advanced(self._radius[a[fast]] + self._radius[b[fast]])
        met = np.flatnonzero(after <= paths.duration)
        if len(met) == 0:
            return Hits.none()
        ways, after = ways.chosen(met), after[met]
        distance, normal, centre, approach = ways.patches(after)
        passes = far[met]
        fast = np.flatnonzero(passes)
        if len(fast):
            first, second = self._thickness[a[met[fast]]], self._thickness[b[met[fast]]]
            within = (first + second) / np.maximum(approach[fast], _SLOW)
            passes[fast] = ways.chosen(fast).go_through(after[fast], within, np.minimum(first, second) / 4)
        velocities = np.stack([paths.velocities(pairs[met, k], after).T for k in (0, 1)], axis=1)
        return Hits(pairs[met], after, distance, normal, centre, approach, velocities, ahead[met], actual[met], passes)

    def ahead(self, paths: Paths, pairs: IntArray, reach: FloatArray) -> FloatArray:
        """Signed distances (p,) of ``pairs`` at the end of their ways, exact up to ``reach`` (p,)."""
        return _Ways(self._narrow, paths, pairs, reach).clearances(np.full(len(pairs), paths.duration))


def landings(
    paths: Paths, pairs: IntArray, nodes: FloatArray, old_nodes: FloatArray, normal: FloatArray, distance: FloatArray, apart: float
) -> Hits:
    """Hits of ``pairs`` (p, 2) that have touched all along, such as a rod that lies on one end and falls onto the other.

    The material at the contact ``nodes`` (2, 3, p) [world] at the end of the interval, on either body, was more than ``apart`` metres away
    from the other body at its start, along ``normal`` (3, p), and has swung down there, about the material that was the contact before and
    is at ``old_nodes`` (2, 3, p) now. Material that rolls onto its place arrives without speed and hits nothing; what slides stays the same
    material on one of the bodies.

    The speed of approach is the mean one in this interval or in the one before, whichever is greater: that just before the hit is not
    known, since the hit that turned the bodies and this one may lie in consecutive intervals. Two blows of a pair within one interval are
    one.
    """
    ways = paths.to_the_ends()
    middle = ways.poses(np.arange(paths.start.shape[1]), paths.duration / 2)
    before, start, half = (_gaps(pose, paths.end, pairs, nodes, normal) for pose in (paths.earlier, paths.start, middle))
    spin = ways.spin[:, pairs[:, 1]] - ways.spin[:, pairs[:, 0]]
    turn = np.sqrt((spin * spin).sum(axis=0)) * paths.duration
    approach = np.maximum(start / paths.duration, (before - start) / paths.earlier_duration)
    away = np.sqrt(((nodes - old_nodes) ** 2).sum(axis=1)).min(axis=0)
    swung = (start > apart) & (half >= _PIVOT * start) & (turn < _MOST_TURN) & (away > start)
    rows = np.flatnonzero(swung & (approach > _SWUNG))
    if len(rows) == 0:
        return Hits.none()
    pairs, distance, approach = pairs[rows], distance[rows], approach[rows]
    after = start[rows] / approach
    return Hits(
        pairs=pairs,
        after=after,
        distance=distance,
        normal=normal[:, rows].T,
        centre=nodes[:, :, rows].mean(axis=0).T,
        approach=approach,
        velocities=np.stack([ways.velocities(pairs[:, k], after).T for k in (0, 1)], axis=1),
        ahead=distance,
        actual=distance,
        passes=np.zeros(len(rows), dtype=np.bool_),
    )


def _gaps(pose: FloatArray, end: FloatArray, pairs: IntArray, nodes: FloatArray, normal: FloatArray) -> FloatArray:
    """How far the material at ``nodes`` (2, 3, p) of bodies at their ``end`` (12, n) was apart along ``normal`` in ``pose`` (12, n)."""
    gap = np.zeros(len(pairs))
    for side, node in enumerate(nodes):
        then, now = pose[:, pairs[:, side]], end[:, pairs[:, side]]
        local = np.einsum("ijp,ip->jp", now[:9].reshape(3, 3, -1), node - now[9:])
        moved = np.einsum("ijp,jp->ip", then[:9].reshape(3, 3, -1), local) + then[9:] - node
        gap += (2 * side - 1) * (moved * normal).sum(axis=0)
    return gap


class _Ways:
    """Pairs of bodies on their ways, each at a time of its own."""

    def __init__(self, narrow: NarrowPhase, paths: Paths, pairs: IntArray, reach: FloatArray) -> None:
        self._narrow = narrow
        self._paths = paths
        self._pairs = pairs
        self._reach = reach

    def chosen(self, rows: IntArray | BoolArray) -> _Ways:
        return _Ways(self._narrow, self._paths, self._pairs[rows], self._reach[rows])

    def _poses(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        both = self._paths.poses(self._pairs.T.reshape(-1), np.concatenate([time, time]))
        return both[:, : len(time)], both[:, len(time) :]

    def clearances(self, time: FloatArray) -> FloatArray:
        return self._narrow.clearances(self._pairs, *relative_pose(*self._poses(time)), self._reach)

    def at_either_end(self) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) at the start and where the bodies really are at the end."""
        count = len(self._pairs)
        a, b = self._pairs.T
        first, second = (np.concatenate([self._paths.start[:, k], self._paths.end[:, k]], axis=1) for k in (a, b))
        distance = self._narrow.clearances(np.tile(self._pairs, (2, 1)), *relative_pose(first, second), np.tile(self._reach, 2))
        return distance[:count], distance[count:]

    def patches(self, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Distances (k,), normals and centres (k, 3) in the world, and the speed (k,) at which the material of the two comes together along
        the normal there."""
        first, second = self._poses(time)
        found = self._narrow.query(self._pairs, *relative_pose(first, second), np.full(len(time), _AROUND))
        turn = first[:9].reshape(3, 3, -1)
        normal = (turn * found.normal).sum(axis=1)
        centre = (turn * found.centre).sum(axis=1) + first[9:]
        speeds = []
        for k, pose in ((0, first), (1, second)):
            bodies = self._pairs[:, k]
            arm = centre - pose[9:]
            speeds.append(self._paths.velocities(bodies, time) + np.cross(self._paths.spin[:, bodies], arm, axis=0))
        return found.distance, normal.T, centre.T, ((speeds[0] - speeds[1]) * normal).sum(axis=0)

    def first_touch(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Times (k,) at which the distance, ``start`` > 0 at first and ``end`` at last, vanishes: regula falsi (Illinois), from where
        bodies that fall onto each other would meet."""
        duration = self._paths.duration
        low, high = np.zeros(len(start)), np.full(len(start), duration)
        f_low, f_high = start.copy(), end.copy()
        bend = self._paths.acceleration[:, self._pairs[:, 1]] - self._paths.acceleration[:, self._pairs[:, 0]]
        pull = np.sqrt((bend * bend).sum(axis=0))
        slope = (start - end) / duration - pull * (duration / 2)
        falling = 2 * start / np.maximum(slope + np.sqrt(np.maximum(slope * slope + 2 * pull * start, 0.0)), 1e-300)
        time = np.where(slope >= 0, np.clip(falling, 0.0, duration), duration * start / np.maximum(start - end, 1e-300))
        enough = np.maximum(_TOUCH, (start - end) / duration * _INSTANT)
        active = np.arange(len(start))
        side = np.zeros(len(start), dtype=np.int64)
        for _ in range(_MOST_STEPS):
            t = time[active]
            f = self.chosen(active).clearances(t)
            before = f > 0
            f_high[active] = np.where(before, np.where(side[active] == 1, f_high[active] / 2, f_high[active]), f)
            f_low[active] = np.where(before, f, np.where(side[active] == -1, f_low[active] / 2, f_low[active]))
            low[active], high[active] = np.where(before, t, low[active]), np.where(before, high[active], t)
            side[active] = np.where(before, 1, -1)
            active = active[(np.abs(f) > enough[active]) & (high[active] - low[active] > 1e-7)]
            if len(active) == 0:
                break
            a, b, fa, fb = low[active], high[active], f_low[active], f_high[active]
            time[active] = np.clip((b * fa - a * fb) / np.maximum(fa - fb, 1e-300), a, b)
        return time

    def advanced(self, radius: FloatArray) -> FloatArray:
        """Times (k,) of the first touch, infinite where there is none. ``radius`` (k,) of the bodies about their origins, added.

        The distance along the normal can't shrink faster than the bodies move along it: so far it is safe to step on.
        """
        duration = self._paths.duration
        a, b = self._pairs.T
        bend = self._paths.acceleration[:, b] - self._paths.acceleration[:, a]
        bending = np.sqrt((bend * bend).sum(axis=0))
        turning = (np.sqrt((self._paths.spin[:, self._pairs.T] ** 2).sum(axis=0)).sum(axis=0)) * radius
        time = np.zeros(len(self._pairs))
        result = np.full(len(time), np.inf)
        active = np.arange(len(time))
        for _ in range(_MOST_STEPS):
            if len(active) == 0:
                break
            ways, now = self.chosen(active), time[active]
            first, second = ways._poses(now)
            distance, normal = self._narrow.directed_clearances(ways._pairs, *relative_pose(first, second), ways._reach)
            touching = distance <= _TOUCH
            result[active[touching]] = now[touching]
            outward = np.einsum("ijp,jp->ip", first[:9].reshape(3, 3, -1), normal)
            relative = self._paths.velocities(a[active], now) - self._paths.velocities(b[active], now)
            speed = np.maximum((relative * outward).sum(axis=0), 0.0) + bending[active] * (duration - now) + turning[active]
            time[active] = now + np.maximum(distance, _TOUCH / 2) / np.maximum(speed, 1e-9)
            active = active[~touching & (time[active] <= duration)]
        return result

    def go_through(self, after: FloatArray, within: FloatArray, depth: FloatArray) -> BoolArray:
        """Which pairs overlap by ``depth`` (k,) somewhere on their ways ``within`` (k,) seconds from the touch."""
        deepest = np.full(len(self._pairs), np.inf)
        for share in (0.2, 0.4, 0.6, 0.8):
            deepest = np.minimum(deepest, self.clearances(np.minimum(after + share * within, self._paths.duration)))
        return np.asarray(deepest <= -depth)


def took_place(hits: Hits, paths: Paths, tolerance: float) -> BoolArray:
    """Which hits are borne out by where the bodies are at the end of the interval.

    Where the hit left enough way to show, they must be further apart than their ways would have had it, or deep in each other, or have
    passed through each other; where not, they must touch. Of hits on one body the first counts, and later ones only if those touch, too,
    unless its way is certain.
    """
    way = hits.approach * (paths.duration - hits.after)
    stopped = hits.actual - hits.ahead >= 0.3 * way
    shows = way >= _VISIBLE
    deep = hits.actual <= np.minimum(-_VISIBLE, -0.3 * way)
    touching = hits.actual <= tolerance
    real = (hits.approach > _SLOW) & ((shows & stopped) | (~shows & touching) | deep | hits.passes)
    spent: dict[int, float] = dict.fromkeys(np.flatnonzero(paths.turned).tolist(), -np.inf)
    for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.after)).tolist():
        if not real[k]:
            continue
        time = float(hits.after[k])
        if not touching[k] and any(spent.get(body, np.inf) < time - 1e-3 for body in hits.pairs[k].tolist()):
            real[k] = False
            continue
        for body in hits.pairs[k].tolist():
            if not paths.certain[body]:
                spent.setdefault(body, time)
    return np.asarray(real)


def impact_energies(hits: Hits, mass: FloatArray, fixed: BoolArray, energy: ImpactEnergy) -> FloatArray:
    """Energies (k,) in joules of hits between bodies of ``mass`` (n,) [kg]; ``fixed`` (n,) ones can't be pushed.

    KINETIC: ``1/2 m1 v1^2 + 1/2 m2 v2^2``, of the velocities of their origins just before. NORMAL: ``1/2 mu v_n^2`` with the reduced mass
    ``mu`` and the speed of approach along the normal.
    """
    masses = mass[hits.pairs]
    if energy is ImpactEnergy.KINETIC:
        return np.asarray((masses * (hits.velocities**2).sum(axis=2)).sum(axis=1) / 2)
    stiff = fixed[hits.pairs]
    first, second = masses.T
    both = np.where(first + second > 0, first * second / np.where(first + second > 0, first + second, 1.0), 0.0)
    reduced = np.where(stiff[:, 0], np.where(stiff[:, 1], 0.0, second), np.where(stiff[:, 1], first, both))
    return np.asarray(reduced * hits.approach**2 / 2)
