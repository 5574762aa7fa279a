"""Contacts between convex hulls whose surfaces are apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from .narrow.frames import relative_pose
from .narrow.narrow_phase import NarrowPhase
from .settings import Body
from .shapes import Shape


def contacts_through_air(
    bodies: Sequence[Body],
    transforms: FloatArray,
    pairs: IntArray,
    seen: Mapping[str, Shape],
    limit: float,
) -> int:
    """How many pairs of bodies are apart once their surfaces replace their hulls, media left out.

    Args:
        bodies: all of them.
        transforms: rigid ones that place them (n, 4, 4).
        pairs: numbers of the bodies that touch (p, 2).
        seen: shapes in place of those of the bodies with these names.
        limit: distance above which they are apart [m].
    """
    pairs = np.array(
        [
            pair
            for pair in np.unique(pairs, axis=0).tolist()
            if any(bodies[k].name in seen for k in pair)
        ],
        dtype=np.int64,
    )
    pairs = pairs.reshape(-1, 2)
    pairs = pairs[[not any(bodies[k].medium for k in pair) for pair in pairs.tolist()]]
    if len(pairs) == 0:
        return 0
    number, local = np.unique(pairs, return_inverse=True)
    narrow = NarrowPhase([seen.get(bodies[k].name, bodies[k].shape) for k in number.tolist()])
    poses = np.concatenate([transforms[:, :3, :3].reshape(-1, 9).T, transforms[:, :3, 3].T])
    placed = relative_pose(poses[:, pairs[:, 0]], poses[:, pairs[:, 1]])
    found = narrow.query(local.reshape(-1, 2), *placed, np.full(len(pairs), limit))
    return int((found.distance > limit).sum())
