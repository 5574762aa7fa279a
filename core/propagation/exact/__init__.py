"""Sums over all paths: exact, to a tolerance, or within limits. The entry point is `sum_over_paths`."""

from __future__ import annotations

from collections.abc import Sequence

from ...graph.haptic_graph import HapticGraph
from .bridge_tree_sums import bridge_tree_sums
from .path_sums import PathLimits, PathSums
from .threshold_sums import ThresholdCosts, threshold_costs, threshold_sums

__all__ = ["PathLimits", "PathSums", "ThresholdCosts", "sum_over_paths", "threshold_costs"]


def sum_over_paths(
    graph: HapticGraph,
    roots: Sequence[int],
    listeners: Sequence[int],
    limits: PathLimits,
    known: tuple[ThresholdCosts, int] | None = None,
    recrossings: bool = False,
) -> PathSums:
    """Sum of the products of gains over the paths from the nodes ``roots`` of a source to each of the nodes ``listeners``.

    With a threshold, whether a path counts depends on its own gain, so paths are searched one by one, as arrays (`threshold_sums`). Without
    one, the sum factorises over the bridges of the contacts, and inside a component it is found without enumeration (`bridge_tree_sums`).
    The result is exact, or an interval: a lower bound that was summed, and a bound on the rest.

    Args:
        known: costs up to the threshold and the source's row in them; None if some gain exceeds 1.
        recrossings: whether the result includes the walks that were stopped because they cross a patch twice.
    """
    if limits.threshold > 0:
        return threshold_sums(graph, roots, listeners, limits, known, recrossings)
    return bridge_tree_sums(graph, roots, listeners, limits)
