"""Impacts: two bodies that begin to touch with enough energy, at a time between two frames.

Up to the hit both bodies are on the ways that their motion before extrapolates to (`motion`). Where these ways meet, the time is found on
them: by conservative advancement (Mirtich 1996) where the bodies move far compared with their thickness, by regula falsi on their signed
distance otherwise. That they have met is then judged by where the bodies really are at the end of the interval.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from .closed_forms import dot, turned
from .motion import Paths
from .narrow_phase import NarrowPhase, relative_pose
from .settings import ImpactEnergy
from .shapes import transformed_bounds

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_TOUCH = 1e-4
"""Metres of distance at which two bodies on their ways count as touching."""

_MOST_STEPS = 40

_SLOW = 0.05
"""Metres per second of approach below which nothing is hit."""

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
    """Pairs (k, 2) whose ways meet ``after`` (k,) seconds, with ``distance`` (k,), ``normal`` (k, 3) and ``centre`` (k, 3) there,
    ``approach`` (k,) [m/s] along the normal, velocities (k, 2, 3) of the bodies' origins, ``ahead`` (k,) the signed distance at the end
    of the ways, ``passes`` (k,) whether one goes right through the other."""

    pairs: IntArray
    after: FloatArray
    distance: FloatArray
    normal: FloatArray
    centre: FloatArray
    approach: FloatArray
    velocities: FloatArray
    ahead: FloatArray
    passes: BoolArray

    def __len__(self) -> int:
        return len(self.pairs)

    def chosen(self, rows: BoolArray) -> Hits:
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
        self._bounds = bounds
        self._radius = np.sqrt((np.abs(bounds).max(axis=1) ** 2).sum(axis=1)) if len(bounds) else np.zeros(0)
        self._thickness = np.ptp(bounds, axis=1).min(axis=1) if len(bounds) else np.zeros(0)

    def hits(self, paths: Paths, pairs: IntArray) -> Hits:
        """The hits among ``pairs`` (p, 2)."""
        pairs = self._may_meet(paths, pairs)
        if len(pairs) == 0:
            none, vectors = np.zeros(0), np.zeros((0, 3))
            return Hits(pairs, none, none, vectors, vectors, none, np.zeros((0, 2, 3)), none, np.zeros(0, dtype=np.bool_))
        relative = paths.velocities(pairs[:, 1], paths.duration / 2) - paths.velocities(pairs[:, 0], paths.duration / 2)
        travel = np.sqrt(dot(relative, relative)) * paths.duration
        far = travel > self._thickness[pairs].sum(axis=1) / 4
        ways = _Ways(self._narrow, paths, pairs, travel + self._radius[pairs].min(axis=1))
        ahead = ways.clearances(np.full(len(pairs), paths.duration))
        start = ways.clearances(np.zeros(len(pairs)))
        after = np.where(start <= _TOUCH, 0.0, np.inf)
        slow = np.flatnonzero(~far & (start > _TOUCH) & (ahead <= 0))
        after[slow] = ways.chosen(slow).first_touch(start[slow], ahead[slow])
        fast = np.flatnonzero(far & (start > _TOUCH))
        after[fast] = ways.chosen(fast).advanced(self._radius[pairs[fast]])
        met = np.flatnonzero(after <= paths.duration)
        ways, pairs, after = ways.chosen(met), pairs[met], after[met]
        distance, normal, centre = ways.patches(after)
        velocities = np.stack([paths.velocities(pairs[:, k], after) for k in (0, 1)], axis=1)
        return Hits(
            pairs=pairs,
            after=after,
            distance=distance,
            normal=normal,
            centre=centre,
            approach=ways.approach(after, normal, centre),
            velocities=velocities,
            ahead=ahead[met],
            passes=far[met] & ways.goes_through(after, 0.25 * self._thickness[pairs].min(axis=1)),
        )

    def _may_meet(self, paths: Paths, pairs: IntArray) -> IntArray:
        """Those of ``pairs`` whose bounding boxes meet when one stands and the other moves as it does relative to it."""
        if len(pairs) == 0:
            return pairs
        bodies, index = np.unique(pairs, return_inverse=True)
        index = index.reshape(-1, 2)
        boxes = self.bounds(paths, bodies, 0.0)
        spin = paths.spins(bodies)
        turning = np.minimum(np.sqrt((spin**2).sum(axis=1)) * paths.duration, 2.0) * self._radius[bodies]
        move = paths.velocity[bodies] * paths.duration + paths.acceleration[bodies] * (paths.duration**2 / 2)
        sag = np.abs(paths.acceleration[bodies]).sum(axis=1) * (paths.duration**2 / 8)
        a, b = index.T
        relative = move[b] - move[a]
        slack = (turning[a] + turning[b] + sag[a] + sag[b] + 1e-3)[:, None]
        low = boxes[b, 0] + np.minimum(relative, 0.0) - slack
        high = boxes[b, 1] + np.maximum(relative, 0.0) + slack
        return np.asarray(pairs[((low <= boxes[a, 1]) & (high >= boxes[a, 0])).all(axis=1)])

    def bounds(self, paths: Paths, bodies: IntArray, time: float) -> FloatArray:
        """World bounds (k, 2, 3) of ``bodies`` (k,) on their ways at ``time``."""
        return transformed_bounds(self._bounds[bodies], paths.matrices(bodies, time))

    def ahead(self, paths: Paths, pairs: IntArray, reach: FloatArray) -> FloatArray:
        """Signed distances (p,) of ``pairs`` at the end of their ways, exact up to ``reach`` (p,)."""
        return _Ways(self._narrow, paths, pairs, reach).clearances(np.full(len(pairs), paths.duration))


class _Ways:
    """Pairs of bodies on their ways, each at a time of its own."""

    def __init__(
        self, narrow: NarrowPhase, paths: Paths, pairs: IntArray, reach: FloatArray, spins: tuple[FloatArray, FloatArray] | None = None
    ) -> None:
        self._narrow = narrow
        self._paths = paths
        self._pairs = pairs
        self._reach = reach
        self._spins = spins or (paths.spins(pairs[:, 0]), paths.spins(pairs[:, 1]))

    def chosen(self, rows: IntArray | BoolArray) -> _Ways:
        return _Ways(self._narrow, self._paths, self._pairs[rows], self._reach[rows], (self._spins[0][rows], self._spins[1][rows]))

    def _matrices(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        a, b = (self._paths.matrices(self._pairs[:, k], time, self._spins[k]) for k in (0, 1))
        return a, b

    def clearances(self, time: FloatArray) -> FloatArray:
        return self._narrow.clearances(self._pairs, *self._relative(time), self._reach)

    def _relative(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        a, b = (np.concatenate([m[:, :3, :3].reshape(-1, 9).T, m[:, :3, 3].T]) for m in self._matrices(time))
        return relative_pose(a, b)

    def patches(self, time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Distances (k,), and normals and centres (k, 3) in the world."""
        found = self._narrow.query(self._pairs, *self._relative(time), np.full(len(self._pairs), np.inf))
        first, _ = self._matrices(time)
        return found.distance, turned(first[:, :3, :3], found.normal.T), turned(first[:, :3, :3], found.centre.T) + first[:, :3, 3]

    def approach(self, time: FloatArray, normal: FloatArray, point: FloatArray) -> FloatArray:
        """Speed (k,) at which the material of the two bodies at ``point`` (k, 3) comes together along ``normal``."""
        speeds = []
        for k in (0, 1):
            origin = self._matrices(time)[k][:, :3, 3]
            speeds.append(self._paths.velocities(self._pairs[:, k], time) + np.cross(self._spins[k], point - origin))
        return dot(speeds[0] - speeds[1], normal)

    def first_touch(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Times (k,) at which the distance, ``start`` > 0 at first and ``end`` <= 0 at last, vanishes (Illinois' regula falsi)."""
        count = len(start)
        low, high = np.zeros(count), np.full(count, self._paths.duration)
        f_low, f_high = start.copy(), end.copy()
        result = high.copy()
        active = np.arange(count)
        side = np.zeros(count, dtype=np.int64)
        for _ in range(_MOST_STEPS):
            if len(active) == 0:
                break
            a, b, fa, fb = low[active], high[active], f_low[active], f_high[active]
            t = np.clip((a * -fb + b * fa) / np.maximum(fa - fb, 1e-300), a, b)
            f = self.chosen(active).clearances(t)
            result[active] = t
            before = f > 0
            low[active] = np.where(before, t, a)
            high[active] = np.where(before, b, t)
            f_low[active] = np.where(before, f, np.where(side[active] == -1, fa / 2, fa))
            f_high[active] = np.where(before, np.where(side[active] == 1, fb / 2, fb), f)
            side[active] = np.where(before, 1, -1)
            active = active[(np.abs(f) > _TOUCH) & (high[active] - low[active] > 1e-7)]
        return result

    def advanced(self, radius: FloatArray) -> FloatArray:
        """Times (k,) of the first touch, infinite where there is none. ``radius`` (k, 2) of the bodies about their origins.

        The distance along the normal can't shrink faster than the bodies move along it, so that it is safe to step on by the one over the
        other.
        """
        duration = self._paths.duration
        bends = [self._paths.acceleration[self._pairs[:, k]] for k in (0, 1)]
        bending = np.sqrt(dot(bends[1] - bends[0], bends[1] - bends[0]))
        turns = [np.sqrt(dot(spin, spin)) for spin in self._spins]
        turning = turns[0] * radius[:, 0] + turns[1] * radius[:, 1]
        time = np.zeros(len(self._pairs))
        result = np.full(len(time), np.inf)
        active = np.arange(len(time))
        for _ in range(_MOST_STEPS):
            if len(active) == 0:
                break
            ways = self.chosen(active)
            turn, offset = ways._relative(time[active])
            distance, normal = self._narrow.directed_clearances(ways._pairs, turn, offset, ways._reach)
            normal = turned(ways._matrices(time[active])[0][:, :3, :3], normal)
            touching = distance <= _TOUCH
            result[active[touching]] = time[active[touching]]
            relative = self._paths.velocities(ways._pairs[:, 0], time[active]) - self._paths.velocities(ways._pairs[:, 1], time[active])
            speed = np.maximum(dot(relative, normal), 0.0) + bending[active] * (duration - time[active]) + turning[active]
            time[active] += np.maximum(distance, _TOUCH / 2) / np.maximum(speed, 1e-9)
            active = active[~touching & (time[active] <= duration)]
        return result

    def goes_through(self, after: FloatArray, depth: FloatArray) -> BoolArray:
        """Whether the two overlap by ``depth`` (k,) somewhere later on their ways."""
        deepest = np.full(len(self._pairs), np.inf)
        for share in (0.1, 0.25, 0.4, 0.6, 0.8):
            deepest = np.minimum(deepest, self.clearances(after + share * (self._paths.duration - after)))
        return np.asarray(deepest <= -depth)


def took_place(hits: Hits, duration: float, actual: FloatArray, tolerance: float) -> BoolArray:
    """Which hits are borne out by the ``actual`` (k,) distances at the end of the interval.

    Where the hit left enough way to show, the bodies must be further apart than their ways would have had it, or deep in each other, or
    have passed through each other; where not, they must touch. Of hits on one body the first counts, and later ones only if those touch,
    too.
    """
    way = hits.approach * (duration - hits.after)
    stopped = actual - hits.ahead >= 0.3 * way
    shows = way >= _VISIBLE
    deep = actual <= np.minimum(-_VISIBLE, -0.3 * way)
    touching = actual <= tolerance
    real = (hits.approach > _SLOW) & ((shows & stopped) | (~shows & touching) | deep | hits.passes)
    spent: dict[int, float] = {}
    for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.after)).tolist():
        if not real[k]:
            continue
        time = float(hits.after[k])
        if not touching[k] and any(spent.get(body, np.inf) < time - 1e-3 for body in hits.pairs[k].tolist()):
            real[k] = False
            continue
        for body in hits.pairs[k].tolist():
            spent.setdefault(body, time)
    return real


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
