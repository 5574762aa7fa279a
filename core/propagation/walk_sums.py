"""Upper bounds of what is left: sums over all walks to the listeners.

A walk takes steps like a path but may cross a patch again (though not turn round at once), so the sum over all walks from an entry is an
upper bound of the sum over all ways in which a path can go on from there. It solves the linear equations ``S = R + W S``, where R holds the
gains of ending at once and W those of a step. The series converges where the spectral radius of W is below 1; then the rest after any
number of terms is bounded by Collatz and Wielandt: if ``W d <= q d`` element by element with q < 1, the terms after d sum to at most
``d q / (1 - q)`` (R. S. Varga, *Matrix Iterative Analysis*, Springer 2000, theorem 2.2). Where it does not converge, a path still crosses
each patch at most once, which bounds the number of terms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .arena import Arena

FloatArray = NDArray[np.float64]

LARGEST = 1e300
"""Sums above this are given as this."""

TERMS = 400
"""Terms of the series summed before it is taken to diverge."""

SETTLED = 8
"""Terms after which their ratio is worth trusting."""

KEPT = 64
"""So many partial sums are kept, to bound paths that may cross only so many contacts more."""


def walk_sums(arena: Arena, crossings: float) -> FloatArray:
    """(k, e, l): bounds of the sum over all continuations from each entry to each listener with at most 0, 1, ... contacts; the last one
    holds for any larger number up to ``crossings``. `LARGEST` where there is no bound."""
    count = len(arena.nodes)
    term = np.zeros((count, arena.listeners))
    np.add.at(term, (np.repeat(np.arange(count), np.diff(arena.ends.start)), arena.ends.to), arena.ends.weight[:, 0])
    most = min(crossings, arena.patches)
    sums = [term]
    k = 0
    while k < most:
        following = _step(arena, term)
        if not following.any():
            break
        ratio = _ratio(term, following)
        if crossings > KEPT and ratio < 1 and k >= SETTLED and np.all(following <= 1e-4 * sums[-1] + 1e-300):
            return np.minimum(sums[-1] + following / (1 - ratio), LARGEST)[None]
        if k >= TERMS:
            return np.full((1, count, arena.listeners), LARGEST)
        term = np.minimum(following, LARGEST)
        total = np.minimum(sums[-1] + term, LARGEST)
        sums = [*sums, total] if most <= KEPT else [total]
        k += 1
    return np.stack(sums)


def _step(arena: Arena, values: FloatArray) -> FloatArray:
    """W applied to values (e, l)."""
    result = np.zeros_like(values)
    rows = arena.steps
    filled = np.flatnonzero(np.diff(rows.start))
    if len(filled):
        with np.errstate(over="ignore"):
            products = rows.weight[:, :1] * values[rows.to]
        result[filled] = np.add.reduceat(products, rows.start[:-1][filled], axis=0)
    return result


def _ratio(term: FloatArray, following: FloatArray) -> float:
    """The smallest q with ``following <= q term``."""
    if np.any((term == 0) & (following > 0)):
        return float("inf")
    positive = term > 0
    return float(np.max(following[positive] / term[positive], initial=0.0)) * (1 + 1e-12)
