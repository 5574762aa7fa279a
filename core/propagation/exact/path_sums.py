"""Limits and results of sums over paths."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Limits of the paths, and required accuracy of the sum.

    Attributes:
        crossings: most contacts on a path.
        threshold: least gain of a path.
        tolerance: relative error requested if the exact sum exceeds the budget.
        budget: most work: partial paths, states and transitions.
    """

    crossings: float
    threshold: float
    tolerance: float
    budget: int


@dataclass(slots=True)
class PathSums:
    """Sums of one source.

    Attributes:
        gain: (l, lanes) of each listener: the plain gain, then that of each band if bands are used.
        error: (l,) the true plain gain lies in ``[gain, gain + error]``; `LARGEST` without a bound.
        paths: (l,) number of paths summed, -1 if they were not counted.
        work: work done.
        recrossings: last entries (nodes) and gains of the walks that were not continued because they cross a patch twice; None if not
        requested or unknown.
    """

    gain: FloatArray
    error: FloatArray
    paths: IntArray
    work: int
    recrossings: tuple[IntArray, FloatArray] | None = None
