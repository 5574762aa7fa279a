"""Upper bounds on sums over paths: sums over all walks to the listeners.

A walk takes steps like a path but may cross a contact again (though not turn round at once), so the sum over all walks from an entry is an
upper bound on the sum over all continuations of a path from there. It solves the linear equations ``S = R + W S``, where R holds the gains
of ending at once and W, the walk operator, those of a step. The series converges where the spectral radius of W is below 1; then the rest
after any number of terms is bounded by Collatz and Wielandt: if ``W d <= q d`` element by element with q < 1, the terms after d sum to at
most ``d q / (1 - q)`` (R. S. Varga, *Matrix Iterative Analysis*, Springer 2000, theorem 2.2). Where it diverges, a path still crosses each
contact at most once, which bounds the number of terms.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from ..connections import LARGEST
from .search_graph import SearchGraph

TERMS = 400
"""Most terms of the series; after them it is taken to diverge."""

SETTLED = 8
"""Terms before the ratio of consecutive ones is used."""

GROWING = 20
"""A series whose terms grow this many times in a row is taken to diverge."""

MEANINGLESS = 1e4
"""Bounds this many times above the strongest path are no use for ranking."""

FEW = 8
"""Contacts of the walks among which the strongest is searched."""

KEPT = 64
"""Most partial sums held, for paths that may cross only few contacts more."""


class WalkBounds:
    """Upper bounds on the continuations from each entry (`walk_sums`) and the strongest continuation, computed on first use.

    ``crossings``: most contacts on a path; ``whole`` False where the search graph is only a part, so that nothing bounds the rest.
    """

    def __init__(self, search_graph: SearchGraph, crossings: float, whole: bool = True) -> None:
        self._search_graph = search_graph
        self._crossings = min(crossings, len(set(search_graph.contact.tolist()) - {-1}))
        self._whole = whole

    @cached_property
    def _sums(self) -> FloatArray:
        return walk_sums(self._search_graph, int(self._crossings)) if self._whole else np.full((1, *self.strongest.shape), LARGEST)

    def sums(self, level: int) -> FloatArray:
        """(e, l) for paths that have crossed ``level`` contacts. A path crosses each contact once, so only the others are left."""
        return np.asarray(self._sums[min(int(self._crossings) - level, len(self._sums) - 1)])

    @cached_property
    def strongest(self) -> FloatArray:
        """(e, l) largest gain of any walk over a few contacts from each entry to each listener."""
        strongest = _ends(self._search_graph)
        for _ in range(min(int(self._crossings), FEW)):
            better = np.minimum(np.maximum(strongest, _step(self._search_graph, strongest, np.maximum)), LARGEST)
            if np.array_equal(better, strongest):
                break
            strongest = better
        return strongest

    def importance(self, level: int) -> FloatArray:
        """(e, l) rank of paths that have crossed ``level`` contacts: the bounds, or where they are no use the strongest continuation."""
        sums, strongest = self.sums(level), self.strongest
        return strongest if np.any(sums[-1] > MEANINGLESS * strongest[-1]) else sums


def walk_sums(search_graph: SearchGraph, crossings: int) -> FloatArray:
    """(k, e, l) bounds on the sum over all continuations from each entry to each listener with at most 0, 1, ... ``crossings`` contacts;
    the last one holds for any number. `LARGEST` where nothing bounds it."""
    term = _ends(search_graph)
    sums = [term]
    growing = 0
    for k in range(crossings):
        following = _step(search_graph, term, np.add)
        if not following.any():
            break
        growing = growing + 1 if following.sum() > term.sum() else 0
        if crossings > KEPT:
            ratio = _ratio(term, following)
            if ratio < 1 and k >= SETTLED and np.all(following <= 1e-4 * sums[-1] + 1e-300):
                return np.minimum(sums[-1] + following / (1 - ratio), LARGEST)[None]
            if k >= TERMS or growing > GROWING:
                return np.full((1, *term.shape), LARGEST)
        term = np.minimum(following, LARGEST)
        total = np.minimum(sums[-1] + term, LARGEST)
        sums = [*sums, total] if crossings <= KEPT else [total]
    return np.stack(sums)


def _ends(search_graph: SearchGraph) -> FloatArray:
    """(e, l) gain of ending at once."""
    ends = np.zeros((len(search_graph.nodes), search_graph.listeners))
    ends[np.repeat(np.arange(len(ends)), np.diff(search_graph.ends.start)), search_graph.ends.to] = np.minimum(
        search_graph.ends.weight[:, 0], LARGEST
    )
    return ends


def _step(search_graph: SearchGraph, values: FloatArray, together: np.ufunc) -> FloatArray:
    """Values (e, l) one step earlier: over all steps, combined by ``together`` (sum or maximum)."""
    result = np.zeros_like(values)
    rows = search_graph.steps
    filled = np.flatnonzero(np.diff(rows.start))
    if len(filled):
        with np.errstate(over="ignore"):
            products = np.minimum(rows.weight[:, :1], LARGEST) * values[rows.to]
            result[filled] = together.reduceat(products, rows.start[:-1][filled], axis=0)
    return result


def _ratio(term: FloatArray, following: FloatArray) -> float:
    """The smallest q with ``following <= q term``."""
    if np.any((term == 0) & (following > 0)):
        return float("inf")
    positive = term > 0
    return float(np.max(following[positive] / term[positive], initial=0.0)) * (1 + 1e-12)
