"""How bodies move between two frames, from their poses at whole frames alone.

An engine tells poses, not velocities, and the pose of the frame in which a body hits something already has the bounce in it. So a body's
way up to its next hit is extrapolated from the frames before: position with constant acceleration, rotation with constant angular velocity.
Free fall is met exactly. A kinematic body's way is known at both ends and interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_DEPTH = 3
"""Poses that are remembered before the current one."""

_BELIEVABLE = 2.5
"""Accelerations up to so many times gravity are taken from the second difference of poses; larger ones come from a hit in between."""


_ASTRAY = 0.001
"""Metres by which a body misses where its motion led it if it was disturbed on the way."""


@dataclass(frozen=True, slots=True)
class Paths:
    """The ways of bodies from one frame to the next, ``duration`` seconds: ``position + velocity t + acceleration t^2 / 2`` (n, 3), and
    ``rotation`` (n, 3, 3) turned about the body's origin as from ``turn_start`` to ``turn_end`` (n, 3, 3) within ``turn_time`` (n,).
    ``end_position`` and ``end_rotation``: where the bodies really are then."""

    duration: float
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    rotation: FloatArray
    turn_start: FloatArray
    turn_end: FloatArray
    turn_time: FloatArray
    end_position: FloatArray
    end_rotation: FloatArray

    def to_the_ends(self) -> Paths:
        """The ways that lead from the same starts with the same accelerations to where the bodies really are at the end."""
        direct = (self.end_position - self.position) / self.duration
        velocity = direct - self.acceleration * (self.duration / 2)
        turn_time = np.full(len(velocity), self.duration)
        return replace(self, velocity=velocity, turn_start=self.rotation, turn_end=self.end_rotation, turn_time=turn_time)

    def spins(self, rows: IntArray) -> FloatArray:
        """Angular velocities (k, 3) [rad/s] of bodies ``rows`` (k,)."""
        turn = self.turn_end[rows] @ self.turn_start[rows].transpose(0, 2, 1)
        return np.asarray(rotation_vectors(turn) / self.turn_time[rows, None])

    def matrices(self, rows: IntArray, time: FloatArray | float, spins: FloatArray | None = None) -> FloatArray:
        """World matrices (k, 4, 4) of bodies ``rows`` at ``time`` (k,) seconds after the start; ``spins`` if they are known."""
        t = np.broadcast_to(np.asarray(time, dtype=np.float64), rows.shape)[:, None]
        matrices = np.zeros((len(rows), 4, 4))
        matrices[:, 3, 3] = 1.0
        matrices[:, :3, 3] = self.position[rows] + self.velocity[rows] * t + self.acceleration[rows] * (t * t / 2)
        matrices[:, :3, :3] = rotations((self.spins(rows) if spins is None else spins) * t) @ self.rotation[rows]
        return matrices

    def velocities(self, rows: IntArray, time: FloatArray | float) -> FloatArray:
        """Velocities (k, 3) of the origins of bodies ``rows`` at ``time``."""
        t = np.broadcast_to(np.asarray(time, dtype=np.float64), rows.shape)[:, None]
        return np.asarray(self.velocity[rows] + self.acceleration[rows] * t)

    def fastest(self) -> FloatArray:
        """(n,) greatest speed of each body's origin on its way, or on the straight one to where it really is at the end."""
        end = self.velocity + self.acceleration * self.duration
        direct = (self.end_position - self.position) / self.duration
        return np.asarray(np.maximum(np.maximum(_length(self.velocity), _length(end)), _length(direct)))


class MotionHistory:
    """The last poses of bodies, and for how many intervals each has moved, and moved undisturbed."""

    def __init__(self, count: int) -> None:
        self.times: list[float] = []
        self._poses: list[FloatArray] = []
        self._still = np.zeros(count, dtype=np.int64)
        self._clean = np.zeros(count, dtype=np.int64)
        self._onset = np.full(count, -2)

    @property
    def step(self) -> float:
        """Seconds between the last two frames, 0 before there are two."""
        return self.times[-1] - self.times[-2] if len(self.times) > 1 else 0.0

    def advance(self, time: float, poses: FloatArray, moved: IntArray) -> None:
        """Add a frame: the upper three rows of all matrices (n, 12), and the numbers of the bodies that have moved. ``poses`` is kept."""
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

    def disturb(self, rows: IntArray) -> None:
        """Bodies ``rows`` have hit something in the last interval: their motion in it and before says nothing about what follows."""
        self._clean[rows] = 0

    def _positions(self, back: int, rows: IntArray | slice = slice(None)) -> FloatArray:
        return self._poses[-back][rows][:, 3::4]

    def _rotations(self, back: int) -> FloatArray:
        return self._poses[-back].reshape(-1, 3, 4)[:, :, :3]

    def speed_bound(self, gravity: FloatArray) -> FloatArray:
        """(n,) what the speed of each body in the last interval can have been at most, as far as poses tell; 0 before there are three."""
        if len(self.times) < 3:
            return np.zeros(len(self._still))
        step, known = self.times[-1] - self.times[-2], self.times[-2] - self.times[-3]
        now, last, before = (self._positions(k) for k in (1, 2, 3))
        squared = np.maximum(((now - last) ** 2).sum(axis=1) / step**2, ((last - before) ** 2).sum(axis=1) / known**2)
        return np.asarray(np.sqrt(squared) + _BELIEVABLE * float(np.linalg.norm(gravity)) * (step + known))

    def drift(self, rows: IntArray) -> FloatArray:
        """(k, 3) how far bodies ``rows`` have moved in the last interval, 0 before there is one."""
        if len(self.times) < 2:
            return np.zeros((len(rows), 3))
        drift = self._positions(1, rows) - self._positions(2, rows)
        return np.where(np.isfinite(drift), drift, 0.0)

    def surprised(self, paths: Paths) -> BoolArray:
        """(n,) which bodies are neither where ``paths`` up to now led nor where they would be without acceleration."""
        rows = np.flatnonzero(self.moving)
        now, t = self._positions(1, rows), paths.duration
        straight = paths.position[rows] + paths.velocity[rows] * t
        bent = straight + paths.acceleration[rows] * (t * t / 2)
        surprised = np.zeros(len(self._still), dtype=np.bool_)
        surprised[rows] = np.minimum(_length(now - straight), _length(now - bent)) > _ASTRAY
        return surprised

    @property
    def moving(self) -> BoolArray:
        """(n,) which bodies have moved within the frames remembered."""
        return self._still <= _DEPTH

    def paths(self, kinematic: BoolArray, airborne: BoolArray, gravity: FloatArray) -> Paths | None:
        """Ways from the last frame but one to the last. None before there are three poses.

        ``kinematic`` (n,): known at both ends. ``airborne`` (n,): fall with ``gravity`` (3,) [m/s^2] where their own acceleration is not
        known.
        """
        if len(self.times) < 3:
            return None
        step, known, *older = (later - earlier for earlier, later in zip(self.times[-2::-1], self.times[:0:-1], strict=True))
        count = len(self._still)
        velocity, acceleration = np.zeros((count, 3)), np.zeros((count, 3))
        turn_start, turn_end, turn_time = self._rotations(3).copy(), self._rotations(2).copy(), np.full(count, known)
        rows = np.flatnonzero(self.moving)
        now, last, before = (self._positions(k, rows) for k in (1, 2, 3))
        chord, direct = (last - before) / known, (now - last) / step
        clean = self._clean[rows] - 1  # undisturbed intervals up to the start of the way
        # Dynamic: constant acceleration, measured where it can be believed.
        bend = np.where(airborne[rows, None], gravity, 0.0)
        if older:
            earlier = (before - self._positions(4, rows)) / older[0]
            measured = 2 * (chord - earlier) / (known + older[0])
            believed = (clean >= 2) & (self._onset[rows] > 2) & (_length(measured) <= _BELIEVABLE * float(np.linalg.norm(gravity)))
            bend = np.where(believed[:, None], measured, bend)
        start = chord + bend * (known / 2)
        # Let go within the interval before: the speed that falling so far from rest gives.
        weight = float(np.linalg.norm(gravity))
        if weight > 0:
            down = gravity / weight
            fallen = chord @ down * known
            level = _length(chord * known - fallen[:, None] * down)
            from_rest = (fallen > 0) & (fallen <= 0.501 * weight * known**2) & (level <= 0.1 * fallen)
            dropped = (self._onset[rows] == 1) & airborne[rows] & from_rest
            start = np.where(dropped[:, None], down * np.sqrt(2 * weight * np.maximum(fallen, 0.0))[:, None], start)
        # Kinematic: through both ends. Hit in the interval before: what it has done since is all that is known.
        curved = 2 * (direct - chord) / (step + known)
        smooth = _length(curved) * step <= 0.5 * np.maximum(_length(direct), _length(chord))
        given = kinematic[rows] | (clean < 1)
        bend = np.where(given[:, None], np.where((kinematic[rows] & smooth)[:, None], curved, 0.0), bend)
        acceleration[rows] = bend
        velocity[rows] = np.where(given[:, None], direct - bend * (step / 2), start)
        late = rows[given]
        turn_start[late], turn_end[late], turn_time[late] = self._rotations(2)[late], self._rotations(1)[late], step
        turns = (turn_start, turn_end, turn_time)
        ends = (self._positions(1), self._rotations(1))
        return Paths(step, self._positions(2), velocity, acceleration, self._rotations(2), *turns, *ends)


def _length(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt((vectors**2).sum(axis=1)))


def rotations(vectors: FloatArray) -> FloatArray:
    """Rotation matrices (n, 3, 3) of rotation vectors (n, 3) [rad] (Rodrigues' formula)."""
    squared = (vectors**2).sum(axis=1)
    angle = np.sqrt(squared)
    small = angle < 1e-6
    divisor = np.where(small, 1.0, angle)
    sine = np.where(small, 1.0 - squared / 6, np.sin(angle) / divisor)
    cosine = np.where(small, 0.5 - squared / 24, (1.0 - np.cos(angle)) / (divisor * divisor))
    x, y, z = vectors.T
    cross = np.zeros((len(vectors), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -z, y, -x
    cross[:, 1, 0], cross[:, 2, 0], cross[:, 2, 1] = z, -y, x
    return np.asarray(np.eye(3) + sine[:, None, None] * cross + cosine[:, None, None] * (cross @ cross))


def rotation_vectors(matrices: FloatArray) -> FloatArray:
    """Rotation vectors (n, 3) [rad] of rotation matrices (n, 3, 3), angles below a half turn."""
    twist = np.stack(
        [
            matrices[:, 2, 1] - matrices[:, 1, 2],
            matrices[:, 0, 2] - matrices[:, 2, 0],
            matrices[:, 1, 0] - matrices[:, 0, 1],
        ],
        axis=1,
    )
    sine = np.sqrt((twist**2).sum(axis=1)) / 2
    cosine = (np.einsum("nii->n", matrices) - 1) / 2
    angle = np.arctan2(sine, cosine)
    return twist / 2 * np.where(sine > 1e-9, angle / np.where(sine > 1e-9, sine, 1.0), 1.0)[:, None]
