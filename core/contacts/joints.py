"""Contacts across joints: found once, at rest, they stay at the pivot while the joint holds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import IntArray, chosen_of
from ..scene.joint import Joint
from .body_poses import BodyPoses
from .body_table import BodyTable
from .candidates import Candidates, placed
from .contact_set import ContactSet
from .narrow.body_patches import PairPatches
from .narrow.frames import dot, turned
from .settings import Body
from .shapes import rotation_matrix


class Joints:
    """The ``joints`` between ``bodies`` of a ``table`` that touch at rest, within at most
    ``tolerance`` [m], and whose bounds both reach to the pivot."""

    def __init__(
        self, table: BodyTable, bodies: Sequence[Body], joints: Sequence[Joint], tolerance: float
    ) -> None:
        self._table, self._tolerance = table, tolerance
        number = {body.name: k for k, body in enumerate(bodies)} if joints else {}
        found: dict[int, tuple[Joint, list[int]]] = {}
        for joint in joints:
            if number.keys() >= set(joint.objects):
                pair = [number[name] for name in joint.objects]
                found[int(table.keys(np.sort(pair)))] = joint, pair
        key = np.array(sorted(found), dtype=np.int64)
        self._contacts: Candidates = Candidates.of(key, *table.by_size(key))
        self._pivots = np.zeros((2, 3, len(key)))
        if len(key):
            self._find([found[k] for k in key.tolist()])

    def _find(self, joints: Sequence[tuple[Joint, list[int]]]) -> None:
        """Find the contacts at rest of joints between bodies of these numbers."""
        table, contacts = self._table, self._contacts
        bodies = np.array([contacts.larger, contacts.smaller]).T
        swapped = np.array([pair[0] for _, pair in joints]) != bodies[:, 0]
        pivots = np.array([joint.positions for joint, _ in joints], dtype=np.float64)
        pivots[swapped] = pivots[swapped, ::-1]
        rotation = np.array([joint.rotation for joint, _ in joints], dtype=np.float64)
        turn = rotation_matrix(rotation / np.linalg.norm(rotation, axis=1, keepdims=True))
        turn = np.where(swapped[:, None, None], turn.transpose(0, 2, 1), turn).transpose(1, 2, 0)
        self._pivots = pivots.transpose(1, 2, 0)
        offset = self._pivots[0] - turned(turn, self._pivots[1])
        limit = table.tolerance(bodies[:, 0], bodies[:, 1], self._tolerance)
        patch = table.narrow.query(bodies, turn, offset, limit)
        beyond = np.abs(self._pivots - table.middle[:, bodies.T].transpose(1, 0, 2))
        beyond -= table.extent[:, bodies.T].transpose(1, 0, 2)
        there = (patch.distance <= limit) & (beyond <= limit).all(axis=(0, 1))
        place = turned(turn, table.middle[:, bodies[:, 1]]) + offset
        at_pivot = PairPatches(patch.distance, patch.normal, self._pivots[0], patch.area)
        contacts.store(np.arange(len(bodies)), turn, offset, place, at_pivot)
        rows = there.nonzero()[0]
        self._contacts, self._pivots = chosen_of(contacts, rows), self._pivots[..., rows]

    def holding(self, poses: BodyPoses) -> IntArray:
        """The pairs (k,), by key, ascending, whose pivot is the same point of both in ``poses``."""
        contacts = self._contacts
        if not len(contacts.key):
            return contacts.key
        bodies = contacts.larger, contacts.smaller
        ends = [
            placed(poses.pose[:, k], pivot) for k, pivot in zip(bodies, self._pivots, strict=True)
        ]
        way = ends[1] - ends[0]
        limit = self._table.tolerance(contacts.larger, contacts.smaller, self._tolerance)
        return contacts.key[dot(way, way) <= limit**2]

    def contacts(self, key: IntArray, poses: BodyPoses) -> ContactSet:
        """The contacts of pairs (k,) with a joint, by key."""
        rows = self._contacts.rows_of(key)
        return self._contacts.contacts(rows, self._table, poses, self._tolerance)
