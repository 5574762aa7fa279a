"""Contacts from frame to frame: begin, end and impacts, recomputed only where something moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from time import perf_counter

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, among, carried, chosen_of, with_rows
from ..frozen import frozen
from ..message import Cause, Message
from .authored import ARRAYS
from .body_poses import BodyPoses
from .body_table import STILL as STILL
from .body_table import BodyTable
from .candidates import DISTANCE, Candidates
from .contact_set import ContactSet
from .hit_search import PRESSING_DISTANCE, HitSearch
from .impacts import Hits, Impact
from .joints import Joints
from .known_motion import KnownHits, KnownMotion, Samples
from .limbs import Limbs
from .motion import HITCH, PAUSE, MotionHistory
from .narrow.body_patches import PairPatches
from .narrow.frames import relative_pose, turned, turned_back, upwards
from .near_pairs import NearPairs
from .recent_impacts import RecentImpacts
from .settings import Body, ContactSettings, ImpactEnergy
from .striking import Striking
from .time_of_impact import Meetings

_NO_MOTION = 1e-12
"""Metres of relative motion that are rounding: two bodies that move together keep their contact."""

_CREEP = 0.05
"""Speed of approach [m/s] up to which touching bodies have come to rest against each other."""

_DEAD_ENDS = 8
"""Bodies on a dead end that are left out, counted from its tip."""


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

    @property
    def counts(self) -> dict[str, int]:
        """The numbers that a result of the tracer has."""
        return {
            "candidate_pairs": self.candidates,
            "contact_queries": self.queries,
            "queries_avoided": self.avoided,
        }


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
    """The contacts of one frame.

    Attributes:
        contacts: sorted by the numbers of the bodies; the same object as in the last frame where
            nothing has changed.
        impacts: since the last frame, sorted by time.
        statistics: work of the update.
        warnings: about objects.
    """

    contacts: ContactSet
    impacts: tuple[Impact, ...]
    statistics: ContactStatistics
    warnings: tuple[Message, ...]


class ContactTracker:
    """Follows the contacts of ``bodies`` from frame to frame. What is known of their shapes it
    takes over from the one ``before``.

    It composes a `BodyTable`, which depends on bodies and shapes alone, and the state of motion,
    which `reset` drops: `MotionHistory`, `BodyPoses`, `NearPairs`, `Candidates`, `RecentImpacts`.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        settings: ContactSettings | None = None,
        before: ContactTracker | None = None,
    ) -> None:
        self.settings = settings or ContactSettings()
        self._take(bodies, None if before is None else before._table)
        self._striking = Striking(self.settings)
        self.reset()

    def _take(self, bodies: Sequence[Body], before: BodyTable | None) -> None:
        """Take over other bodies, and what is known of their shapes from a table ``before``."""
        settings = self.settings
        self.bodies = tuple(bodies)
        self._table: BodyTable = BodyTable(bodies, before, settings.passing)
        self._joints: Joints = Joints(self._table, bodies, settings.joints, settings.tolerance)

    def reset(self) -> None:
        """Drop all history: the next update begins no contact and makes no impact."""
        count = len(self.bodies)
        none = np.zeros(0, dtype=np.int64)
        self._history = MotionHistory(count)
        self._poses = BodyPoses(count)
        self._near = NearPairs(count)
        self._pairs = Candidates.of(none, none, none)
        self._recent = RecentImpacts(self.settings)
        self._limbs = Limbs(self.settings)
        self._airborne = self._table.dynamic.copy()
        self._new = np.ones(count, dtype=np.bool_)  # bodies without an update so far
        self._queries, self._begun = 0, 0.0
        self._last: FrameContacts | None = None
        self._last_endpoints: Endpoints | None = None
        self._reported = np.zeros((3, 0), dtype=np.int64)

    def history(self) -> tuple[FloatArray | IntArray | BoolArray, ...]:
        """The state that later frames depend on, except their own poses: motion, contacts, and
        recent impacts."""
        pairs = self._pairs
        time = self._history.times[-1] if self._history.times else 0.0
        touching = pairs.touching.nonzero()[0]
        pair_state = (
            pairs.key[touching],
            pairs.struck[touching],
            pairs.values[:, touching],
        )
        recent = self._recent.history(time)
        limbs = self._limbs.history()
        return *self._history.history(), *pair_state, self._airborne, recent, *limbs

    def replace_bodies(self, bodies: Sequence[Body], anew: frozenset[str] = frozenset()) -> None:
        """Replace the list of bodies, or shapes and masses of some. A body whose name was in the
        list before keeps its motion and contacts, unless it begins ``anew``, by name; the next
        update makes no impact of the others."""
        before, table = self.bodies, self._table
        known = {body.name: body for body in before if body.name not in anew}
        names = [body.name for body in bodies]
        changed = np.array(
            [(old := known.get(body.name)) is not body and old != body for body in bodies],
            dtype=np.bool_,
        )
        self.bodies = tuple(bodies)
        posed = np.zeros_like(changed)  # of these bodies, only parts have moved
        fits = names == [body.name for body in before]
        for k in changed.nonzero()[0].tolist() if fits else ():
            posed[k] = table.move_parts(k, before[k], bodies[k])
            if not posed[k] and bodies[k] != before[k]:
                fits = False
        if not fits:
            self._take(bodies, table)
        if names != list(known) or len(known) < len(before):
            number = {body.name: k for k, body in enumerate(before) if body.name in known}
            self._renumber(
                table,
                np.array([number.get(name, -1) for name in names], dtype=np.int64),
            )
        self._poses.forget(changed)
        self._near.forget(self._table, changed & ~posed)
        pairs = self._pairs
        pairs.larger, pairs.smaller = self._table.by_size(pairs.key)
        pairs.known &= ~pairs.one_of(changed)

    def _renumber(self, table: BodyTable, before: IntArray) -> None:
        """Renumber the whole state, which is by the numbers of the former ``table``: ``before``
        (n,) are the former numbers of the bodies, -1 for a new one. The state of bodies that are
        not there any more is dropped."""
        there = before >= 0
        after = np.full(len(table), -1)
        after[before[there]] = there.nonzero()[0]

        def renumbered(key: IntArray) -> tuple[IntArray, IntArray]:
            """The rows of the pairs that remain, and their new keys, sorted."""
            pairs = np.sort(after[table.numbers(key)], axis=1)
            rows = (pairs[:, 0] >= 0).nonzero()[0]
            found = self._table.keys(pairs[rows])
            order = found.argsort()
            return rows[order], found[order]

        self._history.renumber(before)
        self._poses.renumber(before)
        self._near.renumber(self._table, before, renumbered(self._near.key)[1])
        rows, key = renumbered(self._pairs.key)
        self._pairs = chosen_of(self._pairs, rows)
        self._pairs.key = key
        self._recent.renumber(*renumbered(self._recent.keys()))
        self._airborne = carried(self._airborne, before, True)
        self._new = carried(self._new, before, True)
        self._last = None

    def update(
        self,
        time: float,
        transforms: FloatArray,
        endpoints: Endpoints | None = None,
        continuous: bool = True,
        impacts: bool = True,
        exact: bool = False,
        motion: KnownMotion | None = None,
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
            motion: known of some bodies since the last frame; hits between these, and with those
                that stand still, are found on it.

        A body whose transform is not finite is left out, with a warning.
        """
        transforms = np.asarray(transforms, dtype=np.float64)
        if transforms.shape != (len(self.bodies), 4, 4):
            raise ValueError(
                f"transforms: expected {len(self.bodies)} matrices of 4 x 4, got an array of "
                f"shape {transforms.shape}"
            )
        since = time - self._history.times[-1] if self._history.times else 0.0
        if not continuous or (self._history.times and not 0 < since <= PAUSE):
            self.reset()
        self._queries = 0
        self._begun = perf_counter()
        moved, warnings = self._place(time, transforms)
        if exact:
            self._poses.rest_here()
            self._pairs.version[:] = -1
        elif (
            self._last is not None
            and len(moved) == 0
            and not self._history.stops()
            and _same_request(endpoints, self._last_endpoints)
        ):
            return self._unchanged(warnings)
        names = [body.name for body in self.bodies] if motion is not None else ()
        samples = None if motion is None else motion.numbered(names)
        search = self._near_pairs(moved, impacts, samples)
        if impacts:
            striking = self._striking.soon(self._table, self._history)
        else:
            striking = np.zeros(len(self.bodies), dtype=np.bool_)
            self._history.disturb(~striking)
        if impacts:
            pairs = self._pairs
            held, able = self._joined(pairs, search)
            late = ~pairs.examined & np.where(held, able, pairs.one_of(striking))
            if self._examine_last_frame(late.nonzero()[0]):
                search = self._near_pairs(moved, impacts, samples)
        known = None if search is None or samples is None else KnownHits(search, samples)
        result = self._contacts(endpoints, striking, search, known, warnings, exact, impacts)
        if not impacts:
            self._pairs.struck |= self._pairs.touching
        self._last, self._last_endpoints = result, endpoints
        self._new[:] = False
        return result

    def _joined(self, pairs: Candidates, search: HitSearch | None) -> tuple[BoolArray, BoolArray]:
        """Which of some pairs (p,) a joint holds, and which a ``search`` for hits is about: only
        these of the former are traced."""
        able = np.zeros(len(pairs.key), dtype=np.bool_)
        if search is not None:
            able = among(pairs.key, search.keys)
        return among(pairs.key, self._joints.holding(self._poses)), able

    def _place(self, time: float, transforms: FloatArray) -> tuple[IntArray, tuple[Message, ...]]:
        """Store the poses that have changed. Returns the numbers of their bodies, and warnings
        about bodies left out."""
        columns, moved, left, lost = self._poses.place(self._table, transforms, self._grow)
        self._history.advance(time, columns, left)
        self._history.disturb(lost)
        self._limbs.follow(self.bodies, self._table, transforms, self._new)
        names = [self.bodies[k].name for k in lost.tolist()]
        return moved, tuple(
            Message.of(Cause.TRANSFORM_NOT_FINITE, name, object=name) for name in names
        )

    @property
    def _grow(self) -> float:
        """Metres by which bounds are grown so that they overlap wherever two bodies can touch."""
        return (self.settings.tolerance + self.settings.slack) / 2 + 2 * STILL

    def _unchanged(self, warnings: tuple[Message, ...]) -> FrameContacts:
        assert self._last is not None
        statistics = ContactStatistics(len(self._pairs.key), 0, perf_counter() - self._begun)
        return FrameContacts(self._last.contacts, (), statistics, warnings)

    def _near_pairs(
        self, moved: IntArray, impacts: bool, samples: Samples | None
    ) -> HitSearch | None:
        """Update the near pairs. Returns the search for hits between them, None if nothing is fast
        enough for an impact. ``samples``: of known motion."""
        table, poses = self._table, self._poses
        fast = None
        if impacts:
            fast = self._striking.paths(table, self._history, self._airborne, samples)
        if fast is None:
            self._near.widen(table, self._history, poses.extents, moved)
            return None
        paths, speed = fast
        rapid = self._striking.rapid(table, speed)
        rows = rapid.nonzero()[0]
        ahead = table.extents(rows, paths.poses(rows, paths.duration), self._grow)
        extents = poses.extents.copy()
        for other in (poses.last_extents[..., rows], ahead):
            extents[..., rows] = np.maximum(extents[..., rows], other)
        if samples is not None:
            rows = samples.bodies
            way = samples.extents(table, self._grow)
            extents[..., rows] = np.maximum(extents[..., rows], way)
        self._near.widen(table, self._history, extents, moved)
        near = self._near
        pairs = (rapid[near.larger] | rapid[near.smaller]).nonzero()[0]
        a, b = near.larger[pairs], near.smaller[pairs]
        able = (table.layers[a] & table.layers[b]) > 0
        able &= ~among(near.key[pairs], table.passing)
        able &= self._striking.able(table, speed, a, b)
        able &= near.met(extents, pairs) | table.time_of_impact.may_hit(
            paths, a, b, poses.last_extents
        )
        return HitSearch(self.settings, table, poses, near, paths, pairs[able])

    def _examine_last_frame(self, rows: IntArray) -> bool:
        """Find out which pairs ``rows``, which were not examined in the last frame, touched in its
        poses. Returns whether any did."""
        if len(rows) == 0:
            return False
        pairs = self._pairs
        bodies = pairs.bodies(rows)
        poses = self._history.last_poses
        self._queries += len(rows)
        turn, offset = relative_pose(*(poses.take(numbers, axis=1) for numbers in bodies.T))
        place = turned(turn, self._table.middle.take(bodies[:, 1], axis=1)) + offset
        limit = self._table.tolerance(bodies[:, 0], bodies[:, 1], self.settings.tolerance)
        found = self._table.narrow.query(bodies, turn, offset, limit)
        touching = found.distance <= limit
        pairs.store(rows, turn, offset, place, found)
        pairs.examined[rows], pairs.known[rows] = True, False
        pairs.touching[rows] = pairs.struck[rows] = touching
        self._airborne[bodies[touching]] = False
        return bool(touching.any())

    def _contacts(
        self,
        endpoints: Endpoints | None,
        striking: BoolArray,
        search: HitSearch | None,
        known: KnownHits | None,
        warnings: tuple[Message, ...],
        exact: bool,
        unsearched: bool,
    ) -> FrameContacts:
        """The contacts of this frame.

        Args:
            endpoints: as in `update`.
            striking: which bodies may soon take part in an impact (n,), see `Striking.soon`.
            search: for hits, None where there can be none.
            known: the hits of bodies whose motion is known, None without these.
            warnings: about bodies that were left out.
            exact: as in `update`.
            unsearched: whether parts of skins strike, and what has the mass of its volume.
        """
        table = self._table
        old = self._pairs
        struck = old.key[old.struck]
        met = self._near.met(self._poses.extents)
        pairs = self._pairs = old.carried_to(
            self._near.key[met], self._near.larger[met], self._near.smaller[met]
        )
        broad = perf_counter() - self._begun
        blows = self._unsearched(endpoints, exact) if unsearched else []
        fresh = pairs.fresh(self._poses)
        exactly = Hits.none() if known is None else known.hits()
        meetings = None
        sounding = striking
        if search is not None:
            keys = np.zeros(0, dtype=np.int64) if known is None else known.keys
            free = search.able[~among(search.keys, struck) & ~among(search.keys, keys)]
            meetings = search.meetings(pairs, free)
            sounding = striking | self._struck_by(search, exactly, meetings)
        if blows:
            sounding = sounding.copy()
            sounding[[number for blow in blows for number in blow.objects]] = True
        requested = self._requested(endpoints, sounding)
        held, able = self._joined(pairs, search)
        late = fresh if endpoints is None else fresh | pairs.one_of(striking)
        examined = ((requested | late) & ~held) | able
        self._examine_last_frame((examined & ~pairs.examined).nonzero()[0])
        before = pairs.touching & pairs.examined
        distance = pairs.distance.copy()
        queried = examined & ~fresh
        rows = queried.nonzero()[0]
        hits = Hits.none()
        impacts: tuple[Impact, ...] = ()
        if search is None:
            self._query(rows, before, None, exact)
        else:
            last = pairs.values.copy()
            hits = self._query(rows, before, meetings, exact)
            if len(search.able):
                hits = self._hits(search, hits, free, before, queried, last)
            if known is not None:
                hits = exactly.joined(known.landed(hits))
                struck = struck[~among(struck, keys)]
            if blows:
                told = np.sort(table.keys(np.array([blow.objects for blow in blows])))
                hits = hits.chosen(~among(table.keys(hits.pairs), told))
            impacts = self._impacts_of(hits, search.paths.duration, struck, keys)
            warnings += self._uncertain(impacts)
        if blows:
            impacts = tuple(sorted([*impacts, *blows], key=lambda each: (each.time, each.objects)))
        pairs.touching &= examined
        pairs.examined = examined
        pairs.open = np.where(examined, ~(pairs.touching & pairs.meet), pairs.open & ~held)
        self._settle(before, distance, impacts, held)
        if search is not None:
            self._history.disturb(self._history.deviated(search.paths) & table.dynamic)
            self._history.hit(hits.pairs, hits.time)
        contacts = self._reported_contacts(requested, held, exact)
        statistics = ContactStatistics(len(pairs.key), self._queries, broad)
        return FrameContacts(contacts, impacts, statistics, warnings)

    def _impacts_of(
        self, hits: Hits, duration: float, struck: IntArray, traced: IntArray
    ) -> tuple[Impact, ...]:
        """The impacts of hits in the last interval of this ``duration`` [s]. By key, the pairs that
        have not parted since their last impact, and those of which the motion is known."""
        key = self._table.keys(hits.pairs)
        moved = self._history.moving() & ~self._table.dynamic
        return self._recent.of(
            hits,
            self._history.times[-1] - duration,
            among(key, struck),
            moved[hits.pairs].any(axis=1) & ~among(key, traced),
            self.bodies,
            self._table,
        )

    def _unsearched(self, endpoints: Endpoints | None, exact: bool) -> list[Impact]:
        """The impacts of parts of skins, and of what has the mass of its volume."""
        blows: list[Impact] = []
        if self.settings.energy is ImpactEnergy.EFFECTIVE:
            blows += self._of_limbs() if self._table.limbs else []
            blows += self._of_weighed(endpoints, exact) if self._table.weighed.any() else []
        return blows

    def _of_limbs(self) -> list[Impact]:
        """The impacts of the parts of skins since the last frame."""
        pairs, history = self._pairs, self._history
        skins = np.zeros(len(self._table), dtype=np.bool_)
        skins[[*self._table.limbs]] = True
        rows = (pairs.one_of(skins) & ~among(pairs.key, self._table.passing)).nonzero()[0]
        several = self.bodies, self._table, pairs.bodies(rows), history.times, history.poses
        return self._limbs.impacts(*several)

    def _of_weighed(self, endpoints: Endpoints | None, exact: bool) -> list[Impact]:
        """The impacts since the last frame between bodies that animation moves, with the mass of
        their volume, and bodies that can't be moved. Only pairs that begin to touch are examined.
        ``endpoints`` and ``exact`` as in `update`."""
        table, pairs, history = self._table, self._pairs, self._history
        strikes = pairs.one_of(table.weighed & history.moving()) & ~pairs.one_of(table.movable)
        strikes &= (table.layers[pairs.larger] & table.layers[pairs.smaller]) > 0
        strikes &= pairs.open & ~among(pairs.key, table.passing)
        if endpoints is not None:
            strikes &= self._near.in_heaps_of(endpoints.heard)[pairs.larger]
        rows = strikes.nonzero()[0]
        if not len(rows):
            return []
        self._examine_last_frame(rows[~pairs.examined[rows]])
        before = pairs.touching & pairs.examined
        apart = ~(before & pairs.meet) & ~pairs.one_of(self._new)
        self._query(rows, before, None, exact)
        begun = rows[(pairs.touching & pairs.meet & apart)[rows]]
        paths = None
        if len(begun):
            paths = history.paths(~table.dynamic, self._airborne, self._striking.gravity)
        if paths is None:
            return []
        able = self._near.key.searchsorted(pairs.key[begun])
        search = HitSearch(self.settings, table, self._poses, self._near, paths, able)
        hits = table.time_of_impact.hits_at(search.meetings(pairs, able))
        hits = search.confirmed(hits, pairs.key[begun])
        yes, time = np.ones(len(hits), dtype=np.bool_), history.times[-1]
        self._recent.expire(time, paths.duration)
        told = self._recent.of(hits, time - paths.duration, ~yes, yes, self.bodies, table)
        return [*told]

    def _struck_by(self, search: HitSearch, exactly: Hits, meetings: Meetings | None) -> BoolArray:
        """Which bodies (n,) may be struck in this interval: those that hit each other ``exactly``,
        that meet on their paths, or that touch and may land."""
        touching = search.keys[among(search.keys, self._pairs.key[self._pairs.touching])]
        found = np.zeros(len(self._table), dtype=np.bool_)
        found[exactly.pairs] = found[self._table.numbers(touching)] = True
        if meetings is not None:
            found[meetings.moving.pairs] = True
        return found

    def _hits(
        self,
        search: HitSearch,
        met: Hits,
        free: IntArray,
        before: BoolArray,
        queried: BoolArray,
        last: FloatArray,
    ) -> Hits:
        """The hits of this frame.

        Args:
            search: for them.
            met: hits of pairs that meet on their paths.
            free: numbers of the near pairs that have parted since their last impact.
            before: which pairs touched in the last frame (p,).
            queried: which pairs were queried in this frame (p,).
            last: the values of all pairs in the last frame.
        """
        pairs = self._pairs
        now = pairs.touching & queried
        hitch = search.paths.duration >= HITCH
        arrived = pairs.key[now & ~before & (hitch | (pairs.distance <= PRESSING_DISTANCE))]
        hits = search.confirmed(met, arrived[among(arrived, self._near.key[free])])
        self._recent.expire(self._history.times[-1], search.paths.duration)
        pivoting = before & now & among(pairs.key, search.keys)
        # What was still apart has struck with another part first.
        first = np.sort(self._table.keys(hits.pairs))
        pivoting &= ~among(pairs.key, first) | (last[DISTANCE] <= PRESSING_DISTANCE)
        landed = search.landings(pairs, pivoting.nonzero()[0], last)
        there = np.sort(self._table.keys(landed.pairs))
        return hits.chosen(~among(self._table.keys(hits.pairs), there)).joined(landed)

    def _settle(
        self,
        before: BoolArray,
        distance: FloatArray,
        impacts: Sequence[Impact],
        held: BoolArray,
    ) -> None:
        """Update which pairs make no further impact until they part, and which bodies are in free
        flight.

        Args:
            before: whether each pair touched in the last frame (p,).
            distance: of the pairs in the last frame (p,) [m].
            impacts: of this frame.
            held: which pairs a joint holds (p,).
        """
        pairs = self._pairs
        settled = before & (distance - pairs.distance <= _CREEP * self._history.step)
        if impacts:
            hit = self._table.keys(np.array([impact.objects for impact in impacts]))
            settled |= among(pairs.key, np.sort(hit))
        pairs.struck = pairs.touching & (pairs.struck | settled | pairs.one_of(self._new))
        self._airborne = self._table.dynamic.copy()
        self._airborne[pairs.bodies((pairs.struck | held).nonzero()[0])] = False

    def _reported_contacts(self, requested: BoolArray, held: BoolArray, exact: bool) -> ContactSet:
        """Contacts of the pairs ``requested`` (p,), of those that a joint holds (p,) at the pivot;
        those of the last frame where neither body has moved."""
        # Whether a pair has parted depends on the past, by the slack; its contact only on the
        # poses.
        pairs, most = self._pairs, self.settings.tolerance
        near = pairs.distance <= self._table.tolerance(pairs.larger, pairs.smaller, most)
        rows = ((held | (pairs.touching & near)) & requested).nonzero()[0]
        versions = (self._poses.version[bodies[rows]] for bodies in (pairs.larger, pairs.smaller))
        state = np.array([pairs.key[rows], *versions])
        computed = exact and self._queries > 0
        before, self._reported = self._reported, state
        if self._last is None or computed or not np.array_equal(state[0], before[0]):
            return self._contacts_of(rows, held)
        changed = (state[1:] != before[1:]).any(axis=0).nonzero()[0]
        if len(changed) == 0:
            return self._last.contacts
        here = self._contacts_of(rows[changed], held)
        return with_rows(self._last.contacts, ARRAYS, changed, here)

    def _contacts_of(self, rows: IntArray, held: BoolArray) -> ContactSet:
        """Contacts of the pairs ``rows`` (k,), of those that a joint holds (p,) at the pivot."""
        pairs = self._pairs
        found = pairs.contacts(rows, self._table, self._poses, self.settings.tolerance)
        joined = held[rows].nonzero()[0]
        if len(joined) == 0:
            return found
        at_pivots = self._joints.contacts(pairs.key[rows[joined]], self._poses)
        return with_rows(found, ARRAYS, joined, at_pivots)

    def _requested(self, endpoints: Endpoints | None, striking: BoolArray) -> BoolArray:
        """Which candidate pairs (p,) the caller wants: those in heaps that hold both a listener and
        a source, or a body that may strike (n,)."""
        pairs = self._pairs
        if endpoints is None:
            return np.ones(len(pairs.key), dtype=np.bool_)
        sounding = endpoints.sounding | striking
        heaps = self._near.in_heaps_of
        wanted = (heaps(endpoints.heard) & heaps(sounding))[pairs.larger]
        if endpoints.paths:
            silent = ~(endpoints.heard | sounding)
            for _ in range(_DEAD_ENDS):
                bodies = pairs.bodies(wanted.nonzero()[0]).reshape(-1)
                tip = silent & (np.bincount(bodies, minlength=len(silent)) == 1)
                dead = wanted & pairs.one_of(tip)
                if not dead.any():
                    break
                wanted &= ~dead
        return wanted

    def _query(
        self, rows: IntArray, before: BoolArray, meetings: Meetings | None, exact: bool
    ) -> Hits:
        """Bring the values of the pairs ``rows`` up to date, by a query for those whose bodies have
        moved relative to each other. Returns the hits at ``meetings``, whose patches are part of
        the same query because one large query costs less than two.

        Args:
            rows: numbers of pairs.
            before: whether each pair touched in the last frame (p,).
            meetings: on the paths of the bodies, None without.
            exact: as in `update`.
        """
        search = self._table.time_of_impact
        if len(rows) == 0:
            return search.hits_at(meetings)
        pairs = self._pairs
        bodies = pairs.bodies(rows)
        larger, smaller = bodies.T
        pairs.version[:, rows] = self._poses.version[bodies.T]
        most, slack = self.settings.tolerance, self.settings.slack
        limit = self._table.tolerance(larger, smaller, most)
        limit *= np.where(before[rows], 1 + slack / most if most else 1.0, 1.0)
        turn, offset = relative_pose(
            self._poses.pose.take(larger, axis=1),
            self._poses.pose.take(smaller, axis=1),
        )
        place = turned(turn, self._table.middle.take(smaller, axis=1)) + offset
        # No query: pairs that touch and have not moved relative to each other, or that are too far
        # apart to touch after their motion since the last query.
        motion = pairs.motion(rows, turn, place, self._table.radius[smaller])
        apart = pairs.distance[rows] - motion > limit
        known = pairs.known[rows] & (pairs.touching[rows] == before[rows])
        still = motion <= (0.0 if exact else _NO_MOTION)
        current = known & np.where(before[rows], still, apart)
        if current.any():
            asked = (~current).nonzero()[0]
            rows, bodies, limit = rows[asked], bodies[asked], limit[asked]
            turn = turn.take(asked, axis=2)
            offset = offset.take(asked, axis=1)
            place = place.take(asked, axis=1)
        placing = bodies, turn, offset, limit
        if meetings is None:
            found = self._patches(*placing)
            hits = Hits.none()
        else:
            several = zip(placing, meetings.placing, (0, 2, 1, 0), strict=True)
            both = self._patches(
                *(np.concatenate([mine, theirs], axis=axis) for mine, theirs, axis in several)
            )
            found = both.part(slice(len(rows)))
            hits = meetings.hits(both.part(slice(len(rows), None)))
        pairs.store(rows, turn, offset, place, found)
        pairs.touching[rows] = found.distance <= limit
        self._queries += len(rows)
        return hits

    def _patches(
        self, numbers: IntArray, turn: FloatArray, offset: FloatArray, limit: FloatArray
    ) -> PairPatches:
        """Patches of pairs ``numbers`` (p, 2) by the narrow phase. A medium and a body in it touch
        at the centre of the intersection of their bounds, without area or depth."""
        narrow = self._table.narrow
        medium = self._table.medium[numbers[:, 0]] | self._table.medium[numbers[:, 1]]
        if not medium.any():
            return narrow.query(numbers, turn, offset, limit)
        inside = medium.nonzero()[0]
        others = (~medium).nonzero()[0]
        found = narrow.query(numbers[others], turn[..., others], offset[:, others], limit[others])
        distance = narrow.gaps(numbers[inside], turn[..., inside], offset[:, inside])
        a, b = numbers[inside].T
        against, along = np.minimum(self._poses.extents[..., a], self._poses.extents[..., b])
        middle = (along - against) / 2
        pose = self._poses.pose[:, a]
        centre = turned_back(pose[:9].reshape(3, 3, -1), middle - pose[9:])
        wet = PairPatches(distance, upwards(len(inside)), centre, np.zeros(len(inside)))
        return PairPatches.joined(len(medium), (others, found), (inside, wet))

    def _uncertain(self, impacts: Sequence[Impact]) -> tuple[Message, ...]:
        """A warning for each impact whose time the search did not find within its steps."""
        unsure = self._table.time_of_impact.unsure
        names = [
            tuple(self.bodies[k].name for k in impact.objects)
            for impact in impacts
            if impact.objects in unsure
        ]
        unsure.clear()
        return tuple(
            Message.of(Cause.IMPACT_TIME, second, first=first, second=second)
            for first, second in names
        )


def _same_request(a: Endpoints | None, b: Endpoints | None) -> bool:
    """Whether two updates want the same contacts."""
    if a is None or b is None:
        return a is b
    return np.array_equal(a.heard, b.heard) and np.array_equal(a.sounding, b.sounding)
