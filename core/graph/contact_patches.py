"""Contact patches: the contacts that are points of one patch, and the graph with each patch as a single contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, IntArray, added_by, runs
from .haptic_graph import HapticGraph


def contact_patches(graph: HapticGraph) -> IntArray:
    """Patch number of each contact (c,).

    Contacts of one pair of objects with a share below 1 are points of one patch. A path crosses a patch once, by one of its points: so the
    weight of a patch does not depend on its number of points. If points were separate contacts, there would be additional paths in through
    one point and out through another, and refining a patch would increase the sum.
    """
    patch = np.arange(graph.contact_count)
    first_nodes = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    points = first_nodes[graph.share[graph.contact[first_nodes]] < 1]
    if len(points):
        pair = np.column_stack([graph.node_object[points], graph.node_object[graph.partner[points]]])
        _, first, which = np.unique(pair, axis=0, return_index=True, return_inverse=True)
        patch[graph.contact[points]] = graph.contact[points[first]][which.reshape(-1)]
    return patch


@dataclass(frozen=True, slots=True)
class MergedPatches:
    """A graph whose patches are one contact each, at the share-weighted centre of their points.

    Attributes:
        graph: the graph with merged patches; the given graph itself if no patch has several points.
        node: (m,) of each of its nodes: the node of the given graph that it represents, for a patch that of its largest point.
        merged: (n,) of each node of the given graph: its node in ``graph``.
    """

    graph: HapticGraph
    node: IntArray
    merged: IntArray

    def unmerged(self, paths: Mapping[tuple[int, int], tuple[int, ...]]) -> Mapping[tuple[int, int], tuple[int, ...]]:
        """Paths through ``graph`` as nodes of the given graph."""
        if self.graph.node_count == len(self.merged):
            return paths
        return {pair: tuple(self.node[list(nodes)].tolist()) for pair, nodes in paths.items()}


def merge_patches(graph: HapticGraph) -> MergedPatches:
    """The graph with each patch as a single contact: positions, transmission gains, band gains and delays are share-weighted means."""
    if np.all(graph.share == 1):
        numbers = np.arange(graph.node_count)
        return MergedPatches(graph, numbers, numbers)
    means = _PatchMeans(graph)
    nodes = nodes_of_contacts(graph)
    crossed = nodes.reshape(-1)
    stands_for = np.arange(graph.node_count)
    stands_for[crossed] = nodes[means.largest].reshape(-1)
    node = np.unique(stands_for)
    number = np.full(graph.node_count, -1, dtype=np.int64)
    number[node] = np.arange(len(node))
    position = graph.node_position.copy()
    for side in (0, 1):
        position[nodes[:, side]] = means.of(graph.node_position[nodes[:, side]])
    kept = np.unique(means.largest)
    transmission = means.of(graph.transmission)[kept]
    with np.errstate(divide="ignore"):
        loss = np.where(means.single[kept], graph.transmission_loss[kept], -np.log(transmission))
    inside = graph.contact[node] < 0
    merged = replace(
        graph,
        start=np.searchsorted(graph.node_object[node], np.arange(len(graph.start))),
        node_object=graph.node_object[node],
        node_kind=graph.node_kind[node],
        node_position=position.T.take(node, axis=1).T,  # each coordinate contiguous
        partner=np.where(inside, -1, number[graph.partner[node]]),
        contact=np.where(inside, -1, np.searchsorted(kept, graph.contact[node])),
        transmission=transmission,
        transmission_loss=loss,
        weight=means.of(graph.weight)[kept],
        share=np.ones(len(kept)),
        contact_band_gains=None if graph.contact_band_gains is None else means.of(graph.contact_band_gains)[kept],
        contact_delay=None if graph.contact_delay is None else means.of(graph.contact_delay)[kept],
        sources=tuple(replace(source, nodes=tuple(number[list(source.nodes)].tolist())) for source in graph.sources),
        listener_nodes=number[graph.listener_nodes],
        reach=None if graph.reach is None else graph.reach[node],
    )
    return MergedPatches(merged, node, number[stands_for])


def nodes_of_contacts(graph: HapticGraph) -> IntArray:
    """The two nodes of each contact (c, 2), that of the lower number first."""
    first = np.flatnonzero(graph.partner > np.arange(graph.node_count))
    nodes = np.empty((graph.contact_count, 2), dtype=np.int64)
    nodes[graph.contact[first]] = np.column_stack([first, graph.partner[first]])
    return nodes


class _PatchMeans:
    """Share-weighted means over patches.

    ``largest`` (c,): the contact with the largest share of each contact's patch; ``single`` (c,): whether it is the only one.
    """

    def __init__(self, graph: HapticGraph) -> None:
        self._patch = contact_patches(graph)
        count = graph.contact_count
        order = np.lexsort((-graph.share, self._patch))
        first, _ = runs(self._patch[order])
        of_patch = np.zeros(count, dtype=np.int64)
        of_patch[self._patch[order[first]]] = order[first]
        self.largest: IntArray = of_patch[self._patch]
        self.single = np.bincount(self._patch, minlength=count)[self._patch] == 1
        share = np.maximum(graph.share, np.finfo(np.float64).tiny)  # points with share 0 also have a centre
        self._weight = share / np.bincount(self._patch, weights=share, minlength=count)[self._patch]

    def of(self, values: FloatArray) -> FloatArray:
        """The mean of ``values`` (c, ...) over the patch of each contact; unchanged if the patch has one point."""
        columns = values.reshape(len(values), -1)
        means = added_by(self._patch, self._weight * columns.T, len(values))[:, self._patch].T
        return np.where(self.single[:, None], columns, means).reshape(values.shape)
