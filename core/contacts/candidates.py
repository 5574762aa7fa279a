"""Pairs of bodies whose bounding boxes overlap in a frame, and what is known of their contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from .body_poses import BodyPoses
from .body_table import BodyTable
from .contact_set import ContactSet
from .narrow.body_patches import PairPatches
from .narrow.frames import dot, smooth_step, turned, turned_back

_MEET = 1e-4
"""Largest gap of pairs that meet [m]."""

_RESTING = 0.2
"""Part of the tolerance up to which a gap counts as that of bodies at rest."""

# Rows of `Candidates.values`, in the frame of the larger body unless said otherwise: centre of the
# smaller body's bounds, its rotation, the contact node on the larger body and (in the frame of the
# smaller body) that on the smaller one, normal from larger to smaller, distance, area.
_PLACE = slice(0, 3)
_TURN = slice(3, 12)
ON_LARGER = slice(12, 15)
_ON_SMALLER = slice(15, 18)
NORMAL = slice(18, 21)
DISTANCE, _AREA, _ROWS = 21, 22, 23


@dataclass(slots=True)
class Candidates:
    """The p pairs of bodies whose bounds overlap.

    Attributes:
        key: (p,) by `BodyTable.keys`, ascending.
        larger, smaller: (p,) numbers of the bodies, by their size.
        known: (p,) whether ``values`` are those of a query.
        touching: (p,) in contact.
        struck: (p,) no further impact until the pair parts.
        open: (p,) not found to meet since the bounds began to overlap, or since it parted.
        examined: (p,) whether the pair was queried, or found unmoved, in the last frame. Pairs that
            no signal can pass are not.
        version: (2, p) versions of the poses of the larger and of the smaller body at the query.
        values: (rows, p) result of the last query.
    """

    key: IntArray
    larger: IntArray
    smaller: IntArray
    known: BoolArray
    touching: BoolArray
    struck: BoolArray
    open: BoolArray
    examined: BoolArray
    version: IntArray
    values: FloatArray

    @classmethod
    def of(cls, key: IntArray, larger: IntArray, smaller: IntArray) -> Candidates:
        """Pairs without a query so far."""
        count = len(key)
        known, touching, struck = np.zeros((3, count), dtype=np.bool_)
        return cls(
            key,
            larger,
            smaller,
            known,
            touching,
            struck,
            open=np.ones(count, dtype=np.bool_),
            examined=np.ones(count, dtype=np.bool_),
            version=np.full((2, count), -1),
            values=np.zeros((_ROWS, count)),
        )

    def carried_to(self, key: IntArray, larger: IntArray, smaller: IntArray) -> Candidates:
        """The pairs ``key``; those that were candidates before keep their state."""
        if np.array_equal(key, self.key):
            return self
        if len(self.key) == 0 or len(key) == 0:
            return Candidates.of(key, larger, smaller)
        place = self.rows_of(key)
        here = self.key[place] == key
        return Candidates(
            key,
            larger,
            smaller,
            known=self.known[place] & here,
            touching=self.touching[place] & here,
            struck=self.struck[place] & here,
            open=self.open[place] | ~here,
            examined=self.examined[place] | ~here,
            version=self.version.take(place, axis=1),
            values=self.values.take(place, axis=1),
        )

    def rows_of(self, key: IntArray) -> IntArray:
        """Where pairs (k,) by key stand; of one that is no candidate, where another one does."""
        return np.minimum(self.key.searchsorted(key), len(self.key) - 1)

    @property
    def distance(self) -> FloatArray:
        """Signed distances (p,) at the last query [m]."""
        return np.asarray(self.values[DISTANCE])

    @property
    def meet(self) -> BoolArray:
        """Which pairs (p,) have no gap."""
        return self.distance <= _MEET

    def bodies(self, rows: IntArray) -> IntArray:
        """Numbers (k, 2) of the larger and the smaller bodies of some pairs."""
        return np.array([self.larger[rows], self.smaller[rows]]).T

    def one_of(self, bodies: BoolArray) -> BoolArray:
        """Which pairs (p,) have at least one of the ``bodies`` (n,)."""
        return np.asarray(bodies[self.larger] | bodies[self.smaller])

    def fresh(self, poses: BodyPoses) -> BoolArray:
        """Which pairs (p,) were queried in the current poses."""
        versions = np.array([poses.version[self.larger], poses.version[self.smaller]])
        return np.asarray(self.known & (self.version == versions).all(axis=0))

    def motion(
        self, rows: IntArray, turn: FloatArray, place: FloatArray, radius: FloatArray
    ) -> FloatArray:
        """An upper bound (k,) [m] on the motion, since the last query, of any point of the smaller
        body of each pair relative to the larger one.

        Args:
            rows: numbers of the pairs (k,).
            turn: rotations of the smaller bodies in the frames of the larger ones (3, 3, k).
            place: middles of their bounds there (3, k) [m].
            radius: of these bounds (k,) [m].
        """
        values = self.values[: ON_LARGER.start].take(rows, axis=1)
        travel = place - values[_PLACE]
        change = turn - values[_TURN].reshape(3, 3, -1)
        x, y, z = dot(change, change)
        turned_by = np.sqrt((x + y + z) / 2)
        return np.asarray(np.sqrt(dot(travel, travel)) + radius * turned_by)

    def store(
        self,
        rows: IntArray,
        turn: FloatArray,
        offset: FloatArray,
        place: FloatArray,
        found: PairPatches,
    ) -> None:
        """Store what a query has ``found`` of the pairs ``rows`` (k,), which were placed by
        ``turn``, ``offset`` and ``place``, as in `motion`."""
        values = np.empty((_ROWS, len(rows)))
        values[_PLACE] = place
        values[_TURN] = turn.reshape(9, -1)
        values[NORMAL] = found.normal
        values[DISTANCE], values[_AREA] = found.distance, found.area
        gap = found.normal * (found.distance / 2)
        values[ON_LARGER] = found.centre - gap
        values[_ON_SMALLER] = turned_back(turn, found.centre + gap - offset)
        self.values[:, rows] = values
        self.known[rows] = True

    def contacts(
        self, rows: IntArray, table: BodyTable, poses: BodyPoses, tolerance: float
    ) -> ContactSet:
        """Contacts of the pairs ``rows``, each at the centre of its patch, with weight up to a
        distance of at most ``tolerance`` [m]."""
        larger = self.larger[rows]
        smaller = self.smaller[rows]
        values = self.values.take(rows, axis=1)
        pose_l = poses.pose.take(larger, axis=1)
        pose_s = poses.pose.take(smaller, axis=1)
        normal = turned(pose_l[:9].reshape(3, 3, -1), values[NORMAL])
        ends = np.array([placed(pose_l, values[ON_LARGER]), placed(pose_s, values[_ON_SMALLER])])
        pairs = table.numbers(self.key[rows])
        flipped = larger != pairs[:, 0]
        normal *= np.where(flipped, -1.0, 1.0)
        first, second = np.where(flipped, ends[::-1], ends)
        distance = values[DISTANCE]
        return ContactSet(
            pairs=pairs,
            positions=np.ascontiguousarray(np.array([first, second]).transpose(2, 0, 1)),
            normal=np.ascontiguousarray(normal.T),
            depth=np.maximum(-distance, 0.0),
            distance=distance,
            area=values[_AREA],
            weight=_weights(distance, table.tolerance(larger, smaller, tolerance)),
            transmission=np.zeros(len(rows), dtype=np.int64),
        )


def _weights(distance: FloatArray, tolerance: FloatArray) -> FloatArray:
    """Weights of contacts by their ``distance`` (k,) [m]: 1 up to the gap of bodies at rest,
    falling smoothly to 0 at the ``tolerance`` (k,) [m]."""
    rest = _RESTING * tolerance
    return 1.0 - smooth_step((distance - rest) / np.maximum(tolerance - rest, 1e-300))


def placed(pose: FloatArray, points: FloatArray) -> FloatArray:
    """World positions (3, k) of points (3, k) of bodies in ``pose`` (12, k)."""
    return turned(pose[:9].reshape(3, 3, -1), points) + pose[9:]
