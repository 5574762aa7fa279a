"""Blows of the parts of skins, such as feet, where bones move them to touch another body.

A part strikes where material of it that was away comes to touch, with the speed at which it came
there in the last frames. It pushes with one mass, as the rest of the skin holds it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field, replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..frozen import frozen
from .body_poses import columns_of
from .body_table import BodyTable
from .hit_search import TOGETHER
from .impact_energies import inverse_mass
from .impacts import SLOWEST, Impact, impact_at
from .inertia import inertia_of
from .motion import approach
from .narrow.frames import relative_pose, turned, turned_back
from .settings import Body, ContactSettings
from .shapes import Compound, ConvexHull

_FRAMES = 4
"""Number of poses that are stored of each part: a blow is found from as many."""

_TOUCH = 1e-4
"""Distance [m] from which on a part is away."""


@frozen(eq=False)
class _Ground:
    """What a part stands on: a plane of another body, in whose frame are its unit ``normal`` (3, 1)
    towards the part and its ``height`` along that [m]."""

    normal: FloatArray
    height: float

    def gaps(self, turn: FloatArray, offset: FloatArray, points: FloatArray) -> FloatArray:
        """How far points (3, n) of a part are above it (k, n) [m], if that is placed in the frame
        of the other body by ``turn`` (3, 3, k) and ``offset`` (3, k)."""
        along = turned_back(turn, self.normal).T @ points
        return np.asarray(along + (offset.T @ self.normal) - self.height)


@frozen(eq=False)
class _Skin:
    """The world poses (12, p) of the p ``parts`` of a skin in the last frames; what each stands on,
    by number of the part and name of the other body, and the times of its blows [s]."""

    parts: tuple[FloatArray, ...] = ()
    grounds: dict[tuple[int, str], _Ground] = field(default_factory=dict)
    struck: dict[tuple[int, str], float] = field(default_factory=dict)


class Limbs:
    """The parts of skins from frame to frame."""

    def __init__(self, settings: ContactSettings) -> None:
        self._settings = settings
        self._skins: dict[str, _Skin] = {}

    def follow(
        self, bodies: Sequence[Body], table: BodyTable, transforms: FloatArray, anew: BoolArray
    ) -> None:
        """Go on to a frame in which bodies have these world ``transforms`` (n, 4, 4); some (n,)
        begin ``anew``."""
        before, self._skins = self._skins, {}
        for number in table.limbs:
            name, shape = bodies[number].name, bodies[number].shape
            assert isinstance(shape, Compound)
            parts = columns_of(transforms[number] @ shape.places)
            known = _Skin() if anew[number] else before.get(name, _Skin())
            poses = *known.parts[1 - _FRAMES :], parts
            self._skins[name] = replace(known, parts=poses)

    def history(self) -> tuple[FloatArray, ...]:
        """What later blows depend on."""
        return tuple(parts for skin in self._skins.values() for parts in skin.parts)

    def impacts(
        self,
        bodies: Sequence[Body],
        table: BodyTable,
        pairs: IntArray,
        times: Sequence[float],
        poses: Sequence[FloatArray],
    ) -> list[Impact]:
        """The blows since the frame before.

        Args:
            bodies: by number.
            table: of the bodies.
            pairs: numbers of those that may touch (p, 2).
            times: of the last frames, this one as the last [s].
            poses: (12, n) of the bodies in these frames.
        """
        found = []
        times, poses = times[-_FRAMES:], poses[-_FRAMES:]
        for pair in pairs.tolist():
            for number, other in (pair, pair[::-1]):
                skin = self._skins.get(bodies[number].name, _Skin())
                if (
                    len(skin.parts) == len(times) == _FRAMES
                    and table.layers[number] & table.layers[other]
                ):
                    of = number, other, skin, times, poses
                    found += _Search(self._settings, bodies, table, *of).impacts()
        return found


@frozen(eq=False)
class _Search:
    """The search for blows of the parts of a ``skin``, the body ``number``, on an ``other`` one in
    the interval before the last of some ``times``; the rest as in `Limbs.impacts`."""

    settings: ContactSettings
    bodies: Sequence[Body]
    table: BodyTable
    number: int
    other: int
    skin: _Skin
    times: Sequence[float]
    poses: Sequence[FloatArray]

    def _key(self, part: int) -> tuple[int, str]:
        return part, self.bodies[self.other].name

    def impacts(self) -> list[Impact]:
        """The impacts of parts."""
        table, number, other = self.table, self.number, self.other
        shape = self.bodies[number].shape
        assert isinstance(shape, Compound)
        low, high = shape.part_bounds.transpose(1, 2, 0)
        middle, half = (low + high) / 2, (high - low) / 2
        parts = self.skin.parts
        turn, offset = relative_pose(self.poses[-1][:, [other]], parts[-1])
        away = np.abs(turned(turn, middle) + offset - table.middle[:, [other]])
        away -= turned(np.abs(turn), half) + table.extent[:, [other]]
        one, two = np.array([[number], [other]])
        tolerance = table.tolerance(one, two, self.settings.tolerance)
        near = np.flatnonzero((away <= tolerance).all(axis=0)).tolist()
        for key in [*self.skin.grounds]:
            if key == self._key(key[0]) and key[0] not in near:
                del self.skin.grounds[key]
        found = []
        for part in near:
            hull = shape.parts[part]
            assert isinstance(hull, ConvexHull)
            way = parts[-1][:, part] - parts[-3][:, part]
            most = math.hypot(*(way[:9].reshape(3, 3) @ middle[:, part] + way[9:]))
            most += math.hypot(*way[:9]) * math.hypot(*half[:, part])
            if most > SLOWEST * (self.times[-1] - self.times[-3]):
                others = np.array([poses[:, other] for poses in self.poses]).T
                own = np.array([poses[:, part] for poses in parts]).T
                placing = relative_pose(others, own)
                if self._lands(part, hull, *placing, tolerance):
                    found += self._blow(part, *placing, tolerance)
        return found

    def _lands(
        self,
        part: int,
        hull: ConvexHull,
        turns: FloatArray,
        offsets: FloatArray,
        tolerance: FloatArray,
    ) -> bool:
        """Whether material of a part that was away may have come to touch; the arguments are those
        of `_blow`, and the ``hull`` of the part. What has left the ground stands there no more."""
        ground = self.skin.grounds.get(self._key(part))
        if ground is None:
            return True
        last, now = ground.gaps(turns[..., -2:], offsets[:, -2:], hull.points.T)
        if now.min() > tolerance:
            del self.skin.grounds[self._key(part)]
        slow = SLOWEST * (self.times[-1] - self.times[-2])
        return bool(((now <= _TOUCH) & (last > max(slow, _TOUCH))).any())

    def _blow(
        self, part: int, turns: FloatArray, offsets: FloatArray, tolerance: FloatArray
    ) -> list[Impact]:
        """The impact of a part on the other body: a list of one, or of none.

        Args:
            part: its number.
            turns, offsets: how it was placed in the other body's frame (3, 3, k) and (3, k).
            tolerance: distance up to which it touches that (1,) [m].
        """
        table, grounds, key = self.table, self.skin.grounds, self._key(part)
        turn, offset = turns[..., -1:], offsets[:, -1:]
        placing = np.array([[self.other, table.limbs[self.number] + part]]), turn, offset, tolerance
        patch = table.narrow.query(*placing)
        if patch.distance > tolerance:
            grounds.pop(key, None)
            return []
        normal, gap = patch.normal, float(patch.distance[0])
        ground = _Ground(normal, float((normal * patch.centre).sum()) - gap / 2)

        def gaps_of(middles: FloatArray) -> FloatArray:
            """How far what is now at these places (3, n) was from the other body (k, n) [m]."""
            on_part = middles + normal * (gap / 2) - offset
            return ground.gaps(turns, offsets, turn[..., 0].T @ on_part)

        before, last = -np.diff(gaps_of(patch.centre)[-3:, 0])
        if gap > _TOUCH and last > before / 2:
            return []  # it goes on
        grounds[key] = ground
        _, corners = table.narrow.corners(*placing, normal, patch.centre)
        gaps = gaps_of(corners)
        speeds, after = approach(gaps, np.diff(self.times))
        speeds[gaps[-2] <= _TOUCH] = 0.0
        speed, mass = float(speeds.max()), limb_mass(self.bodies[self.number], part)
        time = self.times[-2] + float(after[speeds.argmax()])
        first, second = sorted([self.number, self.other])
        limits = self.settings.impact_limits(self.bodies[first].named, self.bodies[second].named)
        again = time - self.skin.struck.get(key, -np.inf) < limits.refractory
        if not mass or speed <= SLOWEST or again:
            return []
        with_it = speeds >= TOGETHER * speed
        middle = patch.centre[:, 0] if with_it.all() else corners[:, with_it].mean(axis=1)
        pose, earlier = self.poses[-1][:, self.other], self.poses[-2][:, self.other]
        frame = pose[:9].reshape(3, 3)
        centre, normal = frame @ middle + pose[9:], frame @ normal[:, 0]
        moves, movable = bool((pose != earlier).any()), bool(table.movable[self.other])
        of = self.bodies[self.other], movable, moves, pose
        felt = 1 / mass + inverse_mass(*of, centre, normal)
        energy = (speed / self.settings.time_scale) ** 2 / (2 * felt)
        if energy < (limits.least_energy or 0.0):
            return []
        self.skin.struck[key] = time
        towards = normal if first == self.other else -normal
        full = limits.full_energy or table.full_energy
        return [impact_at((first, second), time, (centre, towards, gap), energy, full, True)]


def limb_mass(body: Body, part: int) -> float:
    """The mass [kg] with which a part of a skin strikes: that which is known of it, else that of
    its volume."""
    if body.limbs[part]:
        return body.limbs[part]
    assert isinstance(body.shape, Compound)
    parts = body.shape.parts
    volume = inertia_of(parts[part]).volume
    if body.mass is None:
        return volume * body.density
    return body.mass * volume / sum(inertia_of(each).volume for each in parts)
