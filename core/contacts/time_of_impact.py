"""Times of impact: when two moving bodies first touch within an interval.

The time is found on the bodies' paths: by conservative advancement (Mirtich 1996) where they move
far compared with their thickness or one of them is a mesh, by regula falsi on their signed distance
otherwise.
"""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from .impacts import SLOWEST, Hits
from .motion import Paths
from .narrow.body_patches import PairPatches
from .narrow.frames import cross, dot, relative_pose, turned
from .narrow.narrow_phase import NarrowPhase

_TOUCH = 1e-4
"""Metres of distance below which two bodies on their paths count as touching."""

_INSTANT = 1e-4
"""Tolerance of the time of impact [s]."""

_AROUND = 0.05
"""Metres within which bodies are from each other at their computed time of impact."""

_MOST_STEPS = 40

_MOST_STEPS_OF_MESHES = 12


class TimeOfImpact:
    """Finds when the paths of bodies meet. ``bounds`` (n, 2, 3): of the shapes in local space.
    ``unsure``: pairs with a mesh whose time of impact was not found within the allowed steps."""

    def __init__(self, narrow: NarrowPhase, bounds: FloatArray) -> None:
        self._narrow = narrow
        self._radius = np.sqrt((np.abs(bounds).max(axis=1) ** 2).sum(axis=1))
        self._thickness = narrow.thickness
        self.unsure: set[tuple[int, int]] = set()

    def measure(self, number: int, bounds: FloatArray) -> None:
        """Set the size of a body with local ``bounds`` (2, 3)."""
        self._radius[number] = np.sqrt((np.abs(bounds).max(axis=0) ** 2).sum())

    def may_hit(
        self, paths: Paths, first: IntArray, second: IntArray, extents: FloatArray
    ) -> BoolArray:
        """Which pairs (p,) have bounding boxes that overlap at some time on their paths.

        Args:
            paths: of all bodies.
            first: one body of each pair (p,).
            second: the other (p,).
            extents: of the boxes at the start, against and along the axes (2, 3, n) [m].
        """
        turning = (
            np.minimum(np.sqrt((paths.spin**2).sum(axis=0)) * paths.duration, 2.0) * self._radius
        )
        turning += np.abs(paths.acceleration).sum(axis=0) * (paths.duration**2 / 8)
        move = paths.displacement()
        relative = move.take(second, axis=1) - move.take(first, axis=1)
        slack = turning[first] + turning[second]
        low, high = -extents[0], extents[1]
        below = low.take(second, axis=1) + np.minimum(relative, 0.0) - slack <= high.take(
            first, axis=1
        )
        above = high.take(second, axis=1) + np.maximum(relative, 0.0) + slack >= low.take(
            first, axis=1
        )
        return np.asarray((below & above).all(axis=0))

    def largest_approach(self, paths: Paths, first: IntArray, second: IntArray) -> FloatArray:
        """Upper bound (p,) on how much the distance of each pair can shrink on its paths [m].
        ``first``, ``second`` (p,): its bodies."""
        relative = paths.displacement()[:, second] - paths.displacement()[:, first]
        bend = np.sqrt(dot(paths.acceleration, paths.acceleration)) * (paths.duration**2 / 8)
        turn = np.minimum(np.sqrt(dot(paths.spin, paths.spin)) * paths.duration, 2.0) * self._radius
        return np.asarray(
            np.sqrt(dot(relative, relative)) + (bend + turn)[first] + (bend + turn)[second]
        )

    def hits_at(self, meetings: Meetings | None) -> Hits:
        """The hits at ``meetings``, with a query for their patches."""
        return (
            Hits.none()
            if meetings is None
            else meetings.hits(self._narrow.query(*meetings.placing))
        )

    def hits_after(self, paths: Paths, pairs: IntArray, after: FloatArray) -> Hits:
        """The hits of ``pairs`` (p, 2) that touch ``after`` (p,) seconds on their paths."""
        moving = _MovingPairs(self._narrow, paths, pairs)
        poses = moving.poses(after)
        placing = pairs, *relative_pose(*poses), np.full(len(pairs), _AROUND)
        zero, no = np.zeros(len(pairs)), np.zeros(len(pairs), dtype=np.bool_)
        return self.hits_at(Meetings(moving, after, poses, placing, zero, zero, no, no))

    def meetings(self, paths: Paths, pairs: IntArray) -> Meetings | None:
        """The pairs among ``pairs`` (p, 2) that meet on their paths, None if there are none."""
        if len(pairs) == 0:
            return None
        a, b = pairs.T
        relative = paths.velocities(b, paths.duration / 2) - paths.velocities(a, paths.duration / 2)
        travel = np.sqrt(dot(relative, relative)) * paths.duration
        far = travel > (self._thickness[a] + self._thickness[b]) / 4
        moving = _MovingPairs(self._narrow, paths, pairs)
        mesh = self._narrow.is_mesh[a] | self._narrow.is_mesh[b]
        expected, after = np.full((2, len(pairs)), np.inf)
        for rows, touches in (
            ((~mesh).nonzero()[0], self._touches),
            (mesh.nonzero()[0], self._touches_of_meshes),
        ):
            if len(rows):
                apart = far[rows]
                expected[rows], after[rows] = touches(moving.chosen(rows), apart)
                far[rows] = apart
        met = (after <= paths.duration).nonzero()[0]
        if len(met) == 0:
            return None
        moving = moving.chosen(met)
        after = after[met]
        poses = moving.poses(after)
        placing = moving.pairs, *relative_pose(*poses), np.full(len(after), _AROUND)
        return Meetings(
            moving,
            after,
            poses,
            placing,
            expected[met],
            moving.actual_distances(),
            far[met],
            mesh[met],
        )

    def _touches(self, moving: _MovingPairs, far: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Distances (k,) at the end of the paths [m], and times (k,) of the first touch [s],
        infinite where there is none, of pairs without a mesh; ``far`` (k,) as in `Meetings`, to
        which pairs are added whose bodies sweep past each other as they turn."""
        duration = moving.paths.duration
        expected = moving.clearances(np.full(len(far), duration))
        turn = np.sqrt(dot(moving.paths.spin, moving.paths.spin)) * self._radius * duration
        sweeps = turn[moving.pairs].sum(axis=1) > self._thickness[moving.pairs].sum(axis=1) / 4
        far |= sweeps & (expected > _TOUCH)
        after = np.full(len(far), np.inf)
        rows = (far | (expected <= _TOUCH)).nonzero()[0]
        if len(rows) == 0:
            return expected, after
        start = moving.chosen(rows).clearances(np.zeros(len(rows)))
        after[rows[start <= _TOUCH]] = 0.0
        rows = rows[start > _TOUCH]
        start = start[start > _TOUCH]
        slow = (~far[rows]).nonzero()[0]
        fast = far[rows].nonzero()[0]
        if len(slow):
            after[rows[slow]] = moving.chosen(rows[slow]).touch_by_regula_falsi(
                start[slow], expected[rows[slow]]
            )
        if len(fast):
            found = moving.chosen(rows[fast]).touch_by_advancement(self._radius)
            at_end = np.where(expected[rows[fast]] <= _TOUCH, duration, np.inf)
            after[rows[fast]] = np.minimum(found, at_end)
        return expected, after

    def _touches_of_meshes(
        self, moving: _MovingPairs, far: BoolArray
    ) -> tuple[FloatArray, FloatArray]:
        """Distances (k,) at the end of the paths [m] and times (k,) of the first touch [s], as
        `_touches`, of pairs with a mesh. Distances of pairs that can't touch are infinite, because
        those of meshes take long."""
        duration = moving.paths.duration
        start, speed = moving.distances_and_speeds(np.zeros(len(far)), self._radius)
        expected = np.full(len(far), np.inf)
        after = np.where(start <= _TOUCH, 0.0, np.inf)
        possible = (start <= speed * duration).nonzero()[0]
        if len(possible):
            expected[possible] = moving.chosen(possible).clearances(
                np.full(len(possible), duration)
            )
        rows = possible[start[possible] > _TOUCH]
        if len(rows):
            after[rows], unsure = moving.chosen(rows).touch_of_meshes(
                start[rows], start[rows] / speed[rows], expected[rows], self._radius
            )
            self.unsure.update(map(tuple, np.sort(moving.pairs[rows[unsure]], axis=1).tolist()))
        return expected, after

    def final_distances(self, paths: Paths, pairs: IntArray) -> FloatArray:
        """Signed distances (p,) of ``pairs`` at the end of their paths."""
        moving = _MovingPairs(self._narrow, paths, pairs)
        return moving.clearances(np.full(len(pairs), paths.duration))


@frozen
class _MovingPairs:
    """``pairs`` (k, 2) of bodies on their ``paths``, each pair at its own time."""

    narrow: NarrowPhase
    paths: Paths
    pairs: IntArray

    def chosen(self, rows: IntArray | BoolArray) -> _MovingPairs:
        return _MovingPairs(self.narrow, self.paths, self.pairs[rows])

    def poses(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        both = self.paths.poses(self.pairs.T.reshape(-1), np.concatenate([time, time]))
        return both[:, : len(time)], both[:, len(time) :]

    def clearances(self, time: FloatArray) -> FloatArray:
        return self.narrow.clearances(self.pairs, *relative_pose(*self.poses(time)))

    def actual_distances(self) -> FloatArray:
        """Signed distances (k,) in the actual poses at the end."""
        first, second = (self.paths.end.take(k, axis=1) for k in self.pairs.T)
        return self.narrow.clearances(self.pairs, *relative_pose(first, second))

    def touch_by_regula_falsi(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Times (k,) [s] at which the signed distances vanish, given those at the ``start`` > 0 and
        at the ``end`` (k,) of the interval: by regula falsi (Illinois), beginning at the time at
        which points with constant acceleration would meet."""
        duration = self.paths.duration
        low = np.zeros(len(start))
        high = np.full(len(start), duration)
        f_low = start.copy()
        f_high = end.copy()
        bend = (
            self.paths.acceleration[:, self.pairs[:, 1]]
            - self.paths.acceleration[:, self.pairs[:, 0]]
        )
        pull = np.sqrt((bend * bend).sum(axis=0))
        slope = (start - end) / duration - pull * (duration / 2)
        falling = (
            2
            * start
            / np.maximum(
                slope + np.sqrt(np.maximum(slope * slope + 2 * pull * start, 0.0)),
                1e-300,
            )
        )
        time = np.where(
            slope >= 0,
            np.clip(falling, 0.0, duration),
            duration * start / np.maximum(start - end, 1e-300),
        )
        enough = np.maximum(_TOUCH, (start - end) / duration * _INSTANT)
        active = np.arange(len(start))
        side = np.zeros(len(start), dtype=np.int64)
        for _ in range(_MOST_STEPS):
            t = time[active]
            f = self.chosen(active).clearances(t)
            before = f > 0
            f_high[active] = np.where(
                before,
                np.where(side[active] == 1, f_high[active] / 2, f_high[active]),
                f,
            )
            f_low[active] = np.where(
                before,
                f,
                np.where(side[active] == -1, f_low[active] / 2, f_low[active]),
            )
            low[active] = np.where(before, t, low[active])
            high[active] = np.where(before, high[active], t)
            side[active] = np.where(before, 1, -1)
            active = active[(np.abs(f) > enough[active]) & (high[active] - low[active] > 1e-7)]
            if len(active) == 0:
                break
            a = low[active]
            b = high[active]
            fa = f_low[active]
            fb = f_high[active]
            time[active] = np.clip((b * fa - a * fb) / np.maximum(fa - fb, 1e-300), a, b)
        return time

    def touch_by_advancement(self, radius: FloatArray) -> FloatArray:
        """Times (k,) of the first touch [s], infinite where there is none, by conservative
        advancement: each step is the distance over a bound on the speed at which it shrinks, so
        none goes past a touch. ``radius`` (n,): of all bodies about their origins [m].
        """
        duration = self.paths.duration
        time = np.zeros(len(self.pairs))
        result = np.full(len(time), np.inf)
        active = np.arange(len(time))
        for _ in range(_MOST_STEPS):
            if len(active) == 0:
                break
            now = time[active]
            distance, speed = self.chosen(active).distances_and_speeds(now, radius)
            touching = distance <= _TOUCH
            result[active[touching]] = now[touching]
            time[active] = now + np.maximum(distance, _TOUCH / 2) / speed
            active = active[~touching & (time[active] <= duration)]
        return result

    def distances_and_speeds(
        self, now: FloatArray, radius: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Signed distances (k,) [m] at the times ``now`` (k,), and upper bounds (k,) > 0 on the
        speed at which they shrink from then to the end of the interval [m/s]. ``radius`` (n,): of
        all bodies about their origins [m]."""
        a, b = self.pairs.T
        first, second = self.poses(now)
        distance, normal = self.narrow.directed_clearances(
            self.pairs, *relative_pose(first, second)
        )
        relative = self.paths.velocities(a, now) - self.paths.velocities(b, now)
        bend = self.paths.acceleration[:, b] - self.paths.acceleration[:, a]
        turning = (np.sqrt(dot(self.paths.spin, self.paths.spin)) * radius)[self.pairs.T].sum(
            axis=0
        )
        speed = np.maximum(dot(relative, turned(first[:9].reshape(3, 3, -1), normal)), 0.0)
        speed += np.sqrt((bend * bend).sum(axis=0)) * (self.paths.duration - now) + turning
        return distance, np.maximum(speed, 1e-9)  # which the caller divides by

    def touch_of_meshes(
        self, start: FloatArray, time: FloatArray, end: FloatArray, radius: FloatArray
    ) -> tuple[FloatArray, IntArray]:
        """Times (k,) of the first touch of pairs with a mesh [s], infinite where there is none, and
        the numbers of the pairs for which `_MOST_STEPS_OF_MESHES` steps were too few; these touch
        at the end of the interval if they are in contact there.

        Where a mesh overlaps a body, their distance says nothing about the time of touch, so its
        zero can't be bracketed. Steps are those of conservative advancement, lengthened by a secant
        through the last two distances; a step that ends in an overlap is halved.

        Args:
            start: distances at the start of the interval (k,) [m].
            time: up to which they can't touch (k,) [s].
            end: distances at its end (k,) [m].
            radius: of all bodies about their origins (n,) [m].
        """
        duration = self.paths.duration
        count = len(start)
        low = np.zeros(count)
        high = np.full(count, np.inf)
        rate = np.zeros(count)
        last = start.copy()
        result = np.where(end <= _TOUCH, duration, np.inf)
        time = time.copy()
        active = np.arange(count)
        for _ in range(_MOST_STEPS_OF_MESHES):
            now = time[active]
            distance, speed = self.chosen(active).distances_and_speeds(now, radius)
            ahead = distance > _TOUCH
            before = active[ahead]
            through = active[~ahead]
            step = now[ahead] - low[before]
            rate[before] = np.divide(
                last[before] - distance[ahead],
                step,
                out=np.zeros(len(before)),
                where=step > 0,
            )
            low[before] = now[ahead]
            last[before] = distance[ahead]
            high[through] = result[through] = now[~ahead]
            safe = low[active] + np.where(ahead, distance / speed, 0.0)
            shrinking = rate[active] > 0
            ahead_by = np.divide(
                last[active], rate[active], out=np.zeros(len(active)), where=shrinking
            )
            guess = np.minimum(
                low[active] + ahead_by,
                np.minimum((low[active] + high[active]) / 2, duration),
            )
            time[active] = np.maximum(safe, guess)
            touched = ~ahead & (distance > 0)
            missed = ahead & (safe > duration)
            result[active[missed]] = np.inf
            found = touched | (high[active] - low[active] <= _INSTANT)
            active = active[~(found | missed)]
            if len(active) == 0:
                break
        return result, active

    def pass_through(self, after: FloatArray, within: FloatArray, depth: FloatArray) -> BoolArray:
        """Which pairs, on their paths, overlap by at least ``depth`` (k,) [m] at one of four times
        ``within`` (k,) seconds ``after`` (k,) the first touch."""
        at = np.minimum(
            after + np.array([[0.2], [0.4], [0.6], [0.8]]) * within, self.paths.duration
        )
        deepest = (
            self.chosen(np.tile(np.arange(len(after)), len(at)))
            .clearances(at.reshape(-1))
            .reshape(at.shape)
            .min(axis=0)
        )
        return np.asarray(deepest <= -depth)


@frozen
class Meetings:
    """Pairs of bodies that touch on their paths.

    Attributes:
        moving: the pairs and their paths.
        after: (k,) time of the first touch, from the start of the paths [s].
        poses: (12, k) of the first and of the second bodies at that time.
        placing: the arguments of `NarrowPhase.query` for the patches there.
        expected: (k,) signed distance at the end of the paths [m].
        actual: (k,) signed distance in the actual poses at the end of the interval [m].
        far: (k,) whether the bodies move far compared with their thickness.
        mesh: (k,) whether one is a mesh.
    """

    moving: _MovingPairs
    after: FloatArray
    poses: tuple[FloatArray, FloatArray]
    placing: tuple[IntArray, FloatArray, FloatArray, FloatArray]
    expected: FloatArray
    actual: FloatArray
    far: BoolArray
    mesh: BoolArray

    def hits(self, found: PairPatches) -> Hits:
        """The hits, with the patches ``found``."""
        moving, after, (first, second) = self.moving, self.after, self.poses
        turn = first[:9].reshape(3, 3, -1)
        normal = turned(turn, found.normal)
        centre = turned(turn, found.centre) + first[9:]
        bodies = moving.pairs.T
        time = after / moving.paths.speed_correction(bodies, after / 2).max(axis=0)
        correction = moving.paths.speed_correction(bodies, time)
        velocities = moving.paths.velocities(bodies, after) * correction  # (3, 2, k)
        arms = centre[:, None] - np.stack([first[9:], second[9:]], axis=1)
        speeds = velocities + cross(moving.paths.spin[:, bodies] * correction, arms)
        approach = dot(speeds[:, 0] - speeds[:, 1], normal)
        passes = self.far.copy()
        fast = self.far.nonzero()[0]
        if len(fast):
            one, other = moving.narrow.thickness[bodies[:, fast]]
            within = (one + other) / np.maximum(approach[fast], SLOWEST)
            passes[fast] = moving.chosen(fast).pass_through(
                after[fast], within, np.minimum(one, other) / 4
            )
        spins = moving.paths.spin[:, bodies] * correction
        ways = normal.T, centre.T, approach, np.array(self.poses).transpose(2, 0, 1)
        motion = velocities.transpose(2, 1, 0), spins.transpose(2, 1, 0)
        # Meshes that have passed through each other are not deeper for it: as deep as they would be
        # at this speed.
        deep = np.where(
            self.mesh,
            -np.maximum(approach, 0.0) * (moving.paths.duration - after),
            np.inf,
        )
        return Hits(
            moving.pairs,
            after,
            time,
            found.distance,
            *ways,
            *motion,
            np.minimum(self.expected, deep),
            self.actual,
            passes,
        )
