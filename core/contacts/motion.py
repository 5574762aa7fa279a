"""How bodies move between two frames, from their poses at whole frames alone.

An engine tells poses, not velocities, and the pose of the frame in which a body hits something already has the bounce in it. So a body's
way up to its next hit is extrapolated from the frames before: position with constant acceleration, rotation with constant angular velocity.
Free fall is met exactly. A kinematic body's way is known at both ends and interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass

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
    ``rotation`` (n, 3, 3) turned about the body's origin as from ``turn_start`` to ``turn_end`` (n, 3, 3) within ``turn_time`` (n,)."""

    duration: float
    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    rotation: FloatArray
    turn_start: FloatArray
    turn_end: FloatArray
    turn_time: FloatArray

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
        """(n,) greatest speed of each body's origin on its way."""
        end = self.velocity + self.acceleration * self.duration
        return np.sqrt(np.maximum((self.velocity**2).sum(axis=1), (end**2).sum(axis=1)))


class MotionHistory:
    """The last poses of bodies, oldest first, and for how many intervals each has moved, and moved undisturbed."""

    def __init__(self, count: int) -> None:
        self.times: list[float] = []
        self._position = np.zeros((_DEPTH + 1, count, 3))
        self._rotation = np.zeros((_DEPTH + 1, count, 3, 3))
        self._still = np.zeros(count, dtype=np.int64)
        self._clean = np.zeros(count, dtype=np.int64)
        self._onset = np.zeros(count, dtype=np.int64)

    def advance(self, time: float, transforms: FloatArray, moved: BoolArray) -> None:
        """Add the poses (n, 4, 4) of a frame. Bodies that have not ``moved`` (n,) are taken to be where they were."""
        first = not self.times
        self.times = [*self.times[-_DEPTH:], time]
        self._onset = np.where(moved & (self._still > 0), 0, self._onset + 1)
        self._still = np.where(moved, 0, self._still + 1)
        rows = np.arange(len(moved)) if first else np.flatnonzero(self._still <= _DEPTH)
        for values, new in ((self._position, transforms[:, :3, 3]), (self._rotation, transforms[:, :3, :3])):
            values[:-1, rows] = values[1:, rows]
            values[-1, rows] = new[rows]
        if first:
            self._clean[:] = 0
            self._onset[:] = -1
        else:
            self._clean[rows] += 1

    def disturb(self, rows: IntArray) -> None:
        """Bodies ``rows`` have hit something in the last interval: their motion in it and before says nothing about what follows."""
        self._clean[rows] = 0

    def surprised(self, paths: Paths) -> BoolArray:
        """(n,) which bodies are neither where ``paths`` up to now led nor where they would be without acceleration."""
        rows = np.flatnonzero(self.moving)
        now, t = self._position[-1, rows], paths.duration
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
        turn_start, turn_end, turn_time = self._rotation[-3].copy(), self._rotation[-2].copy(), np.full(count, known)
        rows = np.flatnonzero(self.moving)
        now, last, before = (self._position[-k, rows] for k in (1, 2, 3))
        chord, direct = (last - before) / known, (now - last) / step
        clean = self._clean[rows] - 1  # undisturbed intervals up to the start of the way
        # Dynamic: constant acceleration, measured where it can be believed.
        bend = np.where(airborne[rows, None], gravity, 0.0)
        if older:
            earlier = (before - self._position[-4, rows]) / older[0]
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
        turn_start[late], turn_end[late], turn_time[late] = self._rotation[-2, late], self._rotation[-1, late], step
        return Paths(step, self._position[-2], velocity, acceleration, self._rotation[-2], turn_start, turn_end, turn_time)


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
