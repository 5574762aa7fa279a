"""What a sum over paths is asked for, and what it returns."""

from __future__ import annotations

from dataclasses import dataclass

from ...arrays import FloatArray, IntArray
from ...graph.haptic_graph import HapticGraph
from ...scene.bands import BAND_COUNT


@dataclass(frozen=True, slots=True)
class PathLimits:
    """Which paths count, and how well the sum has to be known.

    Attributes:
        crossings: most contacts on a path.
        threshold: least gain of a path.
        tolerance: relative error wanted where the exact sum takes more than the budget.
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
        gain: (l, lanes) of each listener: the plain gain, then that of each band where bands are used.
        error: (l,) the true plain gain lies in ``[gain, gain + error]``; `LARGEST` where nothing bounds it.
        paths: (l,) number of paths summed, -1 where they were not counted.
        work: work done.
        recrossings: last entries (nodes) and gains of the walks that were not continued because they cross a patch twice; None where these
            were not asked for or are not known.
    """

    gain: FloatArray
    error: FloatArray
    paths: IntArray
    work: int
    recrossings: tuple[IntArray, FloatArray] | None = None


def lanes_of(graph: HapticGraph) -> int:
    """Number of gains per pair: 1, or 1 and one per band where bands are used."""
    return 1 + BAND_COUNT if graph.uses_bands else 1
