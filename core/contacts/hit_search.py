"""Hits between bodies in the interval before a frame, found on their paths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, added_by, among, ranges
from ..frozen import frozen
from .body_poses import BodyPoses
from .body_table import BodyTable
from .candidates import DISTANCE, NORMAL, ON_LARGER, Candidates, placed
from .impacts import SWUNG, Hits, confirmed, landings
from .motion import HITCH, Paths
from .narrow.frames import dot, relative_pose, turned, turned_back
from .near_pairs import NearPairs
from .settings import ContactSettings
from .time_of_impact import Meetings

TOGETHER = 0.9
"""Part of the speed of a pair's fastest point from which on others land with it."""

PRESSING_DISTANCE = 2e-3
"""Distance below which bodies count as pressing on each other [m]."""


@frozen(eq=False)
class HitSearch:
    """The search in one interval.

    Attributes:
        settings: of contacts.
        table: of the bodies.
        poses: at the end of the interval.
        near: the near pairs.
        paths: of the bodies in the interval.
        able: (k,) numbers of the near pairs with the energy for an impact.
    """

    settings: ContactSettings
    table: BodyTable
    poses: BodyPoses
    near: NearPairs
    paths: Paths
    able: IntArray

    @property
    def keys(self) -> IntArray:
        """The near pairs with the energy for an impact (k,), by key, ascending."""
        return self.near.key[self.able]

    def meetings(self, pairs: Candidates, free: IntArray) -> Meetings | None:
        """Where and when those near pairs ``free``, by number, that meet on their paths do so."""
        table, near = self.table, self.near
        search = table.time_of_impact
        is_mesh = table.narrow.is_mesh
        meshes = (is_mesh[near.larger[free]] | is_mesh[near.smaller[free]]).nonzero()[0]
        if len(meshes):  # their distances take long: use those of the last query
            far = self._out_of_reach(pairs, near.key[free[meshes]])
            free = np.delete(free, meshes[far])
        return search.meetings(self.paths, table.numbers(near.key[free]))

    def _out_of_reach(self, pairs: Candidates, key: IntArray) -> BoolArray:
        """Which near pairs, by key, can't meet on their paths: boxes around them are farther apart
        than the paths can close, or their distance at the last query, less their motion since,
        is."""
        larger, smaller = self.table.by_size(key)
        turn, offset = self._before(larger, smaller)
        least = self.table.narrow.box_gaps(np.stack([larger, smaller], axis=1), turn, offset)
        if len(pairs.key):
            rows = pairs.rows_of(key)
            place = turned(turn, self.table.middle[:, smaller]) + offset
            motion = pairs.motion(rows, turn, place, self.table.radius[smaller])
            known = (pairs.key[rows] == key) & pairs.known[rows]
            least = np.where(known, np.maximum(least, pairs.distance[rows] - motion), least)
        approach = self.table.time_of_impact.largest_approach(self.paths, larger, smaller)
        return np.asarray(least > approach)

    def _before(self, larger: IntArray, smaller: IntArray) -> tuple[FloatArray, FloatArray]:
        """How smaller bodies were placed in the frames of larger ones at the start."""
        return relative_pose(
            *(self.paths.start.take(bodies, axis=1) for bodies in (larger, smaller))
        )

    def confirmed(self, hits: Hits, arrived: IntArray) -> Hits:
        """The confirmed ones among ``hits``, and those of pairs, by key, that have ``arrived`` at
        each other by the end of the interval although their motion did not lead there. Something
        else has moved these, so their hits are found on paths that lead to their actual poses."""
        if len(hits):
            tolerance = self.table.tolerance(
                hits.pairs[:, 0], hits.pairs[:, 1], self.settings.tolerance
            )
            hits = hits.chosen(confirmed(hits, self.paths, tolerance))
        if len(arrived):
            arrived = arrived[~among(arrived, np.sort(self.table.keys(hits.pairs)))]
        if len(arrived):
            search = self.table.time_of_impact
            pairs = self.table.numbers(arrived)
            if self.paths.duration >= HITCH:  # they touch in the end, whatever happened before
                after = np.full(len(pairs), self.paths.duration)
                return hits.joined(search.hits_after(self.paths, pairs, after).approaching())
            expected = search.final_distances(self.paths, pairs)
            pulled = pairs[
                (expected > 2 * PRESSING_DISTANCE) & self._carried(hits.pairs)[pairs].any(axis=1)
            ]
            if len(pulled):
                meetings = search.meetings(self.paths.through_ends(), pulled)
                hits = hits.joined(search.hits_at(meetings).approaching())
        return hits

    def _carried(self, struck: IntArray) -> BoolArray:
        """Which bodies (n,) something else than their own motion may have carried to where they
        are: dynamic ones, but not one that lay still, and that none of the pairs ``struck`` (k, 2)
        has hit, and now is farther away than it can have fallen."""
        paths, dynamic = self.paths, self.table.dynamic
        still = np.all(np.abs(paths.start - paths.earlier) <= self.table.rest_limits, axis=0)
        still &= ~np.isin(np.arange(len(dynamic)), struck)
        way = paths.end[9:] - paths.start[9:]
        fall = np.linalg.norm(self.settings.gravity) * self.settings.time_scale**2
        far = dot(way, way) > (fall * paths.duration**2) ** 2
        return np.asarray(dynamic & ~(still & far))

    def landings(self, pairs: Candidates, rows: IntArray, last: FloatArray) -> Hits:
        """Hits of the pairs ``rows``, which touch in both frames, by a part that was away from the
        other body before; of each pair, the hit of the patch's fastest point, in the middle of
        those that land with it. ``last``: the values of all pairs in the last frame."""
        table = self.table
        rows = rows[~pairs.one_of(table.medium)[rows]]
        rows = rows[self._swings(pairs, rows)]
        if len(rows) == 0:
            return Hits.none()
        bodies = pairs.bodies(rows)
        of, points, was, old = self._corners(bodies, pairs.values[:, rows], last[:, rows])
        pose = self.poses.pose.take(bodies[:, 0], axis=1)
        normal, distance = pairs.values[NORMAL, rows], pairs.distance[rows]
        numbers = table.numbers(pairs.key[rows])
        flipped = bodies[:, 0] != numbers[:, 0]
        normal = turned(pose[:9].reshape(3, 3, -1)[..., of], normal[:, of])
        normal *= np.where(flipped[of], -1.0, 1.0)
        distance = distance[of]
        gap = normal * (distance / 2)
        nodes = np.array([points - gap, points + gap])
        old = np.where(flipped[was], old[::-1], old)
        # Each corner beside all that its pair had before.
        size = np.bincount(was, minlength=len(rows))
        beside = ranges((size.cumsum() - size)[of], size[of])
        own = np.arange(len(of)).repeat(size[of])
        way = nodes[..., own] - old[..., was.argsort(kind="stable")[beside]]
        away = np.full(len(of), np.inf)
        np.minimum.at(away, own, np.sqrt((way**2).sum(axis=1).min(axis=0)))
        hits = landings(self.paths, numbers[of], nodes, away, normal, distance, PRESSING_DISTANCE)
        if len(hits) == 0:
            return hits
        order = hits.approach.argsort(kind="stable")[::-1]
        _, first, pair = np.unique(
            table.keys(hits.pairs[order]), return_index=True, return_inverse=True
        )
        fastest = hits.chosen(order[first])
        with_it = (hits.approach[order] >= TOGETHER * fastest.approach[pair]).nonzero()[0]
        centre = added_by(pair[with_it], hits.centre[order[with_it]].T, len(first))
        count = np.bincount(pair[with_it], minlength=len(first))
        return replace(fastest, centre=(centre / count).T)

    def _swings(self, pairs: Candidates, rows: IntArray) -> BoolArray:
        """Which of the pairs ``rows`` (k,) may have a part that swings down. The gap along the
        normal between what is now in one place of both bodies was a linear function of the place:
        its largest value within the bounds of both tells."""
        bodies = pairs.bodies(rows).T
        low, high = (way.take(bodies, axis=1).min(axis=1) for way in self.poses.extents)
        middle, half = (high - low) / 2, (high + low) / 2
        now = self.poses.pose.take(bodies, axis=1)
        normal = turned(now[:9, 0].reshape(3, 3, -1), pairs.values[NORMAL, rows])
        gaps, slopes = [], []
        for poses in (self.paths.start, self.paths.earlier):
            then = poses.take(bodies, axis=1)
            turns = [each[:9].reshape(3, 3, 2, -1) for each in (now, then)]
            back = np.stack(
                [turned(turns[0][:, :, k], turned_back(turns[1][:, :, k], normal)) for k in (0, 1)]
            )
            at = [dot(normal, then[9:, k]) + dot(back[k], middle - now[9:, k]) for k in (0, 1)]
            gaps.append(at[1] - at[0])
            slopes.append(back[1] - back[0])
        start = gaps[0] + dot(np.abs(slopes[0]), half)
        before = gaps[1] - gaps[0] + dot(np.abs(slopes[1] - slopes[0]), half)
        speed = np.maximum(start / self.paths.duration, before / self.paths.earlier_duration)
        return np.asarray((start > PRESSING_DISTANCE) & (speed > SWUNG))

    def _corners(
        self, bodies: IntArray, values: FloatArray, last: FloatArray
    ) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
        """Of each corner of the patches of pairs of ``bodies`` (p, 2), with ``values`` (rows, p)
        now and ``last`` in the last frame: the number (k,) of the pair, and where it is (3, k);
        then of each that they had in the last frame the number (m,) of the pair, and where the
        material of the larger and of the smaller body there (2, 3, m) is now."""
        count = len(bodies)
        larger, smaller = (self.poses.pose.take(numbers, axis=1) for numbers in bodies.T)
        placing = relative_pose(larger, smaller), self._before(*bodies.T)
        turn, offset = (np.concatenate(both, axis=-1) for both in zip(*placing, strict=True))
        both = np.concatenate([values, last], axis=1)
        gap = both[NORMAL] * (both[DISTANCE] / 2)
        most = self.settings.tolerance + self.settings.slack
        limit = np.tile(self.table.tolerance(bodies[:, 0], bodies[:, 1], most), 2)
        several = np.concatenate([bodies, bodies])
        of, places = self.table.narrow.corners(
            several, turn, offset, limit, both[NORMAL], both[ON_LARGER] + gap
        )
        now, before = (of < count).nonzero()[0], (of >= count).nonzero()[0]
        points = placed(larger[:, of[now]], places[:, now])
        was, places, gap = of[before], places[:, before], gap[:, of[before]]
        on_smaller = turned_back(turn[..., was], places + gap - offset[:, was])
        ends = (larger, places - gap), (smaller, on_smaller)
        was -= count
        return of[now], points, was, np.array([placed(pose[:, was], end) for pose, end in ends])
