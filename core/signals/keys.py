"""Removal of redundant keys of piecewise linear curves."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray

RARE = 200
"""Thinning ends after two passes in a row that each remove fewer than one key in ``RARE``."""


def needed_keys(
    times: FloatArray, values: FloatArray, tolerance: FloatArray, run: IntArray | None = None
) -> IntArray:
    """Indices of the keys that remain when redundant ones are removed: those within ``tolerance``
    of the line between their neighbours.

    Every second key is tested at a time. The first and the last of each ``run`` stay; None: one
    run.
    """
    kept = np.arange(len(times))
    inside = np.zeros(len(times), dtype=np.bool_)
    inside[1:-1] = True if run is None else (run[1:-1] == run[:-2]) & (run[1:-1] == run[2:])
    idle = 0
    for turn in range(2 * len(times).bit_length()):
        if len(kept) < 3 or idle == 2:
            break
        at = times[kept]
        level = values[kept]
        left, here, right = (slice(turn % 2 + k, len(kept) - 2 + k, 2) for k in range(3))
        width = at[right] - at[left]
        share = np.divide(at[here] - at[left], width, out=np.zeros(len(width)), where=width > 0)
        off = np.abs(level[left] + share * (level[right] - level[left]) - level[here])
        redundant = (off <= tolerance[kept[here]]) & inside[kept[here]]
        idle = idle + 1 if np.count_nonzero(redundant) < len(kept) // RARE else 0
        stays = np.ones(len(kept), dtype=np.bool_)
        stays[here] = ~redundant
        kept = kept[stays]
    return kept
