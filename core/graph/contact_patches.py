"""Contact patches: which contacts of the graph are points of one patch."""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from .haptic_graph import HapticGraph


def contact_patches(graph: HapticGraph) -> IntArray:
    """Patch number of each contact (c,).

    Contacts of one pair of objects with a share below 1 are points of one patch. A path crosses a patch once, by one of its points: then a
    patch weighs the same however many points it is refined to. Crossed like separate contacts, its points would add paths that go in by one
    point and out by another, and refining a patch would add to the sum.
    """
    patch = np.arange(graph.contact_count)
    first_nodes = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    points = first_nodes[graph.share[graph.contact[first_nodes]] < 1]
    if len(points):
        pair = np.column_stack([graph.node_object[points], graph.node_object[graph.partner[points]]])
        _, first, which = np.unique(pair, axis=0, return_index=True, return_inverse=True)
        patch[graph.contact[points]] = graph.contact[points[first]][which.reshape(-1)]
    return patch
