"""How bodies move between two frames, from their poses at whole frames alone.

An engine tells poses, not velocities, and the pose of the frame in which a body hits something already has the bounce in it. So a body's
way up to its next hit is extrapolated from the frames before: position with constant acceleration, rotation with constant angular velocity.
Free fall is met exactly. A kinematic body's way is known at both ends and interpolated.

Poses are arrays (12, n): rotation by rows, then position.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray

_DEPTH = 3
"""Poses that are remembered before the current one."""

_BELIEVABLE = 2.5
"""Accelerations up to so many times gravity are taken from the second difference of poses; larger ones come from a hit in between."""

_ASTRAY = 0.001
"""Metres by which a body misses where its motion led it if it was disturbed on the way."""


@dataclass(frozen=True, slots=True)
class Paths:
    """The ways of bodies from one frame to the next, ``duration`` seconds: from ``start`` (12, n) on with ``velocity`` (3, n), constant
    ``acceleration`` (3, n) and ``spin`` (3, n) [rad/s] about the body's origin. ``end`` (12, n): where the bodies really are then.
    ``certain`` (n,): the way is known all along, and no hit turned it. ``turned`` (n,): it was turned by a hit in the interval before.
    ``earlier`` (12, n): the poses ``earlier_duration`` seconds before the start."""

    duration: float
    start: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    spin: FloatArray
    end: FloatArray
    certain: BoolArray
    turned: BoolArray
    earlier: FloatArray
    earlier_duration: float

    def to_the_ends(self) -> Paths:
        """The ways that lead from the same starts with the same accelerations to where the bodies really are at the end."""
        direct = (self.end[9:] - self.start[9:]) / self.duration
        velocity = direct - self.acceleration * (self.duration / 2)
        return replace(self, velocity=velocity, spin=_spins(self.start, self.end, self.duration))

    def poses(self, bodies: IntArray, time: FloatArray | float) -> FloatArray:
        """Poses (12, k) of ``bodies`` (k,) at ``time`` (k,) seconds after the start."""
        start, velocity, spin = self.start[:, bodies], self.velocity[:, bodies], self.spin[:, bodies]
        poses = np.empty_like(start)
        poses[9:] = start[9:] + (velocity + self.acceleration[:, bodies] * (np.asarray(time) / 2)) * time
        turn = rotations(spin * time)
        poses[:9] = np.einsum("ijp,jkp->ikp", turn, start[:9].reshape(3, 3, -1)).reshape(9, -1)
        return poses

    def velocities(self, bodies: IntArray, time: FloatArray | float) -> FloatArray:
        """Velocities (3, k) of the origins of ``bodies`` at ``time``."""
        return np.asarray(self.velocity[:, bodies] + self.acceleration[:, bodies] * time)

    def displacement(self) -> FloatArray:
        """(3, n) from the starts to the ends of the ways."""
        return np.asarray((self.velocity + self.acceleration * (self.duration / 2)) * self.duration)

    def fastest(self) -> FloatArray:
        """(n,) greatest speed of each body's origin on its way, or on the straight one to where it really is at the end."""
        final = self.velocity + self.acceleration * self.duration
        direct = (self.end[9:] - self.start[9:]) / self.duration
        squared = np.stack([_squared(self.velocity), _squared(final), _squared(direct)])
        return np.asarray(np.sqrt(squared.max(axis=0)))


class MotionHistory:
    """The last poses of bodies, and for how many intervals each has moved, and moved undisturbed."""

    def __init__(self, count: int) -> None:
        self.times: list[float] = []
        self._poses: list[FloatArray] = []
        self._still = np.zeros(count, dtype=np.int64)
        self._clean = np.zeros(count, dtype=np.int64)
        self._onset = np.full(count, -2)
        self._begun = np.zeros(count, dtype=np.bool_)

    @property
    def step(self) -> float:
        """Seconds between the last two frames, 0 before there are two."""
        return self.times[-1] - self.times[-2] if len(self.times) > 1 else 0.0

    def advance(self, time: float, poses: FloatArray, moved: IntArray) -> None:
        """Add a frame: ``poses`` (12, n), which are kept, and the numbers of the bodies that have moved."""
        self.times = [*self.times[-_DEPTH:], time]
        self._poses = [*self._poses[-_DEPTH:], poses]
        self._onset += 1
        self._still += 1
        self._clean += 1
        if len(self.times) == 1:
            self._still[:] = self._clean[:] = 0
            return
        self._onset[moved[self._still[moved] > 1]] = 0
        self._still[moved] = 0
        self._begun[moved] = True

    def advance_still(self, time: float) -> None:
        """Add a frame in which nothing has moved."""
        self.advance(time, self._poses[-1], np.zeros(0, dtype=np.int64))

    def disturb(self, bodies: IntArray | BoolArray) -> None:
        """These have hit something in the last interval: their motion in it and before says nothing about what follows."""
        self._clean[bodies] = 0

    @property
    def last_poses(self) -> FloatArray:
        """Poses (12, n) in the last frame but one."""
        return self._poses[-2]

    def moving(self) -> BoolArray:
        """(n,) which bodies have moved lately."""
        return np.asarray(self._begun & (self._still <= _DEPTH))

    def speeds(self) -> FloatArray:
        """(n,) mean speed of each body in the last interval; 0 before there is one."""
        if len(self.times) < 2:
            return np.zeros(len(self._still))
        return np.asarray(np.sqrt(_squared(self._poses[-1][9:] - self._poses[-2][9:])) / self.step)

    def speed_bound(self, gravity: FloatArray) -> FloatArray:
        """(n,) what the speed of each body in the last interval can have been at most, as far as poses tell; 0 before there are three."""
        if len(self.times) < 3:
            return np.zeros(len(self._still))
        step, known = self.times[-1] - self.times[-2], self.times[-2] - self.times[-3]
        now, last, before = (self._poses[-k][9:] for k in (1, 2, 3))
        direct, chord = (now - last) / step, (last - before) / known
        weight = float(np.linalg.norm(gravity))
        bend = np.sqrt(_squared(direct - chord)) * (2 / (step + known))
        if len(self.times) > 3:
            older = self.times[-3] - self.times[-4]
            bend = np.maximum(bend, np.sqrt(_squared(chord - (before - self._poses[-4][9:]) / older)) * (2 / (known + older)))
        bend = np.clip(bend, weight, _BELIEVABLE * weight)
        return np.asarray(np.sqrt(np.maximum(_squared(direct), _squared(chord))) + bend * (step + known / 2))

    def drift(self, bodies: IntArray) -> FloatArray:
        """(3, k) how far bodies have moved in the last interval, 0 before there is one."""
        if len(self.times) < 2:
            return np.zeros((3, len(bodies)))
        drift = self._poses[-1][9:, bodies] - self._poses[-2][9:, bodies]
        return np.where(np.isfinite(drift), drift, 0.0)

    def surprised(self, paths: Paths) -> BoolArray:
        """(n,) which bodies are neither where ``paths`` up to now led nor where they would be without acceleration."""
        t = paths.duration
        straight = paths.end[9:] - paths.start[9:] - paths.velocity * t
        bent = straight - paths.acceleration * (t * t / 2)
        return np.asarray(self.moving() & (np.minimum(_squared(straight), _squared(bent)) > _ASTRAY**2))

    def paths(self, kinematic: BoolArray, airborne: BoolArray, gravity: FloatArray) -> Paths | None:
        """Ways from the last frame but one to the last. None before there are three poses.

        ``kinematic`` (n,): known at both ends. ``airborne`` (n,): fall with ``gravity`` (3,) [m/s^2] where their own acceleration is not
        known.
        """
        if len(self.times) < 3:
            return None
        step, known, *older = (later - earlier for earlier, later in zip(self.times[-2::-1], self.times[:0:-1], strict=True))
        end, start, earlier = self._poses[-1], self._poses[-2], self._poses[-3]
        now, last, before = end[9:], start[9:], earlier[9:]
        weight = float(np.linalg.norm(gravity))
        chord, direct = (last - before) / known, (now - last) / step
        clean = self._clean - 1  # undisturbed intervals up to the start of the way
        # Dynamic: constant acceleration, measured where it can be believed.
        bend = np.where(airborne, gravity[:, None], 0.0)
        if older:
            measured = 2 * (chord - (before - self._poses[-4][9:]) / older[0]) / (known + older[0])
            believed = (clean >= 2) & (self._onset > 2) & (_squared(measured) <= (_BELIEVABLE * weight) ** 2)
            bend = np.where(believed, measured, bend)
        begin = chord + bend * (known / 2)
        if weight > 0:
            # Let go within the interval before: the speed that falling so far from rest gives.
            down = gravity / weight
            fallen = down @ chord * known
            level = _squared(chord * known - fallen * down[:, None])
            from_rest = (fallen > 0) & (fallen <= 0.501 * weight * known**2) & (level <= (0.1 * fallen) ** 2)
            dropped = (self._onset == 1) & airborne & from_rest
            begin = np.where(dropped, down[:, None] * np.sqrt(2 * weight * np.maximum(fallen, 0.0)), begin)
        # Kinematic: through both ends, unless it turned sharply in between, as what hits does. Hit in the interval before: what it has done
        # since is all that is known.
        curved = 2 * (direct - chord) / (step + known)
        smooth = kinematic & (4 * step**2 * _squared(curved) <= np.maximum(_squared(direct), _squared(chord)))
        given = smooth | (~kinematic & (clean < 1))
        moving = self.moving()
        acceleration = np.where(moving, np.where(smooth, curved, np.where(given, 0.0, bend)), 0.0)
        velocity = np.where(moving, np.where(given, direct - acceleration * (step / 2), begin), 0.0)
        spin = np.where(given, _spins(start, end, step), _spins(earlier, start, known))
        turned = kinematic & ~smooth & (clean < 1)
        return Paths(step, start, velocity, acceleration, np.where(moving, spin, 0.0), end, smooth, turned, earlier, known)


def _squared(vectors: FloatArray) -> FloatArray:
    """Squared lengths (n,) of vectors (3, n)."""
    return np.asarray(np.einsum("ip,ip->p", vectors, vectors))


def _spins(start: FloatArray, end: FloatArray, time: float) -> FloatArray:
    """Angular velocities (3, n) that turn the one poses into the others within ``time``, by less than half a turn."""
    a, b = start[:9].reshape(3, 3, -1), end[:9].reshape(3, 3, -1)
    turn = np.einsum("ikp,jkp->ijp", b, a)
    twist = np.stack([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = np.sqrt(_squared(twist)) / 2
    angle = np.arctan2(sine, (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1) / 2)
    turning = sine > 1e-9
    return np.asarray(twist * (np.where(turning, angle / np.where(turning, sine, 1.0), 1.0) / (2 * time)))


def rotations(vectors: FloatArray) -> FloatArray:
    """Rotation matrices (3, 3, n) of rotation vectors (3, n) [rad] (Rodrigues' formula)."""
    squared = _squared(vectors)
    angle = np.sqrt(squared)
    small = angle < 1e-6
    divisor = np.where(small, 1.0, angle)
    sine = np.where(small, 1.0 - squared / 6, np.sin(angle) / divisor)
    cosine = np.where(small, 0.5 - squared / 24, (1.0 - np.cos(angle)) / (divisor * divisor))
    result = vectors[:, None] * (vectors * cosine)
    result[[0, 1, 2], [0, 1, 2]] += 1.0 - cosine * squared
    x, y, z = vectors * sine
    result[0, 1] -= z
    result[0, 2] += y
    result[1, 0] += z
    result[1, 2] -= x
    result[2, 0] -= y
    result[2, 1] += x
    return np.asarray(result)
