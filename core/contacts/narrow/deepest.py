"""Which of many parts of two surfaces make their patch: the deepest ones, found by lower bounds on
their depths, so that most of the others need not be examined."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray, IntArray
from .frames import chunks
from .manifold import ROUGHNESS

MARGIN = 1.1
"""Factor by which parts are examined farther beyond the deepest one than `CoreContacts.within`."""

WITHIN = MARGIN * ROUGHNESS
"""Metres beyond the deepest part up to which others can count."""

_FIRST = 16
"""How many parts are examined before the deepest is known."""


def examine_deepest(
    group: IntArray,
    bound: FloatArray,
    least: FloatArray,
    within: FloatArray,
    examine: Callable[[IntArray], tuple[IntArray, FloatArray]],
) -> None:
    """Hand the numbers of those parts (n,) to ``examine`` that may belong to the patch of their
    ``group`` (n,), some of each at a time, the lowest by ``bound`` first.

    Args:
        group: (n,) number of the patch that each could belong to, from 0.
        bound: (n,) lower bounds on the signed distances of the parts [m].
        least: (n,) distance below which they count as this far apart [m].
        within: (n,) farthest beyond the deepest part of its group at which each counts [m].
        examine: returns numbers of parts that are valid, and their distances [m].
    """
    found = np.full(int(group.max(initial=-1)) + 1, np.inf)
    waiting = np.lexsort((bound, group))
    rank = np.arange(len(waiting)) - np.searchsorted(group[waiting], group[waiting])
    many = _FIRST
    while len(waiting):
        limit = np.maximum(found[group[waiting]], least[waiting]) + within[waiting]
        counts = bound[waiting] <= limit
        asked = counts & ((rank < many) | np.isfinite(limit))
        for part in chunks(int(asked.sum())):
            valid, distance = examine(waiting[asked][part])
            np.minimum.at(found, group[valid], distance)
        waiting = waiting[counts & ~asked]
        rank = rank[counts & ~asked]
        many = 4 * many
