"""Contacts from frame to frame: begin, end and impacts, recomputed only where something moved."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, carried, chosen_of, connected
from ..frozen import frozen
from ..message import Cause, Message
from .broad_phase import overlapping_pairs
from .contact_set import ContactSet
from .impacts import Hits, Impact, confirmed, impact_energies, landings
from .motion import MotionHistory, Paths
from .narrow.body_patches import PairPatches
from .narrow.frames import added, dot, relative_pose, smooth_step, turned, turned_back, upwards
from .narrow.narrow_phase import NarrowPhase
from .settings import Body, ContactSettings, ImpactEnergy, Motion
from .shapes import Compound
from .time_of_impact import Meetings, TimeOfImpact

_COLUMNS = np.array([0, 1, 2, 4, 5, 6, 8, 9, 10, 3, 7, 11])
"""Indices of the rotation and then the position in the upper three rows of a 4 x 4 matrix."""


STILL = 1e-5
"""Metres of motion below which a body counts as at rest: simulations at rest tremble, and poses are
float32."""

_NO_MOTION = 1e-12
"""Metres of relative motion that are rounding: two bodies that move together keep their contact."""

_RESTING = 0.2
"""Part of the tolerance up to which a gap counts as that of bodies at rest; up to twice that,
corners and edges touch."""

_EDGE_WEIGHT = 0.1
"""Weight of a corner or an edge of a box that is near but does not touch, relative to faces at the
same distance."""

_FACING = 0.05
"""Part of a body's face covered by the patch at which the contact counts half as one of faces."""

_PRESSING_DISTANCE = 2e-3
"""Distance below which bodies count as pressing on each other [m]."""

_CREEP = 0.05
"""Speed of approach [m/s] up to which touching bodies have come to rest against each other."""

_STRONGER = 1.25
"""Factor of the last impact's speed (2 dB) above which another one counts within the refractory
time."""

_TIPPING = 1 / 24
"""Seconds after the refractory time within which another part of a body that still touches may
land, whatever the frame rate."""

_FRAMES_AHEAD = 3
"""Frames in which gravity may accelerate a body to an impact: its contacts are watched that long
before, requested or not."""

_DEAD_ENDS = 8
"""Bodies on a dead end that are left out, counted from its tip."""

_WIDENING = 0.05
"""Metres by which the bounds of the broad phase are widened, so that they hold for several
frames."""


@frozen
class ContactStatistics:
    """Work of one update: ``candidates`` (pairs with overlapping bounds), narrow-phase ``queries``
    made, time of the broad phase [s]."""

    candidates: int = 0
    queries: int = 0
    broad_seconds: float = field(default=0.0, compare=False)

    @property
    def avoided(self) -> int:
        """Candidates without a query."""
        return max(0, self.candidates - self.queries)


@frozen(eq=False)
class Endpoints:
    """Where signals begin and end: bodies (n,) with a source that sounds (``sounding``), and with a
    listener (``heard``). ``paths``: contacts on dead ends, which no path between these bodies
    crosses, are not wanted either."""

    heard: BoolArray
    sounding: BoolArray
    paths: bool = False


@frozen
class FrameContacts:
    """The contacts of one frame, and what has changed since the last one.

    Attributes:
        contacts: sorted by the numbers of the bodies; the same object as in the last frame where
            nothing has changed.
        began: pairs (k, 2) that touch and did not in the last frame.
        ended: pairs (k, 2) that touched in the last frame and do not now.
        impacts: sorted by time.
        statistics: work of the update.
        warnings: about objects.
    """

    contacts: ContactSet
    began: IntArray
    ended: IntArray
    impacts: tuple[Impact, ...]
    statistics: ContactStatistics
    warnings: tuple[Message, ...]


# Rows of `_Pairs.values`, in the frame of the larger body unless said otherwise: centre of the
# smaller body's bounds, its rotation, the contact node on the larger body and (in the frame of the
# smaller body) that on the smaller one, normal from larger to smaller, distance, area.
_PLACE = slice(0, 3)
_TURN = slice(3, 12)
_ON_LARGER = slice(12, 15)
_ON_SMALLER = slice(15, 18)
_NORMAL = slice(18, 21)
_DISTANCE, _AREA, _ROWS = 21, 22, 23


@dataclass(slots=True)
class _Pairs:
    """Candidates: the p pairs of bodies whose bounds overlap, and what is known of each.

    Attributes:
        key: (p,) smaller number * n + larger number of the bodies, ascending.
        larger, smaller: (p,) numbers of the bodies, by their size.
        known: (p,) whether ``values`` are those of a query.
        touching: (p,) in contact.
        struck: (p,) no further impact until the pair parts.
        examined: (p,) whether the pair was queried, or found unmoved, in the last frame. Pairs that
            no signal can pass are not.
        version: (2, p) counts of pose changes of the larger and of the smaller body at the query.
        values: (rows, p) result of the last query.
    """

    key: IntArray
    larger: IntArray
    smaller: IntArray
    known: BoolArray
    touching: BoolArray
    struck: BoolArray
    examined: BoolArray
    version: IntArray
    values: FloatArray

    @classmethod
    def of(cls, key: IntArray, larger: IntArray, smaller: IntArray) -> _Pairs:
        """Pairs without a query so far."""
        count = len(key)
        known, touching, struck = np.zeros((3, count), dtype=np.bool_)
        examined = np.ones(count, dtype=np.bool_)
        version = np.full((2, count), -1)
        return cls(
            key,
            larger,
            smaller,
            known,
            touching,
            struck,
            examined,
            version,
            np.zeros((_ROWS, count)),
        )

    def carried_to(self, key: IntArray, larger: IntArray, smaller: IntArray) -> _Pairs:
        """The pairs ``key``; those that were candidates before keep their state."""
        if np.array_equal(key, self.key):
            return self
        if len(self.key) == 0 or len(key) == 0:
            return _Pairs.of(key, larger, smaller)
        place = np.minimum(np.searchsorted(self.key, key), len(self.key) - 1)
        here = self.key[place] == key
        carried = chosen_of(self, place)
        carried.key, carried.larger, carried.smaller = key, larger, smaller
        for state in (carried.known, carried.touching, carried.struck):
            state &= here
        carried.examined |= ~here
        return carried


class ContactTracker:
    """Follows the contacts of ``bodies`` from frame to frame. What is known of their shapes it
    takes over from the one ``before``."""

    def __init__(
        self,
        bodies: Sequence[Body],
        settings: ContactSettings | None = None,
        before: ContactTracker | None = None,
    ) -> None:
        self.settings = settings or ContactSettings()
        limits = self.settings.all_limits()
        self._least = min(item.least_energy for item in limits)
        self._refractory = max(item.refractory for item in limits)
        self.bodies: tuple[Body, ...] = ()
        self._local: list[FloatArray] = []  # bounds (2, 3) of each body in its own space
        self._set_bodies(tuple(bodies), None if before is None else before._narrow)
        self.reset()

    def _set_bodies(self, bodies: tuple[Body, ...], before: NarrowPhase | None = None) -> None:
        """Set all that depends on bodies and shapes alone. Shapes that are the same objects as now
        keep their bounds, and in ``before`` what the narrow phase has computed for them."""
        known = {id(b.shape): bounds for b, bounds in zip(self.bodies, self._local, strict=True)}
        self._local = [
            b.shape.local_bounds() if (at := known.get(id(b.shape))) is None else at for b in bodies
        ]
        self.bodies = bodies
        local = np.array(self._local).reshape(-1, 2, 3)
        count = len(bodies)
        self._middle, self._extent = np.empty((2, 3, count))
        self._radius, self._reach = np.empty((2, count))
        self._rest_limits = np.empty((12, count))
        self._set_sizes(slice(count), local)
        self._narrow = NarrowPhase([b.shape for b in bodies], [b.medium for b in bodies], before)
        self._time_of_impact = TimeOfImpact(self._narrow, local)
        self._mass = np.array([b.mass or 0.0 for b in bodies], dtype=np.float64)
        self._dynamic = np.array([b.motion is Motion.DYNAMIC for b in bodies], dtype=np.bool_)
        self._medium = np.array([b.medium for b in bodies], dtype=np.bool_)

    def _set_sizes(self, bodies: slice, local: FloatArray) -> None:
        """Set what depends on the ``local`` bounds (k, 2, 3) of some bodies: their middle and half
        extents (3,) in the body's space, their radius about the middle, their reach from the body's
        origin [m], and the changes of the 12 elements of a pose that count as rest."""
        self._middle[:, bodies] = local.mean(axis=1).T
        self._extent[:, bodies] = (np.ptp(local, axis=1) / 2).T
        self._radius[bodies] = np.sqrt((self._extent[:, bodies] ** 2).sum(axis=0))
        reach = self._reach[bodies] = np.sqrt((np.abs(local).max(axis=1) ** 2).sum(axis=1))
        self._rest_limits[:, bodies] = STILL / np.stack(
            [reach] * 9 + [np.ones_like(reach)] * 3
        ).clip(1e-9)

    def reset(self) -> None:
        """Drop all history: the next update begins no contact and makes no impact."""
        count = len(self.bodies)
        none = np.zeros(0, dtype=np.int64)
        self._history = MotionHistory(count)
        self._pose = np.full((12, count), np.nan)
        self._rest_pose = self._pose.copy()
        self._version = np.zeros(count, dtype=np.int64)
        self._low = np.full((3, count), np.inf)
        self._high = np.full((3, count), -np.inf)
        self._wide_low, self._wide_high = self._low.copy(), self._high.copy()
        self._last_bounds = self._low.copy(), self._high.copy()
        # Near pairs (their wide bounds overlap) by key and body numbers. Candidates are those
        # among them whose bounds overlap in this frame.
        self._near, self._near_larger, self._near_smaller = none, none, none
        self._pairs = _Pairs.of(none, none, none)
        self._airborne = self._dynamic.copy()
        self._new = np.ones(count, dtype=np.bool_)  # bodies without an update so far
        # Of each pair, by key: time of its last impact [s] and speed of approach in it [m/s].
        self._last_impact: dict[int, tuple[float, float]] = {}
        self._queries = 0
        self._no_motion = _NO_MOTION
        self._update_began = 0.0
        self._last: FrameContacts | None = None
        self._reported = np.zeros((3, 0), dtype=np.int64)
        self._last_endpoints: Endpoints | None = None
        self._heap = np.arange(count)  # of each body: connected component of the near pairs

    def history(self) -> tuple[FloatArray | IntArray | BoolArray, ...]:
        """The state that later frames depend on, except their own poses: motion, contacts, and
        recent impacts."""
        pairs = self._pairs
        since = (
            self._history.times[-1] - self._refractory - _TIPPING if self._history.times else 0.0
        )
        touching = pairs.touching.nonzero()[0]
        recent = np.array(
            [(key, *last) for key, last in sorted(self._last_impact.items()) if last[0] >= since]
        )
        pair_state = pairs.key[touching], pairs.struck[touching], pairs.values[:, touching]
        return *self._history.history(), *pair_state, self._airborne, recent

    def replace_bodies(self, bodies: Sequence[Body], anew: frozenset[str] = frozenset()) -> None:
        """Replace the list of bodies, or shapes and masses of some. A body whose name was in the
        list before keeps its motion and contacts, unless it begins ``anew``, by name; the next
        update makes no impact of the others."""
        known = {body.name: body for body in self.bodies if body.name not in anew}
        names = [body.name for body in bodies]
        changed = np.array(
            [(old := known.get(body.name)) is not body and old != body for body in bodies],
            dtype=np.bool_,
        )
        same = names == [body.name for body in self.bodies]
        if names != list(known):
            self._renumber(names, known)
        if same and all(
            bodies[k] == self.bodies[k] or self._move_parts(k, bodies[k])
            for k in changed.nonzero()[0].tolist()
        ):
            self.bodies = tuple(bodies)
        else:
            self._set_bodies(tuple(bodies), self._narrow)
        self._pose[:, changed] = self._rest_pose[:, changed] = np.nan
        self._wide_low[:, changed], self._wide_high[:, changed] = np.inf, -np.inf
        self._near_larger, self._near_smaller = self._by_size(self._near)
        pairs = self._pairs
        pairs.larger, pairs.smaller = self._by_size(pairs.key)
        pairs.known &= ~(changed[pairs.larger] | changed[pairs.smaller])
        self._version[changed] += 1

    def _renumber(self, names: Sequence[str], known: Collection[str]) -> None:
        """Renumber the whole state by a new list of ``names``. The state of bodies that are not in
        that list, or whose names are not ``known``, is dropped."""
        number = {body.name: k for k, body in enumerate(self.bodies) if body.name in known}
        before = np.array([number.get(name, -1) for name in names], dtype=np.int64)
        there = before >= 0
        after = np.full(len(self.bodies), -1)
        after[before[there]] = there.nonzero()[0]

        def renumbered(key: IntArray) -> tuple[IntArray, IntArray]:
            """The rows of the pairs that remain, and their new keys, sorted."""
            pairs = np.sort(after[self._numbers(key)], axis=1)
            rows = (pairs[:, 0] >= 0).nonzero()[0]
            found: IntArray = pairs[rows, 0] * len(names) + pairs[rows, 1]
            order = found.argsort()
            return rows[order], found[order]

        self._near = renumbered(self._near)[1]
        self._heap = connected(
            np.stack(np.divmod(self._near, max(len(names), 1)), axis=1), len(names)
        )
        rows, key = renumbered(self._pairs.key)
        self._pairs = chosen_of(self._pairs, rows)
        self._pairs.key = key
        struck = np.array([*self._last_impact], dtype=np.int64)
        rows, key = renumbered(struck)
        self._last_impact = {
            new: self._last_impact[old]
            for new, old in zip(key.tolist(), struck[rows].tolist(), strict=True)
        }
        self._history.renumber(before)
        self._last_bounds = (
            carried(self._last_bounds[0], before, np.inf),
            carried(self._last_bounds[1], before, -np.inf),
        )
        for name, fresh in (
            ("_pose", np.nan),
            ("_rest_pose", np.nan),
            ("_version", 0),
            ("_low", np.inf),
            ("_high", -np.inf),
            ("_wide_low", np.inf),
            ("_wide_high", -np.inf),
            ("_airborne", True),
            ("_new", True),
        ):
            setattr(self, name, carried(getattr(self, name), before, fresh))
        self._last = None

    def _move_parts(self, number: int, body: Body) -> bool:
        """Move the parts of a compound, as bones do. Returns False, without a change, if ``body``
        differs from body ``number`` in anything but the poses of its parts."""
        old = self.bodies[number].shape
        new = body.shape
        if (
            not isinstance(old, Compound)
            or not isinstance(new, Compound)
            or [shape for shape, _ in old.children] != [shape for shape, _ in new.children]
            or replace(body, shape=old) != self.bodies[number]
            or old.margin != new.margin
        ):
            return False
        local = new.local_bounds()
        if not self._narrow.place(number, new, local):
            return False
        self._local[number] = local
        self._set_sizes(slice(number, number + 1), local[None])
        self._time_of_impact.measure(number, local)
        return True

    def update(
        self,
        time: float,
        transforms: FloatArray,
        endpoints: Endpoints | None = None,
        continuous: bool = True,
        impacts: bool = True,
        exact: bool = False,
    ) -> FrameContacts:
        """The contacts at ``time`` [s] under rigid world ``transforms`` (n, 4, 4), scale being in
        the shapes.

        Args:
            time: of this frame, after that of the last one.
            transforms: rows by the number of the body.
            endpoints: restricts the contacts to those through which a signal may pass: of bodies
                that chains of near pairs join to a listener, and to a source or an impact. Impacts
                are found all the same. None: all contacts. A pair that was not examined in the last
                frame gets no slack.
            continuous: False drops all history, as this frame does not follow the last one.
            impacts: False finds none; pairs that touch meanwhile make an impact only after they
                have parted.
            exact: contacts are computed again for all bodies that have moved, even if only by
                rounding.

        A body whose transform is not finite is left out, with a warning.
        """
        transforms = np.asarray(transforms, dtype=np.float64)
        if transforms.shape != (len(self.bodies), 4, 4):
            raise ValueError(
                f"transforms: expected {len(self.bodies)} matrices of 4 x 4, got an array of "
                f"shape {transforms.shape}"
            )
        if not continuous or (self._history.times and time <= self._history.times[-1]):
            self.reset()
        self._queries = 0
        self._update_began = perf_counter()
        moved, warnings = self._update_poses(time, transforms)
        self._no_motion = _NO_MOTION
        if exact:
            self._no_motion = 0.0
            self._rest_pose[:] = self._pose
            self._pairs.version[:] = -1
        elif (
            self._last is not None
            and len(moved) == 0
            and _same_request(endpoints, self._last_endpoints)
        ):
            return self._unchanged(warnings)
        paths, able = self._near_pairs(moved, impacts)
        striking = self._may_strike() if impacts else np.zeros(len(self.bodies), dtype=np.bool_)
        if not impacts:
            self._history.disturb(~striking)
        elif endpoints is not None:
            pairs = self._pairs
            late = (~pairs.examined & (striking[pairs.larger] | striking[pairs.smaller])).nonzero()[
                0
            ]
            if self._examine_last_frame(late):
                paths, able = self._near_pairs(moved, impacts)
        result = self._contacts(endpoints, paths, striking, able, warnings)
        if not impacts:
            self._pairs.struck |= self._pairs.touching
        self._last, self._last_endpoints = result, endpoints
        self._new[:] = False
        return result

    def _by_size(self, key: IntArray) -> tuple[IntArray, IntArray]:
        """Numbers of the larger and of the smaller body of each pair, by ``key``."""
        first = key // max(len(self.bodies), 1)
        second = key % max(len(self.bodies), 1)
        larger = self._radius[first] >= self._radius[second]
        return np.where(larger, first, second), np.where(larger, second, first)

    def _numbers(self, key: IntArray) -> IntArray:
        """Numbers of the bodies (k, 2) of pairs by ``key``, smaller number first."""
        return np.stack([key // max(len(self.bodies), 1), key % max(len(self.bodies), 1)], axis=1)

    def _update_poses(
        self, time: float, transforms: FloatArray
    ) -> tuple[IntArray, tuple[Message, ...]]:
        """Store the poses that have changed. Returns the numbers of their bodies, and warnings
        about bodies left out."""
        columns = transforms.reshape(-1, 16).T.take(_COLUMNS, axis=0)
        moved = (columns != self._pose).any(axis=0).nonzero()[0]
        if len(moved) == 0:
            self._history.advance(time, columns, moved)
            return moved, ()
        self._last_bounds = self._low.copy(), self._high.copy()
        finite = np.isfinite(columns[:, moved]).all(axis=0)
        moved, lost = moved[finite], moved[~finite]
        gone = lost[np.isfinite(self._pose[0, lost])]
        self._low[:, gone], self._high[:, gone] = np.inf, -np.inf
        self._version[gone] += 1
        self._pose[:, lost] = self._rest_pose[:, lost] = np.nan
        pose = self._pose[:, moved] = columns.take(moved, axis=1)
        left = moved[
            (~(np.abs(pose - self._rest_pose[:, moved]) <= self._rest_limits[:, moved])).any(axis=0)
        ]
        self._rest_pose[:, left] = columns[:, left]
        self._version[moved] += 1
        self._low[:, moved], self._high[:, moved] = self._world_bounds(moved, pose)
        self._history.advance(time, columns, left)
        self._history.disturb(lost)
        names = [self.bodies[k].name for k in lost.tolist()]
        warnings = tuple(
            Message.of(Cause.TRANSFORM_NOT_FINITE, name, object=name) for name in names
        )
        return np.union1d(moved, gone), warnings

    def _world_bounds(self, bodies: IntArray, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corners (3, k) of bounding boxes of ``bodies`` (k,) in ``pose`` (12,
        k), grown so that they overlap wherever two bodies can touch."""
        turn = pose[:9].reshape(3, 3, -1)
        centre = turned(turn, self._middle.take(bodies, axis=1)) + pose[9:]
        grow = (self.settings.tolerance + self.settings.slack) / 2 + 2 * STILL
        half = turned(np.abs(turn), self._extent.take(bodies, axis=1)) + grow
        return centre - half, centre + half

    def _unchanged(self, warnings: tuple[Message, ...]) -> FrameContacts:
        assert self._last is not None
        none = np.zeros((0, 2), dtype=np.int64)
        statistics = ContactStatistics(len(self._pairs.key), 0, perf_counter() - self._update_began)
        return FrameContacts(self._last.contacts, none, none, (), statistics, warnings)

    def _energies(self, speed: FloatArray) -> FloatArray:
        """Upper bound on the energy (n,) that bodies with at most this ``speed`` (n,) bring into an
        impact."""
        mass = self._mass
        if self.settings.energy is ImpactEnergy.NORMAL:
            # Twice the speed of the faster of two at most, and no more than the mass of a dynamic
            # one of them.
            mass = 4 * np.where(self._dynamic, mass, np.max(mass, where=self._dynamic, initial=0.0))
        return mass / 2 * (speed / self.settings.time_scale) ** 2

    def _may_strike(self) -> BoolArray:
        """Which bodies (n,) may take part in an impact within the next `_FRAMES_AHEAD` frames: all
        that move and have a mass, as soon as one of them may have the energy for it."""
        gain = (
            float(np.linalg.norm(self.settings.gravity))
            * self.settings.time_scale**2
            * self._history.step
            * _FRAMES_AHEAD
        )
        energy = self._energies(self._history.speeds() + gain)
        moving = self._history.moving()
        return moving & (self._mass > 0) & np.any(moving & (energy >= self._least / 2))

    def _in_heaps_of(self, bodies: BoolArray) -> BoolArray:
        """Which bodies (n,) are in the same heap as one of the ``bodies`` (n,): chains of near
        pairs join them."""
        reached = np.zeros(len(bodies), dtype=np.bool_)
        reached[self._heap[bodies]] = True
        return reached[self._heap]

    def _examine_last_frame(self, rows: IntArray) -> bool:
        """Find out which pairs ``rows``, which were not examined in the last frame, touched in its
        poses. Returns whether any did."""
        if len(rows) == 0:
            return False
        pairs = self._pairs
        larger = pairs.larger[rows]
        smaller = pairs.smaller[rows]
        poses = self._history.last_poses
        self._queries += len(rows)
        relative = relative_pose(poses.take(larger, axis=1), poses.take(smaller, axis=1))
        distance = self._narrow.clearances(np.stack([larger, smaller], axis=1), *relative)
        touching = distance <= self.settings.tolerance
        pairs.examined[rows], pairs.known[rows] = True, False
        pairs.touching[rows] = pairs.struck[rows] = touching
        pairs.values[_DISTANCE, rows] = distance
        self._airborne[larger[touching]] = self._airborne[smaller[touching]] = False
        return bool(touching.any())

    def _near_pairs(self, moved: IntArray, impacts: bool) -> tuple[Paths | None, IntArray]:
        """Update the near pairs. Returns the paths of the bodies, None if none is fast enough for
        an impact, and the numbers, within the near pairs, of those with the energy for one."""
        low, high = self._low, self._high
        paths = None
        none = np.zeros(0, dtype=np.int64)
        gravity = np.array(self.settings.gravity) * self.settings.time_scale**2
        least = self._least
        turning = self.settings.energy is ImpactEnergy.NORMAL
        if impacts and (
            turning or np.any(self._energies(self._history.speed_bound(gravity)) >= least / 2)
        ):
            paths = self._history.paths(~self._dynamic, self._airborne, gravity)
        if paths is not None:
            speed = paths.fastest()
            if turning:
                speed += np.sqrt(dot(paths.spin, paths.spin)) * self._reach
            energy = self._energies(speed)
            fast = (energy >= least / 2).nonzero()[0]
            if len(fast) == 0:
                paths = None
        if paths is not None:
            low = low.copy()
            high = high.copy()
            before_low = self._last_bounds[0][:, fast]
            before_high = self._last_bounds[1][:, fast]
            ahead_low, ahead_high = self._world_bounds(fast, paths.poses(fast, paths.duration))
            low[:, fast] = np.minimum(np.minimum(low[:, fast], before_low), ahead_low)
            high[:, fast] = np.maximum(np.maximum(high[:, fast], before_high), ahead_high)
        self._widen(low, high, moved)
        if paths is None:
            return None, none
        rapid = np.zeros(len(self.bodies), dtype=np.bool_)
        rapid[fast] = True
        a, b = self._near_larger, self._near_smaller
        # To enter a medium is not to hit it.
        solid = ~(self._medium[a] | self._medium[b])
        return paths, (solid & (rapid[a] | rapid[b]) & (energy[a] + energy[b] >= least)).nonzero()[
            0
        ]

    def _widen(self, low: FloatArray, high: FloatArray, moved: IntArray) -> None:
        """Move the wide bounds of those ``moved`` bodies that they do not contain any more, by
        bounds from ``low`` to ``high`` (3, n), and find the near pairs again."""
        inside = (low[:, moved] >= self._wide_low[:, moved]) & (
            high[:, moved] <= self._wide_high[:, moved]
        )
        rows = moved[~inside.all(axis=0)]
        if len(rows) == 0:
            return
        drift = self._history.drift(rows)
        self._wide_low[:, rows] = low[:, rows] - _WIDENING + 2 * np.minimum(drift, 0.0)
        self._wide_high[:, rows] = high[:, rows] + _WIDENING + 2 * np.maximum(drift, 0.0)
        escaped = np.zeros(len(self.bodies), dtype=np.bool_)
        escaped[rows] = True
        found = overlapping_pairs(np.stack([self._wide_low.T, self._wide_high.T], axis=1), escaped)
        near = found[:, 0] * len(self.bodies) + found[:, 1]
        if len(rows) < len(self.bodies):
            near = np.sort(
                np.concatenate(
                    [self._near[~(escaped[self._near_larger] | escaped[self._near_smaller])], near]
                )
            )
        if not np.array_equal(near, self._near):
            self._near = near
            self._heap = connected(self._numbers(near), len(self.bodies))
            self._near_larger, self._near_smaller = self._by_size(near)

    def _contacts(
        self,
        endpoints: Endpoints | None,
        paths: Paths | None,
        striking: BoolArray,
        able: IntArray,
        warnings: tuple[Message, ...],
    ) -> FrameContacts:
        """The contacts of this frame, and what has changed.

        Args:
            endpoints: as in `update`.
            paths: of the bodies, None where nothing can hit.
            striking: which bodies may soon take part in an impact (n,), see `_may_strike`.
            able: numbers of the near pairs with the energy for an impact.
            warnings: about bodies that were left out.
        """
        old = self._pairs
        touched = old.key[old.touching & old.examined]
        struck = old.key[old.struck]
        met = self._overlapping()
        key = self._near[met]
        pairs = self._pairs = old.carried_to(key, self._near_larger[met], self._near_smaller[met])
        broad = perf_counter() - self._update_began
        fresh = (
            pairs.known
            & (pairs.version[0] == self._version[pairs.larger])
            & (pairs.version[1] == self._version[pairs.smaller])
        )
        requested = self._requested(endpoints, striking, able)
        examined = requested | fresh
        if endpoints is not None:
            examined |= striking[pairs.larger] | striking[pairs.smaller]
        if len(able):
            striking = np.zeros(len(met), dtype=np.bool_)
            striking[able] = True
            examined |= striking[met]
        self._examine_last_frame((examined & ~pairs.examined).nonzero()[0])
        before = pairs.touching & pairs.examined
        apart = ~pairs.touching & pairs.examined
        distance = pairs.values[_DISTANCE].copy()
        last = pairs.values.copy() if len(able) else pairs.values  # else not asked for
        queried = examined & ~fresh
        free = able[~_among(self._near[able], struck)]
        hits = self._examine(
            queried.nonzero()[0], before, None if paths is None else self._meetings(paths, free)
        )
        if paths is not None and len(able):
            hits = self._hits_of_frame(paths, hits, able, free, before, queried, last)
        impacts = self._impacts(hits, paths, struck)
        warnings += self._uncertain(impacts)
        pairs.touching &= examined
        pairs.examined = examined
        new = self._new[pairs.larger] | self._new[pairs.smaller]
        self._settle(before, distance, impacts, new)
        if paths is not None:
            self._disturb(hits, paths)
        reported = pairs.touching & requested & (pairs.values[_DISTANCE] <= self.settings.tolerance)
        began = key[reported & apart & ~new]
        lost = touched[~_among(touched, key[pairs.touching | ~examined])]
        return FrameContacts(
            contacts=self._reported_contacts(reported.nonzero()[0]),
            began=self._numbers(began),
            ended=self._numbers(lost),
            impacts=impacts,
            statistics=ContactStatistics(len(key), self._queries, broad),
            warnings=warnings,
        )

    def _overlapping(self) -> BoolArray:
        """Which near pairs have overlapping bounds."""
        low, high, larger, smaller = self._low, self._high, self._near_larger, self._near_smaller
        met: BoolArray = np.all(low.take(larger, axis=1) <= high.take(smaller, axis=1), axis=0)
        met &= np.all(low.take(smaller, axis=1) <= high.take(larger, axis=1), axis=0)
        return met

    def _hits_of_frame(
        self,
        paths: Paths,
        met: Hits,
        able: IntArray,
        free: IntArray,
        before: BoolArray,
        queried: BoolArray,
        last: FloatArray,
    ) -> Hits:
        """The hits of this frame.

        Args:
            paths: of the bodies.
            met: hits of pairs that meet on their paths.
            able: numbers of the near pairs with the energy for an impact.
            free: those of them that have parted since their last one.
            before: which pairs touched in the last frame (p,).
            queried: which pairs were queried in this frame (p,).
            last: the values of all pairs in the last frame.
        """
        pairs = self._pairs
        time = self._history.times[-1]
        key = pairs.key
        now = pairs.touching & queried
        pivoting = (before & now & _among(key, self._near[able])).nonzero()[0]
        arrived = key[now & ~before & (pairs.values[_DISTANCE] <= _PRESSING_DISTANCE)]
        hits = self._hits(paths, met, arrived[_among(arrived, self._near[free])])
        self._last_impact = {
            k: hit
            for k, hit in self._last_impact.items()
            if time - hit[0] <= self._refractory + max(paths.duration, _TIPPING)
        }
        recent = np.array(sorted(self._last_impact), dtype=np.int64)
        return hits.joined(self._landings(paths, pivoting[_among(key[pivoting], recent)], last))

    def _settle(
        self, before: BoolArray, distance: FloatArray, impacts: Sequence[Impact], new: BoolArray
    ) -> None:
        """Update which pairs make no further impact until they part, and which bodies are in free
        flight.

        Args:
            before: whether each pair touched in the last frame (p,).
            distance: of the pairs in the last frame (p,) [m].
            impacts: of this frame.
            new: whether one of the bodies was not in the last frame (p,).
        """
        pairs = self._pairs
        settled = before & (distance - pairs.values[_DISTANCE] <= _CREEP * self._history.step)
        if len(impacts):
            settled |= _among(
                pairs.key,
                np.sort(
                    [a * len(self.bodies) + b for a, b in (impact.objects for impact in impacts)]
                ),
            )
        pairs.struck = pairs.touching & (pairs.struck | settled | new)
        self._airborne = self._dynamic.copy()
        self._airborne[pairs.larger[pairs.struck]] = False
        self._airborne[pairs.smaller[pairs.struck]] = False

    def _reported_contacts(self, rows: IntArray) -> ContactSet:
        """Contacts of the pairs ``rows``; those of the last frame where nothing has changed."""
        # Whether a pair has parted depends on the past, by the slack; its contact only on the
        # poses.
        pairs = self._pairs
        state = np.stack(
            [pairs.key[rows], self._version[pairs.larger[rows]], self._version[pairs.smaller[rows]]]
        )
        computed = self._no_motion == 0 and self._queries > 0
        if self._last is not None and not computed and np.array_equal(state, self._reported):
            return self._last.contacts
        self._reported = state
        return self._contact_set(rows)

    def _requested(
        self, endpoints: Endpoints | None, striking: BoolArray, able: IntArray
    ) -> BoolArray:
        """Which candidate pairs (p,) the caller wants: those in heaps that hold both a listener and
        a source, or a body that may strike."""
        pairs = self._pairs
        if endpoints is None:
            return np.ones(len(pairs.key), dtype=np.bool_)
        sounding = endpoints.sounding | striking
        sounding[self._near_larger[able]] = sounding[self._near_smaller[able]] = True
        wanted = (self._in_heaps_of(endpoints.heard) & self._in_heaps_of(sounding))[pairs.larger]
        if endpoints.paths:
            silent = ~(endpoints.heard | sounding)
            for _ in range(_DEAD_ENDS):
                bodies = np.concatenate([pairs.larger[wanted], pairs.smaller[wanted]])
                tip = silent & (np.bincount(bodies, minlength=len(silent)) == 1)
                dead = wanted & (tip[pairs.larger] | tip[pairs.smaller])
                if not dead.any():
                    break
                wanted &= ~dead
        return wanted

    def _examine(self, rows: IntArray, before: BoolArray, meetings: Meetings | None = None) -> Hits:
        """Bring the values of the pairs ``rows`` up to date, by a query for those whose bodies have
        moved relative to each other. Returns the hits at ``meetings``, whose patches are part of
        the same query because one large query costs less than two. ``before`` (p,): whether each
        pair touched in the last frame."""
        if len(rows) == 0:
            return self._time_of_impact.hits_at(meetings)
        pairs = self._pairs
        larger = pairs.larger[rows]
        smaller = pairs.smaller[rows]
        pairs.version[0, rows] = self._version[larger]
        pairs.version[1, rows] = self._version[smaller]
        limit: FloatArray = np.where(
            before[rows], self.settings.tolerance + self.settings.slack, self.settings.tolerance
        )
        turn, offset = relative_pose(
            self._pose.take(larger, axis=1), self._pose.take(smaller, axis=1)
        )
        place = turned(turn, self._middle.take(smaller, axis=1)) + offset
        current = self._up_to_date(rows, turn, place, self._radius[smaller], limit, before[rows])
        if current.any():
            queried = (~current).nonzero()[0]
            rows = rows[queried]
            larger = larger[queried]
            smaller = smaller[queried]
            limit = limit[queried]
            turn = turn.take(queried, axis=2)
            offset = offset.take(queried, axis=1)
            place = place.take(queried, axis=1)
        placing = np.stack([larger, smaller], axis=1), turn, offset, limit
        if meetings is None:
            found = self._patches(*placing)
            hits = self._time_of_impact.hits_at(meetings)
        else:
            several = zip(placing, meetings.placing, (0, 2, 1, 0), strict=True)
            both = self._patches(
                *(np.concatenate([mine, theirs], axis=axis) for mine, theirs, axis in several)
            )
            found = both.part(slice(len(rows)))
            hits = meetings.hits(both.part(slice(len(rows), None)))
        values = np.empty((_ROWS, len(rows)))
        values[_PLACE] = place
        values[_TURN] = turn.reshape(9, -1)
        values[_NORMAL] = found.normal
        values[_DISTANCE], values[_AREA] = found.distance, found.area
        gap = found.normal * (found.distance / 2)
        values[_ON_LARGER] = found.centre - gap
        values[_ON_SMALLER] = turned_back(turn, found.centre + gap - offset)
        pairs.values[:, rows] = values
        pairs.known[rows] = True
        pairs.touching[rows] = found.distance <= limit
        self._queries += len(rows)
        return hits

    def _up_to_date(
        self,
        rows: IntArray,
        turn: FloatArray,
        place: FloatArray,
        radius: FloatArray,
        limit: FloatArray,
        before: BoolArray,
    ) -> BoolArray:
        """Which pairs need no query: touching and not moved relative to each other, or too far
        apart to touch after their motion since the last query.

        Args:
            rows: numbers of the pairs (k,).
            turn: rotations of the smaller bodies in the frames of the larger ones (3, 3, k).
            place: middles of their bounds there (3, k).
            radius: of these bounds (k,).
            limit: distance up to which a pair touches (k,).
            before: whether it touched in the last frame (k,).
        """
        pairs = self._pairs
        motion = self._motion(rows, turn, place, radius)
        apart = pairs.values[_DISTANCE, rows] - motion > limit
        return np.asarray(
            pairs.known[rows]
            & np.where(before, motion <= self._no_motion, apart)
            & (pairs.touching[rows] == before)
        )

    def _motion(
        self, rows: IntArray, turn: FloatArray, place: FloatArray, radius: FloatArray
    ) -> FloatArray:
        """How far any point of the smaller bodies of the pairs ``rows`` (k,), within ``radius``
        (k,) of the middles of their bounds, has moved since these pairs were queried: (k,)."""
        values = self._pairs.values[: _ON_LARGER.start].take(rows, axis=1)
        travel = place - values[_PLACE]
        change = turn - values[_TURN].reshape(3, 3, -1)
        return np.sqrt(dot(travel, travel)) + radius * np.sqrt(added(dot(change, change)) / 2)

    def _patches(
        self, numbers: IntArray, turn: FloatArray, offset: FloatArray, limit: FloatArray
    ) -> PairPatches:
        """Patches of pairs ``numbers`` (p, 2) by the narrow phase. A medium and a body in it touch
        at the centre of the intersection of their bounds, without area or depth."""
        medium = self._medium[numbers[:, 0]] | self._medium[numbers[:, 1]]
        if not medium.any():
            return self._narrow.query(numbers, turn, offset, limit)
        inside = medium.nonzero()[0]
        others = (~medium).nonzero()[0]
        found = self._narrow.query(
            numbers[others], turn[..., others], offset[:, others], limit[others]
        )
        distance = self._narrow.gaps(numbers[inside], turn[..., inside], offset[:, inside])
        a, b = numbers[inside].T
        middle = (
            np.maximum(self._low[:, a], self._low[:, b])
            + np.minimum(self._high[:, a], self._high[:, b])
        ) / 2
        pose = self._pose[:, a]
        centre = turned_back(pose[:9].reshape(3, 3, -1), middle - pose[9:])
        normal = upwards(len(inside))
        wet = PairPatches(distance, normal, centre, np.zeros(len(inside)))
        return PairPatches.joined(len(medium), (others, found), (inside, wet))

    def _contact_set(self, rows: IntArray) -> ContactSet:
        """Contacts of pairs ``rows``, each at the centre of its patch."""
        pairs = self._pairs
        larger = pairs.larger[rows]
        smaller = pairs.smaller[rows]
        key = pairs.key[rows]
        values = pairs.values.take(rows, axis=1)
        pose_l = self._pose.take(larger, axis=1)
        pose_s = self._pose.take(smaller, axis=1)
        turn = pose_l[:9].reshape(3, 3, -1)
        normal = turned(turn, values[_NORMAL])
        ends = np.stack([_placed(pose_l, values[_ON_LARGER]), _placed(pose_s, values[_ON_SMALLER])])
        count = max(len(self.bodies), 1)
        flipped = larger != key // count
        normal *= np.where(flipped, -1.0, 1.0)
        first, second = np.where(flipped, ends[::-1], ends)
        distance = values[_DISTANCE]
        return ContactSet(
            pairs=self._numbers(key),
            positions=np.stack([first.T, second.T], axis=1),
            normal=np.ascontiguousarray(normal.T),
            depth=np.maximum(-distance, 0.0),
            distance=distance,
            area=values[_AREA],
            weight=self._weights(larger, smaller, values),
            transmission=np.zeros(len(key), dtype=np.int64),
        )

    def _weights(self, larger: IntArray, smaller: IntArray, values: FloatArray) -> FloatArray:
        """Weights of contacts (k,) with ``values`` (rows, k): 1 up to the gap of bodies at rest,
        falling smoothly to 0 at the tolerance.

        Boxes that do not touch are also weighted by the patch's area relative to the face of the
        smaller one: their nearest edges do not face each other as round bodies do.
        """
        distance = values[_DISTANCE]
        turn = values[_TURN].reshape(3, 3, -1)
        rest = _RESTING * self.settings.tolerance
        near = 1.0 - smooth_step((distance - rest) / max(self.settings.tolerance - rest, 1e-300))
        if not np.any(near < 1):
            return near
        touch = 1.0 - smooth_step((distance - rest) / max(rest, 1e-300))
        ways = values[_NORMAL], turned_back(turn, values[_NORMAL])
        faces = []
        for bodies, way in zip((larger, smaller), ways, strict=True):
            x, y, z = self._extent.take(bodies, axis=1)
            faces.append(4 * dot(np.abs(way), np.stack([y * z, z * x, x * y])))
        area = values[_AREA]
        facing = area / np.maximum(area + _FACING * np.minimum(*faces), 1e-300)
        facing = np.where(self._narrow.is_box[larger] & self._narrow.is_box[smaller], facing, 1.0)
        return near * (touch + (1.0 - touch) * (_EDGE_WEIGHT + (1.0 - _EDGE_WEIGHT) * facing))

    def _meetings(self, paths: Paths, able: IntArray) -> Meetings | None:
        """Where and when those near pairs ``able``, by number, that meet on their ``paths`` do
        so."""
        possible = self._time_of_impact.may_hit(
            paths, self._near_larger[able], self._near_smaller[able], *self._last_bounds
        )
        able = able[possible]
        meshes = (
            self._narrow.is_mesh[self._near_larger[able]]
            | self._narrow.is_mesh[self._near_smaller[able]]
        ).nonzero()[0]
        if len(meshes):  # their distances take long: use those of the last query
            able = np.delete(able, meshes[self._out_of_reach(paths, self._near[able[meshes]])])
        return self._time_of_impact.meetings(paths, self._numbers(self._near[able]))

    def _out_of_reach(self, paths: Paths, key: IntArray) -> BoolArray:
        """Which near pairs, by key, can't meet on their ``paths``: their distance at the last
        query, less their motion since, exceeds what the paths can close."""
        pairs = self._pairs
        if len(pairs.key) == 0:
            return np.zeros(len(key), dtype=np.bool_)
        rows = np.searchsorted(pairs.key, key).clip(max=len(pairs.key) - 1)
        larger = pairs.larger[rows]
        smaller = pairs.smaller[rows]
        turn, offset = relative_pose(paths.start[:, larger], paths.start[:, smaller])
        place = turned(turn, self._middle[:, smaller]) + offset
        least = pairs.values[_DISTANCE, rows] - self._motion(
            rows, turn, place, self._radius[smaller]
        )
        return np.asarray(
            (pairs.key[rows] == key)
            & pairs.known[rows]
            & (least > self._time_of_impact.largest_approach(paths, larger, smaller))
        )

    def _hits(self, paths: Paths, hits: Hits, arrived: IntArray) -> Hits:
        """The confirmed ones among ``hits``, and those of pairs, by key, that have ``arrived`` at
        each other by the end of the interval although their motion did not lead there. Something
        else has moved these, so their hits are found on paths that lead to their actual poses."""
        if len(hits):
            hits = hits.chosen(confirmed(hits, paths, self.settings.tolerance))
        if len(arrived):
            arrived = arrived[~_among(arrived, np.sort(hits.pairs @ (len(self.bodies), 1)))]
        if len(arrived):
            pairs = self._numbers(arrived)
            expected = self._time_of_impact.final_distances(paths, pairs)
            pulled = pairs[expected > 2 * _PRESSING_DISTANCE]
            if len(pulled):
                meetings = self._time_of_impact.meetings(paths.through_ends(), pulled)
                hits = hits.joined(self._time_of_impact.hits_at(meetings).approaching())
        return hits

    def _landings(self, paths: Paths, rows: IntArray, last: FloatArray) -> Hits:
        """Hits of the pairs ``rows``, which touch in both frames, by a part that was away from the
        other body before; of each pair, the hit of the patch's fastest point. ``last``: the values
        of all pairs in the last frame. Only for pairs with a recent impact: bodies that have
        touched for longer are at rest."""
        pairs = self._pairs
        rows = rows[~(self._medium[pairs.larger[rows]] | self._medium[pairs.smaller[rows]])]
        if len(rows) == 0:
            return Hits.none()
        larger = pairs.larger[rows]
        smaller = pairs.smaller[rows]
        pose = self._pose.take(larger, axis=1)
        other = self._pose.take(smaller, axis=1)
        limit = np.full(len(rows), self.settings.tolerance + self.settings.slack)
        normal = pairs.values[_NORMAL, rows]
        distance = pairs.values[_DISTANCE, rows]
        centre = pairs.values[_ON_LARGER, rows] + normal * (distance / 2)
        of, points = self._narrow.corners(
            np.stack([larger, smaller], axis=1), *relative_pose(pose, other), limit, normal, centre
        )
        turn = pose[:9].reshape(3, 3, -1)[..., of]
        points = turned(turn, points) + pose[9:, of]
        keys = pairs.key[rows]
        flipped = larger != keys // len(self.bodies)
        normal = turned(turn, normal[:, of]) * np.where(flipped[of], -1.0, 1.0)
        gap = normal * (distance[of] / 2)
        nodes = np.stack([points - gap, points + gap])
        was, old = self._corners_before(paths, rows, last, limit)
        old = np.where(flipped[was], old[::-1], old)
        squared = ((nodes[..., None] - old[:, :, None]) ** 2).sum(axis=1)
        away = np.sqrt(
            np.where(of[:, None] == was, squared, np.inf).min(axis=(0, 2), initial=np.inf)
        )
        hits = landings(
            paths,
            self._numbers(keys[of]),
            nodes,
            away,
            normal,
            distance[of],
            _PRESSING_DISTANCE,
        )
        order = hits.approach.argsort(kind="stable")[::-1]
        fastest = np.unique(hits.pairs[order] @ (len(self.bodies), 1), return_index=True)[1]
        return hits.chosen(order[fastest])

    def _corners_before(
        self, paths: Paths, rows: IntArray, last: FloatArray, limit: FloatArray
    ) -> tuple[IntArray, FloatArray]:
        """Of each corner of the patches that the pairs ``rows`` had in the last frame, with the
        values ``last``: the number (k,) of the pair, and where the material of the larger and of
        the smaller body there (2, 3, k) is now."""
        larger = self._pairs.larger[rows]
        smaller = self._pairs.smaller[rows]
        turn, offset = relative_pose(paths.start[:, larger], paths.start[:, smaller])
        normal = last[_NORMAL, rows]
        gap = normal * (last[_DISTANCE, rows] / 2)
        pairs = np.stack([larger, smaller], axis=1)
        centre = last[_ON_LARGER, rows] + gap
        of, places = self._narrow.corners(pairs, turn, offset, limit, normal, centre)
        on_smaller = turned_back(turn[..., of], places + gap[:, of] - offset[:, of])
        return of, np.stack(
            [
                _placed(self._pose[:, larger[of]], places - gap[:, of]),
                _placed(self._pose[:, smaller[of]], on_smaller),
            ]
        )

    def _impacts(self, hits: Hits, paths: Paths | None, struck: IntArray) -> tuple[Impact, ...]:
        """The impacts that hits with enough energy make, by time. ``struck``: pairs, by key, that
        have not parted since their last impact. These, and any pair within its refractory time,
        make another one only by a clearly stronger hit."""
        if paths is None or len(hits) == 0:
            return ()
        energies = (
            impact_energies(hits, self._mass, ~self._dynamic, self.settings.energy)
            / self.settings.time_scale**2
        )
        impacts = []
        still = _among(hits.pairs @ (len(self.bodies), 1), struck)
        for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.time)).tolist():
            a, b = hits.pairs[k].tolist()
            key = a * len(self.bodies) + b
            when = self._history.times[-1] - paths.duration + float(hits.time[k])
            last, speed = self._last_impact.get(key, (-np.inf, 0.0))
            limits = self.settings.impact_limits(self.bodies[a].named, self.bodies[b].named)
            again = still[k] or when - last < limits.refractory
            resting = again and hits.approach[k] < _STRONGER * speed
            if energies[k] < limits.least_energy or resting:
                continue
            self._last_impact[key] = when, float(hits.approach[k])
            impacts.append(hits.impact(k, when, float(energies[k]), limits.full_energy))
        return tuple(impacts)

    def _uncertain(self, impacts: Sequence[Impact]) -> tuple[Message, ...]:
        """A warning for each impact whose time the search did not find within its steps."""
        unsure = [i.objects for i in impacts if i.objects in self._time_of_impact.unsure]
        self._time_of_impact.unsure.clear()
        names = [(self.bodies[a].name, self.bodies[b].name) for a, b in unsure]
        return tuple(
            Message.of(Cause.IMPACT_TIME, second, first=first, second=second)
            for first, second in names
        )

    def _disturb(self, hits: Hits, paths: Paths) -> None:
        """Mark the bodies whose motion up to now does not predict what follows: those that hit
        something, and dynamic ones that are not where their paths led."""
        self._history.disturb(self._history.deviated(paths) & self._dynamic)
        self._history.hit(hits.pairs, hits.time)


def _placed(pose: FloatArray, points: FloatArray) -> FloatArray:
    """World positions (3, k) of points (3, k) of bodies in ``pose`` (12, k)."""
    return turned(pose[:9].reshape(3, 3, -1), points) + pose[9:]


def _among(keys: IntArray, ordered: IntArray) -> BoolArray:
    """Which ``keys`` (k,) are contained in ``ordered``, which ascend."""
    if len(ordered) == 0:
        return np.zeros(len(keys), dtype=np.bool_)
    if np.array_equal(keys, ordered):
        return np.ones(len(keys), dtype=np.bool_)
    return np.asarray(ordered.take(np.searchsorted(ordered, keys), mode="clip") == keys)


def _same_request(a: Endpoints | None, b: Endpoints | None) -> bool:
    """Whether two updates want the same contacts."""
    if a is None or b is None:
        return a is b
    return np.array_equal(a.heard, b.heard) and np.array_equal(a.sounding, b.sounding)
