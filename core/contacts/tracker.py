"""Contacts from frame to frame: begin, end and impacts, with work done only where something moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from .broad_phase import overlapping_pairs
from .closed_forms import turned, turned_back
from .contact_set import ContactSet
from .impacts import Hits, Impact, Meetings, impact_energies, took_place
from .motion import MotionHistory, Paths
from .narrow_phase import NarrowPhase
from .reach import Reach
from .settings import Body, ContactSettings, ImpactEnergy, Motion
from .shapes import transformed_bounds

__all__ = ["Body", "ContactSettings", "ContactStatistics", "ContactTracker", "FrameContacts", "Impact", "ImpactEnergy", "Motion", "Reach"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

STILL = 1e-5
"""Metres by which no point of a body has moved if it counts as not having moved: simulations at rest tremble, and poses are float32."""

_CREEP = 0.05
"""Metres per second of approach up to which touching bodies have nothing left to hit."""

_FAT = 0.05
"""Metres by which the bounds of the broad phase are wider than they need be, so that they hold for some frames."""


@dataclass(frozen=True, slots=True)
class ContactStatistics:
    """Of one update: ``candidates`` pairs with overlapping bounds, narrow-phase ``queries`` made and ``avoided``."""

    candidates: int = 0
    queries: int = 0
    avoided: int = 0


@dataclass(frozen=True, slots=True)
class FrameContacts:
    """One frame: all ``contacts`` (pairs by number of the body, sorted), the pairs (k, 2) that ``began`` and ``ended``, ``impacts`` by
    time, and ``warnings`` that name the object they are about. Where nothing has changed, ``contacts`` is the same object as in the last
    frame."""

    contacts: ContactSet
    began: IntArray
    ended: IntArray
    impacts: tuple[Impact, ...]
    statistics: ContactStatistics
    warnings: tuple[str, ...]


@dataclass(slots=True)
class _Pairs:
    """Candidate pairs (p,) and what is known of them, sorted by ``key`` = first * n + second.

    ``known``: has been queried, at ``version`` (p, 2) of the poses of both. ``distance``: then, signed or a lower bound. ``touching``;
    ``struck``: nothing more is to be hit until they part; ``looked``: all that is as of the last frame. Of the query: the pose of the
    mover, the smaller body, relative to the other, ``offset`` (p, 3) of the middle of its bounds and ``turn`` (p, 3, 3), and the patch in
    the frame of the other: ``centre`` (p, 3), ``normal`` (p, 3, from first to second), ``area`` (p,), ``corners`` (p,).
    """

    key: IntArray
    known: BoolArray
    version: IntArray
    distance: FloatArray
    touching: BoolArray
    struck: BoolArray
    looked: BoolArray
    offset: FloatArray
    turn: FloatArray
    centre: FloatArray
    normal: FloatArray
    area: FloatArray
    corners: NDArray[np.object_]

    @classmethod
    def of(cls, key: IntArray) -> _Pairs:
        """Pairs of which nothing is known."""
        n = len(key)
        no = np.zeros(n, dtype=np.bool_)
        vectors = np.zeros((n, 3))
        return cls(
            key=key,
            known=no,
            version=np.full((n, 2), -1),
            distance=np.full(n, np.inf),
            touching=no.copy(),
            struck=no.copy(),
            looked=np.ones(n, dtype=np.bool_),
            offset=vectors,
            turn=np.zeros((n, 3, 3)),
            centre=vectors.copy(),
            normal=vectors.copy(),
            area=np.zeros(n),
            corners=np.empty(n, dtype=np.object_),
        )

    def carried_to(self, key: IntArray) -> _Pairs:
        """The pairs ``key``, with what is known of those that were here before."""
        if np.array_equal(key, self.key):
            return self
        pairs = _Pairs.of(key)
        if len(self.key) == 0 or len(key) == 0:
            return pairs
        place = np.minimum(np.searchsorted(self.key, key), len(self.key) - 1)
        same = np.flatnonzero(self.key[place] == key)
        source = place[same]
        for field in fields(self)[1:]:
            getattr(pairs, field.name)[same] = getattr(self, field.name)[source]
        return pairs


class ContactTracker:
    """Follows the contacts of ``bodies`` from frame to frame."""

    def __init__(self, bodies: Sequence[Body], settings: ContactSettings | None = None) -> None:
        self.settings = settings or ContactSettings()
        self._set(tuple(bodies))
        self.reset()

    def _set(self, bodies: tuple[Body, ...]) -> None:
        self.bodies = bodies
        self._local = np.array([b.shape.local_bounds() for b in bodies], dtype=np.float64).reshape(-1, 2, 3)
        self._middle = self._local.mean(axis=1)
        self._radius = np.sqrt((np.ptp(self._local, axis=1) ** 2).sum(axis=1)) / 2
        arm = np.sqrt((np.abs(self._local).max(axis=1) ** 2).sum(axis=1))
        self._still = STILL / np.stack([arm, arm, arm, np.ones(len(bodies))], axis=1).clip(1e-9)
        self._narrow = NarrowPhase([b.shape for b in bodies], [b.medium for b in bodies])
        self._meetings = Meetings(self._narrow, self._local)
        self._mass = np.array([b.mass or 0.0 for b in bodies], dtype=np.float64)
        self._dynamic = np.array([b.motion is Motion.DYNAMIC for b in bodies], dtype=np.bool_)
        self._medium = np.array([b.medium for b in bodies], dtype=np.bool_)

    def reset(self) -> None:
        """Forget the past: the next update begins no contact and makes no impact."""
        count = len(self.bodies)
        self._history = MotionHistory(count)
        self._pose = np.full((count, 4, 4), np.nan)
        self._version = np.zeros(count, dtype=np.int64)
        self._bounds = np.full((count, 2, 3), np.nan)
        self._fat = np.full((count, 2, 3), np.nan)
        self._near = np.zeros(0, dtype=np.int64)
        self._pairs = _Pairs.of(self._near)
        self._airborne = self._dynamic.copy()
        self._last_impact: dict[int, float] = {}
        self._last: FrameContacts | None = None
        self._last_wanted: BoolArray | Reach | None = None

    def replace_bodies(self, bodies: Sequence[Body]) -> None:
        """Other shapes or masses for the same bodies, in the same order (deforming meshes): their motion and contacts go on.

        Raises ValueError where the names differ.
        """
        if [b.name for b in bodies] != [b.name for b in self.bodies]:
            raise ValueError("bodies: they must have the same names as before")
        changed = np.array([a is not b and a != b for a, b in zip(bodies, self.bodies, strict=True)], dtype=np.bool_)
        self._set(tuple(bodies))
        self._pose[changed] = np.nan
        self._fat[changed] = np.nan
        first, second = self._split(self._pairs.key)
        self._pairs.known &= ~(changed[first] | changed[second])

    def update(
        self, time: float, transforms: FloatArray, wanted: BoolArray | Reach | None = None, continuous: bool = True
    ) -> FrameContacts:
        """The contacts at ``time`` [s] under rigid world ``transforms`` (n, 4, 4), scale being in the shapes.

        ``wanted``: only contacts of these bodies (n,), or only those that signals can reach; None: all. Impacts are found in any case. A
        pair that was not looked at counts as apart for the slack. ``continuous`` False says that this is not the step that follows the last
        one: history is forgotten. A body whose transform is not finite is left out, with a warning.
        """
        transforms = np.asarray(transforms, dtype=np.float64)
        if transforms.shape != (len(self.bodies), 4, 4):
            raise ValueError(f"transforms: expected {len(self.bodies)} matrices of 4 x 4, got an array of shape {transforms.shape}")
        if not continuous or (self._history.times and time <= self._history.times[-1]):
            self.reset()
        moved, warnings = self._take(time, transforms)
        if self._last is not None and not moved.any() and _same(wanted, self._last_wanted):
            return self._unchanged(warnings)
        paths, fast = self._ways(time)
        strikers = self._broad_phase(paths, fast)
        result = self._contacts(time, wanted, paths, strikers, warnings)
        self._last, self._last_wanted = result, wanted
        return result

    def _split(self, key: IntArray) -> tuple[IntArray, IntArray]:
        count = max(len(self.bodies), 1)
        return key // count, key % count

    def _take(self, time: float, transforms: FloatArray) -> tuple[BoolArray, tuple[str, ...]]:
        """Take over the poses of bodies that have moved; say which and who is left out. Those that are have NaN for a pose."""
        moved = ~(np.abs(transforms[:, :3] - self._pose[:, :3]).max(axis=1) <= self._still).all(axis=1)
        rows = np.flatnonzero(moved)
        lost = rows[~np.isfinite(transforms[rows]).all(axis=(1, 2))]
        if len(lost):
            transforms = transforms.copy()
            transforms[lost] = np.nan
            moved[lost] = ~np.isnan(self._pose[lost, 0, 0]) | (not self._history.times)
            rows = np.flatnonzero(moved)
        self._pose[rows] = transforms[rows]
        self._version[rows] += 1
        self._bounds[rows] = transformed_bounds(self._local[rows], self._pose[rows])
        self._history.advance(time, transforms, moved)
        return moved, tuple(f"{self.bodies[k].name}: its transform is not finite; it takes no part" for k in lost.tolist())

    def _unchanged(self, warnings: tuple[str, ...]) -> FrameContacts:
        assert self._last is not None
        none = np.zeros((0, 2), dtype=np.int64)
        candidates = len(self._pairs.key)
        return FrameContacts(self._last.contacts, none, none, (), ContactStatistics(candidates, 0, candidates), warnings)

    def _ways(self, time: float) -> tuple[Paths | None, FloatArray]:
        """How bodies moved since the last frame as far as what came before tells, and the most energy (n,) that each could hit with."""
        scale = self.settings.time_scale
        paths = self._history.paths(~self._dynamic, self._airborne, np.array(self.settings.gravity) * scale**2)
        if paths is None:
            return None, np.zeros(len(self.bodies))
        mass = self._mass
        if self.settings.energy is ImpactEnergy.NORMAL:
            # Twice the speed of the faster of two at most, and no more than the mass of a dynamic one of them.
            mass = 4 * np.where(self._dynamic, mass, np.max(mass, where=self._dynamic, initial=0.0))
        return paths, mass / 2 * (paths.fastest() / scale) ** 2

    def _broad_phase(self, paths: Paths | None, energy: FloatArray) -> IntArray:
        """Bring the near pairs up to date; those (k,) of them that could make an impact, by key."""
        grown = self._grown(self._bounds)
        fast = np.flatnonzero(energy >= self.settings.least_energy / 2) if paths is not None else np.zeros(0, dtype=np.int64)
        if paths is not None and len(fast):
            for time in (0.0, paths.duration):
                swept = transformed_bounds(self._local[fast], paths.matrices(fast, time))
                grown[fast, 0] = np.minimum(grown[fast, 0], swept[:, 0])
                grown[fast, 1] = np.maximum(grown[fast, 1], swept[:, 1])
        escaped = ~((grown[:, 0] >= self._fat[:, 0]) & (grown[:, 1] <= self._fat[:, 1])).all(axis=1)
        if escaped.any():
            self._fat[escaped] = grown[escaped] + np.array([[-_FAT], [_FAT]])
            if paths is not None:
                rows = np.flatnonzero(escaped)
                drift = paths.velocities(rows, paths.duration) * paths.duration
                self._fat[rows, 0] += np.minimum(drift, 0.0)
                self._fat[rows, 1] += np.maximum(drift, 0.0)
            first, second = self._split(self._near)
            found = overlapping_pairs(self._fat, escaped)
            kept = self._near[~(escaped[first] | escaped[second])]
            self._near = np.sort(np.concatenate([kept, found[:, 0] * len(self.bodies) + found[:, 1]]))
        if len(fast) == 0:
            return np.zeros(0, dtype=np.int64)
        first, second = self._split(self._near)
        rapid = np.zeros(len(self.bodies), dtype=np.bool_)
        rapid[fast] = True
        return self._near[(rapid[first] | rapid[second]) & (energy[first] + energy[second] >= self.settings.least_energy)]

    def _grown(self, bounds: FloatArray) -> FloatArray:
        """Bounds that overlap wherever two bodies could be touching."""
        grow = (self.settings.tolerance + self.settings.slack) / 2 + 2 * STILL
        return np.asarray(bounds + np.array([[-grow], [grow]]))

    def _contacts(
        self, time: float, wanted: BoolArray | Reach | None, paths: Paths | None, strikers: IntArray, warnings: tuple[str, ...]
    ) -> FrameContacts:
        first_frame = self._last is None
        grown = self._grown(self._bounds)
        first, second = self._split(self._near)
        old = self._pairs
        key = self._near[((grown[first, 0] <= grown[second, 1]) & (grown[first, 1] >= grown[second, 0])).all(axis=1)]
        old_touching = old.key[old.touching & old.looked]
        old_struck = old.key[old.struck]
        pairs = self._pairs = old.carried_to(key)
        first, second = self._split(key)
        fresh = pairs.known & (pairs.version[:, 0] == self._version[first]) & (pairs.version[:, 1] == self._version[second])
        asked = self._asked(wanted, first, second, grown, fresh)
        looked = asked | fresh | np.isin(key, strikers)
        before = pairs.touching & pairs.looked
        apart_before = ~pairs.touching & pairs.looked
        distance_before = pairs.distance.copy()
        queries = self._look(np.flatnonzero(looked & ~fresh), before)
        pairs.touching &= looked
        pairs.looked = looked
        hits = self._hits(paths, strikers[~np.isin(strikers, old_struck)])
        impacts = self._impacts(time, hits, paths)
        settled = before.copy()
        if not first_frame:
            creep = _CREEP * (time - self._history.times[-2])
            settled[before] = distance_before[before] - pairs.distance[before] <= creep
        pairs.struck &= pairs.touching
        pairs.struck |= pairs.touching & (settled | first_frame | np.isin(key, self._keys(impacts)))
        self._disturb(hits, paths)
        self._airborne = self._dynamic.copy()
        self._airborne[first[pairs.struck]] = False
        self._airborne[second[pairs.struck]] = False
        reported = pairs.touching & asked
        began = key[reported & apart_before] if not first_frame else key[:0]
        now_unknown = key[~looked]
        ended = old_touching[~np.isin(old_touching, key[pairs.touching]) & ~np.isin(old_touching, now_unknown)]
        return FrameContacts(
            contacts=self._contact_set(np.flatnonzero(reported)),
            began=np.stack(self._split(began), axis=1),
            ended=np.stack(self._split(ended), axis=1),
            impacts=impacts,
            statistics=ContactStatistics(len(key), queries, len(key) - queries),
            warnings=warnings,
        )

    def _asked(self, wanted: BoolArray | Reach | None, first: IntArray, second: IntArray, grown: FloatArray, fresh: BoolArray) -> BoolArray:
        """Which candidate pairs the caller wants to know of."""
        if wanted is None:
            return np.ones(len(first), dtype=np.bool_)
        if not isinstance(wanted, Reach):
            return np.asarray(wanted[first] | wanted[second])
        asked = np.zeros(len(first), dtype=np.bool_)
        possible = np.flatnonzero(~fresh | self._pairs.touching)
        a, b = first[possible], second[possible]
        regions = np.stack([np.maximum(grown[a, 0], grown[b, 0]), np.minimum(grown[a, 1], grown[b, 1])], axis=1)
        asked[possible] = wanted.wanted(np.stack([a, b], axis=1), regions)
        return asked

    def _look(self, rows: IntArray, before: BoolArray) -> int:
        """Bring pairs ``rows`` up to date, by a query where they have moved relative to each other; how many were made."""
        pairs = self._pairs
        first, second = self._split(pairs.key[rows])
        pairs.version[rows] = np.stack([self._version[first], self._version[second]], axis=1)
        limit: FloatArray = np.where(before[rows], self.settings.tolerance + self.settings.slack, self.settings.tolerance)
        frame, mover = self._frames(rows)
        turn, offset = self._relative(frame, mover)
        travel = offset - pairs.offset[rows]
        change = turn - pairs.turn[rows]
        motion = np.sqrt((travel**2).sum(axis=1)) + self._radius[mover] * np.sqrt((change**2).sum(axis=(1, 2)) / 2)
        stays = pairs.known[rows] & np.where(pairs.touching[rows], motion <= STILL, pairs.distance[rows] - motion > limit)
        stays &= pairs.touching[rows] == before[rows]
        asked = np.flatnonzero(~stays)
        rows, first, second, frame, mover = rows[asked], first[asked], second[asked], frame[asked], mover[asked]
        patches = self._narrow.query(
            np.stack([first, second], axis=1), self._pose[first], self._pose[second], limit[asked], self.settings.patch_points
        )
        centre = np.where((self._medium[first] | self._medium[second])[:, None], self._overlap(first, second), patches.centre)
        rotation, origin = self._pose[frame, :3, :3], self._pose[frame, :3, 3]
        pairs.known[rows] = True
        pairs.distance[rows] = patches.distance
        pairs.touching[rows] = patches.distance <= limit[asked]
        pairs.offset[rows] = offset[asked]
        pairs.turn[rows] = turn[asked]
        pairs.centre[rows] = turned_back(rotation, centre - origin)
        pairs.normal[rows] = turned_back(rotation, patches.normal)
        pairs.area[rows] = patches.area
        for row, index, corners in zip(rows.tolist(), range(len(rows)), patches.corners, strict=False):
            pairs.corners[row] = (corners - origin[index]) @ rotation[index]
        return len(rows)

    def _frames(self, rows: IntArray) -> tuple[IntArray, IntArray]:
        """Of each pair the larger body, in whose frame its contact is kept, and the other."""
        first, second = self._split(self._pairs.key[rows])
        larger = self._radius[first] >= self._radius[second]
        return np.where(larger, first, second), np.where(larger, second, first)

    def _relative(self, frame: IntArray, mover: IntArray) -> tuple[FloatArray, FloatArray]:
        rotation = self._pose[frame, :3, :3]
        middle = turned(self._pose[mover, :3, :3], self._middle[mover]) + self._pose[mover, :3, 3]
        return rotation.transpose(0, 2, 1) @ self._pose[mover, :3, :3], turned_back(rotation, middle - self._pose[frame, :3, 3])

    def _overlap(self, first: IntArray, second: IntArray) -> FloatArray:
        """The middle of what the bounds of two bodies have in common."""
        low = np.maximum(self._bounds[first, 0], self._bounds[second, 0])
        return np.asarray((low + np.minimum(self._bounds[first, 1], self._bounds[second, 1])) / 2)

    def _contact_set(self, rows: IntArray) -> ContactSet:
        """Contacts of pairs ``rows``: one each at the centre of its patch, or one per point of it."""
        pairs = self._pairs
        frame, _ = self._frames(rows)
        repeats = np.ones(len(rows), dtype=np.int64)
        points = pairs.centre[rows]
        if self.settings.patch_points and len(rows):
            repeats = np.array([len(pairs.corners[row]) for row in rows.tolist()], dtype=np.int64)
            points = np.concatenate([pairs.corners[row] for row in rows.tolist()])
            rows, frame = np.repeat(rows, repeats), np.repeat(frame, repeats)
        share = 1.0 / np.repeat(repeats, repeats)
        rotation = self._pose[frame, :3, :3]
        points = turned(rotation, points) + self._pose[frame, :3, 3]
        normal = turned(rotation, pairs.normal[rows])
        distance = pairs.distance[rows]
        gap = normal * (distance / 2)[:, None]
        return ContactSet(
            pairs=np.stack(self._split(pairs.key[rows]), axis=1),
            positions=np.stack([points - gap, points + gap], axis=1),
            normal=normal,
            depth=np.maximum(-distance, 0.0),
            distance=distance,
            area=pairs.area[rows] * share,
            share=share,
            transmission=np.zeros(len(rows), dtype=np.int64),
        )

    def _hits(self, paths: Paths | None, strikers: IntArray) -> Hits | None:
        """The hits among pairs ``strikers`` that took place."""
        if paths is None or len(strikers) == 0:
            return None
        hits = self._meetings.hits(paths, np.stack(self._split(strikers), axis=1))
        if len(hits) == 0:
            return None
        first, second = hits.pairs.T
        reach = hits.approach * paths.duration + self.settings.tolerance
        actual, _ = self._narrow.clearances(hits.pairs, self._pose[first], self._pose[second], np.maximum(reach, self.settings.tolerance))
        return hits.chosen(took_place(hits, paths.duration, actual, self.settings.tolerance))

    def _impacts(self, time: float, hits: Hits | None, paths: Paths | None) -> tuple[Impact, ...]:
        """Impacts that the hits make, by time."""
        if hits is None or paths is None:
            return ()
        fixed = ~self._dynamic
        energies = impact_energies(hits, self._mass, fixed, self.settings.energy) / self.settings.time_scale**2
        impacts = []
        for k in np.lexsort((hits.pairs[:, 1], hits.pairs[:, 0], hits.after)).tolist():
            a, b = hits.pairs[k].tolist()
            key, when = a * len(self.bodies) + b, time - paths.duration + float(hits.after[k])
            if energies[k] < self.settings.least_energy or when - self._last_impact.get(key, -np.inf) < self.settings.refractory:
                continue
            self._last_impact[key] = when
            impacts.append(hits.impact(k, when, float(energies[k]), self.settings.full_energy))
        return tuple(impacts)

    def _keys(self, impacts: Sequence[Impact]) -> IntArray:
        return np.array([a * len(self.bodies) + b for a, b in (impact.objects for impact in impacts)], dtype=np.int64)

    def _disturb(self, hits: Hits | None, paths: Paths | None) -> None:
        """Bodies that have hit something have to be watched anew: those known to, and those that are not where they would be otherwise."""
        if paths is None:
            return
        disturbed = self._history.surprised(paths)
        if hits is not None:
            disturbed[hits.pairs] = True
        self._history.disturb(np.flatnonzero(disturbed & self._dynamic))


def _same(a: BoolArray | Reach | None, b: BoolArray | Reach | None) -> bool:
    """Whether the same contacts are wanted."""
    if a is b:
        return True
    if isinstance(a, Reach) and isinstance(b, Reach):
        return all(np.array_equal(getattr(a, f.name), getattr(b, f.name)) for f in fields(Reach))
    return isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and np.array_equal(a, b)
