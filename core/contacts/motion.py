"""Motion of bodies between two frames, estimated from their poses at whole frames.

A physics engine gives poses, not velocities, and the pose of the frame in which a body hits
something already contains the bounce. So a body's path up to its next hit is extrapolated from the
frames before: position with constant acceleration, rotation with constant angular velocity. Free
fall is exact. A kinematic body's path is known at both ends and interpolated, unless something
stopped it between them.

Poses are arrays (12, n): rotation by rows, then position.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, carried
from ..frozen import frozen
from .narrow.frames import dot, product

_DEPTH = 4
"""Number of poses stored before the current one."""

_PLAUSIBLE = 2.5
"""Multiple of gravity up to which an acceleration is estimated by second differences of poses;
larger ones are due to a hit."""

_SLOW, _MOST_SLOWED = 0.05, 1.3
"""Least speed [m/s] of a body on its path, and largest factor by which it was faster before a
hit."""

_STOPPED, _STEADY = 0.1, 0.02
"""Parts of its speed by which a kinematic body is slower than if it had gone on as before, from
which on it was stopped within the last interval, and by which it may have braked before."""

_BRAKES = 2.0
"""Multiple of the speed that a body gained in an interval before that it may lose by braking."""

HITCH, PAUSE = 0.1 - 1e-9, 0.25 + 1e-9
"""Durations of an interval [s] from which on bodies count as moving straight through it, and beyond
which nothing strikes: all begins anew."""

_JUMP = 1e-3
"""Part of the speed in one interval up to which a kinematic body rests in those beside it, if it
was set elsewhere rather than moved."""

_DEVIATION = 0.001
"""Metres of deviation from the extrapolated path above which a body counts as disturbed."""
_TURN = 3e-3
"""Angle [rad] up to which a body turns on as before."""
_SWERVE = 0.05
"""Part of its speed by which a body deviates at most that speeds up or turns as before."""
_CHANGE = 1.0
"""The same where an interval is longer than 1/22 s: a change of acceleration [m/s^2], as that of a
body whose fall is damped."""


@frozen
class Paths:
    """Paths of n bodies from one frame to the next.

    Attributes:
        duration: of the interval [s].
        start: (12, n) poses at its start.
        velocity: (3, n) of the origins at the start [m/s].
        acceleration: (3, n) of the origins, constant [m/s^2].
        spin: (3, n) angular velocity about the origin, constant [rad/s].
        end: (12, n) actual poses at the end of the interval, which the path need not lead to.
        certain: (n,) whether the path is known throughout and has no hit.
        eased: (n,) whether it was slowed, and may have braked without a hit.
        turned: (n,) whether a hit in the interval before deflected it.
        earlier: (12, n) poses one frame before the start.
        earlier_duration: seconds between those and the start.
        trend: (2, 3, n) velocity at the start and acceleration as estimated from the poses before
            it; 0 of kinematic bodies, and of those that were hit shortly before.
    """

    duration: float
    start: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    spin: FloatArray
    end: FloatArray
    certain: BoolArray
    eased: BoolArray
    turned: BoolArray
    earlier: FloatArray
    earlier_duration: float
    trend: FloatArray

    def chosen(self, bodies: IntArray) -> Paths:
        """The paths of some ``bodies`` (k,), by number."""
        columns = (
            "start",
            "velocity",
            "acceleration",
            "spin",
            "end",
            "certain",
            "eased",
            "turned",
            "earlier",
            "trend",
        )
        return replace(
            self, **{name: getattr(self, name).take(bodies, axis=-1) for name in columns}
        )

    def through_ends(self) -> Paths:
        """Paths with the same starts and accelerations that lead to the actual poses at the end."""
        direct = (self.end[9:] - self.start[9:]) / self.duration
        velocity = direct - self.acceleration * (self.duration / 2)
        return replace(self, velocity=velocity, spin=spins(self.start, self.end, self.duration))

    def poses(self, bodies: IntArray, time: FloatArray | float) -> FloatArray:
        """Poses (12, k) of ``bodies`` (k,) at ``time`` (k,) seconds after the start."""
        # (`take` leaves bodies side by side in memory, as indexing does not.)
        ways = self.start, self.velocity, self.acceleration, self.spin
        start, velocity, acceleration, spin = (way.take(bodies, axis=1) for way in ways)
        poses = np.empty_like(start)
        poses[9:] = start[9:] + (velocity + acceleration * (np.asarray(time) / 2)) * time
        turn = rotations(spin * time)
        poses[:9] = product(turn, start[:9].reshape(3, 3, -1)).reshape(9, -1)
        return poses

    def velocities(self, bodies: IntArray, time: FloatArray | float) -> FloatArray:
        """Velocities (3, k) of the origins of ``bodies`` at ``time``."""
        return self.velocity.take(bodies, axis=1) + self.acceleration.take(bodies, axis=1) * time

    def speed_correction(self, bodies: IntArray, time: FloatArray) -> FloatArray:
        """Factors (k,) >= 1 from the speeds of ``bodies`` (k,) on their paths at ``time`` (k,) to
        those by their ``trend``. A path that leads to the pose at the end of an interval with a hit
        is too slow, because the body bounced or rested for a part of that interval."""
        velocity, acceleration = self.trend[..., bodies]
        before = np.sqrt(_squared(velocity + acceleration * time))
        on_path = np.sqrt(_squared(self.velocities(bodies, time)))
        return np.clip(before / np.maximum(on_path, _SLOW), 1.0, _MOST_SLOWED)

    def displacement(self) -> FloatArray:
        """Vectors (3, n) from the starts to the ends of the paths."""
        return (self.velocity + self.acceleration * (self.duration / 2)) * self.duration

    def fastest(self) -> FloatArray:
        """Greatest speed (n,) [m/s] of each body's origin on its path, on the straight line to its
        actual position at the end, or by its ``trend``."""
        final = self.velocity + self.acceleration * self.duration
        direct = (self.end[9:] - self.start[9:]) / self.duration
        trend = self.trend[0] + self.trend[1] * self.duration
        speeds = self.velocity, final, direct, trend
        squared = np.stack([_squared(velocity) for velocity in speeds])
        return np.asarray(np.sqrt(squared.max(axis=0)))


class MotionHistory:
    """The poses of n bodies in the last frames, and since when each has moved undisturbed."""

    def __init__(self, count: int) -> None:
        self.times: list[float] = []  # of the stored frames [s]
        self._poses: list[FloatArray] = []  # (12, n) in each of them
        # Frames since each body last moved, was disturbed in any way, was hit, and began to move
        # after a rest; the time of that hit [s]; and whether it has ever moved.
        self._since_moved = np.zeros(count, dtype=np.int64)
        self._since_disturbed = np.zeros(count, dtype=np.int64)
        self._since_hit = np.zeros(count, dtype=np.int64)
        self._hit_time = np.zeros(count)
        self._since_onset = np.full(count, -2)
        self._has_moved = np.zeros(count, dtype=np.bool_)

    @property
    def step(self) -> float:
        """Seconds between the last two frames, 0 before there are two."""
        return self.times[-1] - self.times[-2] if len(self.times) > 1 else 0.0

    def advance(self, time: float, poses: FloatArray, moved: IntArray) -> None:
        """Add a frame: ``poses`` (12, n), stored without a copy, and the numbers of the bodies that
        have moved."""
        self.times = [*self.times[-_DEPTH:], time]
        self._poses = [*self._poses[-_DEPTH:], poses]
        self._since_onset += 1
        self._since_moved += 1
        self._since_disturbed += 1
        self._since_hit += 1
        if len(self.times) == 1:
            self._since_moved[:] = self._since_disturbed[:] = self._since_hit[:] = 0
            return
        known = np.isfinite(self._poses[-2][0])
        moved = moved[known[moved]]
        self._since_onset[moved[self._since_moved[moved] > 1]] = 0
        self._since_moved[moved] = 0
        self._has_moved[moved] = True
        if not known.all():
            unknown = ~known
            for count in (self._since_moved, self._since_disturbed, self._since_hit):
                count[unknown] = 0

    def renumber(self, before: IntArray) -> None:
        """Follow a new order of the bodies: ``before`` (n,) are their former numbers, -1 for a new
        one."""
        self._poses = [carried(poses, before, np.nan) for poses in self._poses]
        for name, fresh in (
            ("_since_moved", 0),
            ("_since_disturbed", 0),
            ("_since_hit", 0),
            ("_hit_time", 0.0),
            ("_since_onset", -2),
            ("_has_moved", False),
        ):
            setattr(self, name, carried(getattr(self, name), before, fresh))

    def disturb(self, bodies: IntArray | BoolArray) -> None:
        """Mark bodies that hit something in the last interval: their motion up to then does not
        predict what follows."""
        self._since_disturbed[bodies] = 0

    def hit(self, pairs: IntArray, after: FloatArray) -> None:
        """Mark bodies, ``pairs`` (k, 2), that hit each other ``after`` (k,) seconds in the last
        interval. Of hits in consecutive intervals the first counts."""
        self.disturb(pairs)
        fresh = (self._since_hit[pairs] > 2).any(axis=1)
        self._since_hit[pairs[fresh]] = 0
        self._hit_time[pairs[fresh]] = (self.times[-2] + after[fresh])[:, None]

    def history(self) -> tuple[FloatArray, ...]:
        """What later paths depend on: times, poses, and counts, clipped to where larger values make
        no difference."""
        counts = (
            np.minimum(count, _DEPTH + 1)
            for count in (
                self._since_moved,
                self._since_disturbed,
                self._since_hit,
                self._since_onset,
            )
        )
        hit_time = np.where(self._since_hit <= 2, self._hit_time, 0.0)
        return np.array(self.times), *self._poses, np.stack([self.moving(), *counts]), hit_time

    @property
    def poses(self) -> Sequence[FloatArray]:
        """Poses (12, n) in the last frames, at most five."""
        return self._poses

    @property
    def last_poses(self) -> FloatArray:
        """Poses (12, n) in the last frame but one."""
        return self._poses[-2]

    def moving(self) -> BoolArray:
        """Which bodies (n,) have moved within the stored frames."""
        return self._has_moved & (self._since_moved <= _DEPTH)

    def stops(self) -> bool:
        """Whether any body moved in the interval before the last one, and not in the last."""
        return bool((self._has_moved & (self._since_moved == 1)).any())

    def speeds(self) -> FloatArray:
        """(n,) mean speed of each body in the last interval; 0 before there is one."""
        if len(self.times) < 2:
            return np.zeros(len(self._since_moved))
        return np.sqrt(_squared(self._poses[-1][9:] - self._poses[-2][9:])) / self.step

    def drift(self, bodies: IntArray) -> FloatArray:
        """Displacement (3, k) of bodies in the last interval, 0 before there is one."""
        if len(self.times) < 2:
            return np.zeros((3, len(bodies)))
        drift = self._poses[-1][9:, bodies] - self._poses[-2][9:, bodies]
        return np.where(np.isfinite(drift), drift, 0.0)

    def deviated(self, paths: Paths) -> BoolArray:
        """Which moving bodies (n,) are neither at the ends of their ``paths`` nor where these would
        end without acceleration, and don't move and turn on as before, at the same speeds or with
        the same changes of them: what swings on a hinge, or is pulled by something unknown, is
        not hit."""
        rows = self.moving().nonzero()[0]
        t, count, paths = paths.duration, len(paths.certain), paths.chosen(rows)
        travel = paths.end[9:] - paths.start[9:]
        chord = (paths.start[9:] - paths.earlier[9:]) / paths.earlier_duration
        straight = travel - paths.velocity * t
        bent = straight - paths.acceleration * (t * t / 2)
        limit = max(_DEVIATION, _CHANGE / 2 * t * t)
        change = travel / t - chord
        spin = spins(paths.earlier, paths.start, paths.earlier_duration)
        turn = spins(paths.start, paths.end, t) - spin
        on = (_squared(change) <= (_CHANGE / 2 * t) ** 2) & (_squared(turn) * t * t <= _TURN**2)
        if len(self.times) > _DEPTH:
            before, step = self._poses[-4][:, rows], self.times[-3] - self.times[-4]
            change -= chord - _travels(before, paths.earlier, step)
            turn -= spin - spins(before, paths.earlier, step)
            on |= _is_small(change, chord, limit / t) & _is_small(turn, spin, _TURN / t)
        ways = np.minimum(_squared(straight), _squared(bent))
        found = np.zeros(count, dtype=np.bool_)
        found[rows] = (ways > limit**2) & ~on
        return found

    def _velocities(self, rows: IntArray) -> list[FloatArray]:
        """The velocities of bodies ``rows`` (k,), and how they turned, in the intervals between the
        stored poses, (intervals, 3, k) each."""
        poses = [each.take(rows, axis=1) for each in self._poses]
        steps = np.diff(self.times).tolist()
        return [
            np.array([of(poses[k], poses[k + 1], step) for k, step in enumerate(steps)])
            for of in (_travels, spins)
        ]

    def _stopped(self, rows: IntArray) -> BoolArray:
        """Which bodies ``rows`` (k,), of four poses, were stopped in the last interval: they moved
        or turned without braking up to then."""
        found = np.zeros(len(rows), dtype=np.bool_)
        for velocities in self._velocities(rows):
            before, last, now = np.sqrt((velocities[-3:] ** 2).sum(axis=1))
            found |= (
                (last > _SLOW)
                & (now - 2 * last + before < -_STOPPED * last)
                & (last - before >= -_STEADY * last)
            )
        return found

    def _eased(self, rows: IntArray) -> BoolArray:
        """Which bodies ``rows`` (k,), of four poses, may have braked in the last interval, rather
        than been slowed by a hit: what is carried speeds up at changing rates, and brakes so."""
        slowed, eased = np.zeros((2, len(rows)), dtype=np.bool_)
        for velocities in self._velocities(rows):
            last = velocities[-2]
            speed = np.sqrt(_squared(last))
            *before, now = (velocities * last).sum(axis=1) / np.maximum(speed, _SLOW)
            gains = np.diff(before, axis=0)
            gain = gains.max(axis=0)
            brakes = (now >= 0) & (speed - now <= _BRAKES * gain)
            brakes &= np.ptp(gains, axis=0) > _STEADY * gain
            eased |= brakes
            slowed |= (speed > _SLOW) & (speed - now > _STEADY * speed) & ~brakes
        return eased & ~slowed

    def _straight(self, step: float, known: float) -> Paths:
        """Paths at constant speed from pose to pose, through an interval of ``step`` seconds, after
        one of ``known``."""
        earlier, start, end = self._poses[-3:]
        moving = self.moving()
        none = np.zeros((3, len(moving)))
        return Paths(
            step,
            start,
            np.where(moving, _travels(start, end, step), 0.0),
            none,
            np.where(moving, spins(start, end, step), 0.0),
            end,
            np.ones_like(moving),
            np.zeros_like(moving),
            np.zeros_like(moving),
            earlier,
            known,
            np.array([none, none]),
        )

    def paths(self, kinematic: BoolArray, airborne: BoolArray, gravity: FloatArray) -> Paths | None:
        """Paths from the last frame but one to the last. None before there are three poses.

        Args:
            kinematic: bodies whose path leads to their pose in the last frame (n,).
            airborne: bodies that fall where their acceleration can't be measured (n,).
            gravity: (3,) [m/s^2].
        """
        if len(self.times) < 3:
            return None
        step, known, *older = (
            later - earlier
            for earlier, later in zip(self.times[-2::-1], self.times[:0:-1], strict=True)
        )
        if step >= HITCH:
            return self._straight(step, known)
        moving = self.moving()
        if 2 * np.count_nonzero(moving) > len(moving):
            found = self._curved(kinematic, airborne, gravity, step, known, older)
            return replace(
                found,
                certain=found.certain | (kinematic & ~moving),
                turned=found.turned & moving,
                trend=np.where(moving, found.trend, 0.0),
            )
        moving_ones, rows = copy.copy(self), moving.nonzero()[0]
        moving_ones.renumber(rows)
        found = moving_ones._curved(kinematic[rows], airborne[rows], gravity, step, known, older)
        before = np.where(moving, moving.cumsum() - 1, -1)
        earlier, start, end = self._poses[-3:]
        return replace(
            found,
            start=start,
            velocity=carried(found.velocity, before, 0.0),
            acceleration=carried(found.acceleration, before, 0.0),
            spin=carried(found.spin, before, 0.0),
            end=end,
            certain=carried(found.certain, before, False) | (kinematic & ~moving),
            eased=carried(found.eased, before, False),
            turned=carried(found.turned, before, False),
            earlier=earlier,
            trend=carried(found.trend, before, 0.0),
        )

    def _steady_gain(
        self, kinematic: BoolArray, chord: FloatArray, known: float, older: float, weight: float
    ) -> FloatArray:
        """Acceleration (3, n) [m/s^2] over the last two intervals, of ``known`` and ``older``
        seconds and the mean velocity ``chord`` (3, n) in the last; 0 where a hit falsifies it."""
        before = self._poses[-3][9:] - self._poses[-4][9:]
        # A body at rest that was hit in the interval before the last moves only from then on.
        knocked = (self._since_hit == 2) & (self._since_onset == 2)
        since = np.where(knocked, self.times[-3] - self._hit_time, older)
        since = np.clip(since, older / 10, older)
        gain = 2 * (chord - before / since) / (known + since)
        steady = knocked | ((self._since_hit > 2) & (self._since_onset > 2))
        steady &= ~kinematic & (_squared(gain) <= (_PLAUSIBLE * weight) ** 2)
        return np.where(steady, gain, 0.0)

    def _curved(
        self,
        kinematic: BoolArray,
        airborne: BoolArray,
        gravity: FloatArray,
        step: float,
        known: float,
        older: Sequence[float],
    ) -> Paths:
        """As `paths`, through an interval of ``step`` seconds, after one of ``known``, and one
        ``older`` at most."""
        earlier, start, end = self._poses[-3:]
        before, last, now = earlier[9:], start[9:], end[9:]
        weight = float(np.linalg.norm(gravity))
        chord = (last - before) / known
        direct = (now - last) / step
        clean = self._since_disturbed - 1  # undisturbed intervals up to the start of the path
        trend = np.zeros((2, *chord.shape))
        trend[0] = np.where((self._since_hit > 1) & ~kinematic, chord, 0.0)
        before_spin = spins(earlier, start, known)
        # Dynamic: constant acceleration, measured where no hit falsifies it.
        bend = np.where(airborne, gravity[:, None], 0.0)
        if older:
            first = (before - self._poses[-4][9:]) / older[0]
            measured = 2 * (chord - first) / (known + older[0])
            brakes = (self._since_hit > 2) & (dot(measured, chord) < 0) & (dot(first, chord) > 0)
            clean = np.where(brakes, 2, clean)  # what brakes it goes on to do so
            plausible = (
                (clean >= 2)
                & (self._since_onset > 2)
                & (brakes | (_squared(measured) <= (_PLAUSIBLE * weight) ** 2))
            )
            bend = np.where(plausible, measured, bend)
            # The spin in the middle of the path, by its change over the last two intervals.
            change = before_spin - spins(self._poses[-4], earlier, older[0])
            steady_turn = plausible & (4 * _squared(change) <= _squared(before_spin))
            before_spin += np.where(steady_turn, change, 0.0) * (step + known) / (known + older[0])
            trend[1] = self._steady_gain(kinematic, chord, known, older[0], weight)
            trend[0] += trend[1] * (known / 2)
        begin = chord + bend * (known / 2)
        if weight > 0:
            released = airborne & (self._since_onset == 1)
            fallen, speed = _fallen_from_rest(
                released, chord * known, known, gravity / weight, weight
            )
            begin = np.where(fallen, speed, begin)
            clean = np.where(fallen, 1, clean)  # released since, which is no hit
        # The path of a kinematic body leads through both poses, unless it turned sharply or stopped
        # between them, as in a hit. Of a dynamic body that was hit in the interval before, only the
        # motion since then is known.
        curved = 2 * (direct - chord) / (step + known)
        smooth = kinematic & (
            4 * step**2 * _squared(curved) <= np.maximum(_squared(direct), _squared(chord))
        )
        moving = self.moving()
        eased = np.zeros_like(moving)
        turning = spins(start, end, step)
        if older and (kinematic & moving).any():
            moving &= ~(kinematic & _jumps(first, chord, direct))
            rows = (smooth & moving).nonzero()[0]
            smooth[rows] = ~self._stopped(rows)
            # Of the interval in which it began to move no speed is known, before which it stopped.
            smooth |= kinematic & (self._since_onset > 0) & (self._since_onset <= 2)
            rests = kinematic & _comes_to_rest(first, chord, direct)
            curved = np.where(rests, -2 * direct / step, curved)
            rests_turning = kinematic & _comes_to_rest(
                spins(self._poses[-4], earlier, older[0]), spins(earlier, start, known), turning
            )
            turning = np.where(rests_turning, 0.0, turning)
            smooth |= rests | rests_turning
            rows = (kinematic & moving & ~smooth).nonzero()[0]
            eased[rows] = self._eased(rows)
        given = smooth | (~kinematic & (clean < 1))
        acceleration = np.where(moving, np.where(smooth, curved, np.where(given, 0.0, bend)), 0.0)
        velocity = np.where(moving, np.where(given, direct - acceleration * (step / 2), begin), 0.0)
        spin = np.where(given, turning, before_spin)
        turned = kinematic & ~smooth & (clean < 1)
        return Paths(
            step,
            start,
            velocity,
            acceleration,
            np.where(moving, spin, 0.0),
            end,
            smooth,
            eased,
            turned,
            earlier,
            known,
            trend,
        )


def _fallen_from_rest(
    released: BoolArray, way: FloatArray, time: float, down: FloatArray, weight: float
) -> tuple[BoolArray, FloatArray]:
    """Which of the bodies ``released`` (n,) within an interval of ``time`` [s] fell from rest along
    their ``way`` (3, n) in it, and the velocities (3, n) of a fall over this height. down: (3,),
    of length 1. weight: [m/s^2]."""
    fallen = down @ way
    level = _squared(way - fallen * down[:, None])
    from_rest = (fallen > 0) & (fallen <= 0.501 * weight * time**2) & (level <= (0.1 * fallen) ** 2)
    speed = np.sqrt(2 * weight * np.maximum(fallen, 0.0))
    return released & from_rest, down[:, None] * speed


def _jumps(first: FloatArray, chord: FloatArray, direct: FloatArray) -> BoolArray:
    """Which bodies (n,) moved in the second of three intervals alone, by their velocities (3, n)
    there."""
    least = _JUMP**2 * _squared(chord)
    return (least > 0) & (_squared(first) <= least) & (_squared(direct) <= least)


def _comes_to_rest(first: FloatArray, chord: FloatArray, direct: FloatArray) -> BoolArray:
    """Which bodies (n,) brake to rest through three intervals without turning back, by their
    velocities (3, n) there."""
    one, two, three = (np.sqrt(_squared(velocity)) for velocity in (first, chord, direct))
    return _brakes_to_rest(one, two, three) & (dot(chord, direct) >= 0)


def _brakes_to_rest(one: FloatArray, two: FloatArray, three: FloatArray) -> BoolArray:
    """What (n,) brakes through three intervals, by its speeds (n,) there, and has no more left in
    the end than it loses in half of the last one."""
    brakes = (two < (1 - _STEADY) * one) & (three < (1 - _STEADY) * two)
    return np.asarray(brakes & (three <= 2 * (two - three)))


def approach(gaps: FloatArray, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Speeds [m/s] at which points (n,) come to touch what they are apart from by ``gaps`` (k, n)
    [m] in the last frames, at least four, and when they do so, from the start of the last interval
    [s]. What comes to rest there has no speed; what is stopped has that of the interval before.
    ``steps`` (k - 1,): of the frames [s]."""
    one, two, three = (-np.diff(gaps, axis=0) / steps[:, None])[-3:]
    step = steps[-1]
    trend = np.where(one > two / 4, two - one, 0.0)  # what has just begun to move has none
    stopped = (two > _SLOW) & (three - two - trend < -_STOPPED * two) & (trend >= -_STEADY * two)
    gain = np.where(stopped, trend, three - two)
    begin = np.where(stopped, two, three) + np.where(stopped, gain, -gain) / 2
    root = begin**2 + 2 * gain / step * gaps[-2]
    reaches = (root >= 0) & (begin + np.sqrt(root.clip(0)) > 0)
    after = np.where(reaches, 2 * gaps[-2] / (begin + np.sqrt(root.clip(0))).clip(1e-9), step)
    after = after.clip(0, step)
    rests = _brakes_to_rest(one, two, three)
    return np.where(rests, 0.0, begin + gain * after / step), after


def _travels(start: FloatArray, end: FloatArray, time: float) -> FloatArray:
    """Velocities (3, n) of the origins that lead from the one poses to the others."""
    return (end[9:] - start[9:]) / time


def _is_small(change: FloatArray, of: FloatArray, limit: float) -> BoolArray:
    """Which changes (3, n) of velocities are within the ``limit`` or `_SWERVE`."""
    return np.asarray(_squared(change) <= np.maximum(limit**2, _SWERVE**2 * _squared(of)))


def _squared(vectors: FloatArray) -> FloatArray:
    """Squared lengths (n,) of vectors (3, n)."""
    return dot(vectors, vectors)


def spins(start: FloatArray, end: FloatArray, time: float) -> FloatArray:
    """Angular velocities (3, n) that turn the one poses into the others within ``time``, by less
    than half a turn."""
    a = start[:9].reshape(3, 3, -1)
    b = end[:9].reshape(3, 3, -1)
    turn = product(b, a.transpose(1, 0, 2))
    twist = np.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = np.sqrt(_squared(twist)) / 2
    angle = np.arctan2(sine, (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1) / 2)
    turning = sine > 1e-9
    return twist * (np.where(turning, angle / np.where(turning, sine, 1.0), 1.0) / (2 * time))


def rotations(vectors: FloatArray) -> FloatArray:
    """Rotation matrices (3, 3, n) of rotation vectors (3, n) [rad] (Rodrigues' formula)."""
    squared = _squared(vectors)
    angle = np.sqrt(squared)
    small = angle < 1e-6
    divisor = np.where(small, 1.0, angle)
    sine = np.where(small, 1.0 - squared / 6, np.sin(angle) / divisor)
    cosine = np.where(small, 0.5 - squared / 24, (1.0 - np.cos(angle)) / (divisor * divisor))
    result = vectors[:, None] * (vectors * cosine)
    along = 1.0 - cosine * squared
    for k in range(3):
        result[k, k] += along
    x, y, z = vectors * sine
    result[0, 1] -= z
    result[0, 2] += y
    result[1, 0] += z
    result[1, 2] -= x
    result[2, 0] -= y
    result[2, 1] += x
    return result
