"""Removal of redundant keys of piecewise linear curves."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray

RARE = 200
"""Thinning ends after two passes in a row that each remove fewer than one key in ``RARE``."""


def needed_keys(times: FloatArray, values: FloatArray, tolerance: FloatArray, run: IntArray | None = None) -> IntArray:
    """Indices of the keys that remain when redundant ones are removed: those within ``tolerance`` of the line between their neighbours.

    Every second key is tested at a time. The first and the last of each ``run`` stay; None: one run.
    """
    kept = np.arange(len(times))
    inside = np.zeros(len(times), dtype=np.bool_)
    inside[1:-1] = True if run is None else (run[1:-1] == run[:-2]) & (run[1:-1] == run[2:])
    idle = 0
    for turn in range(2 * len(times).bit_length()):
        if len(kept) < 3 or idle == 2:
            break
        inner = np.arange(1 + turn % 2, len(kept) - 1, 2)
        inner = inner[inside[kept[inner]]]
        left, here, right = kept[inner - 1], kept[inner], kept[inner + 1]
        width = times[right] - times[left]
        share = np.divide(times[here] - times[left], width, out=np.zeros_like(width), where=width > 0)
        off = np.abs(values[left] + share * (values[right] - values[left]) - values[here])
        gone = inner[off <= tolerance[here]]
        idle = idle + 1 if len(gone) < len(kept) // RARE else 0
        kept = np.delete(kept, gone)
    return kept
