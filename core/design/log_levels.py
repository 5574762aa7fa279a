"""Levels at listeners along the best paths, and their derivatives with respect to material parameters.

The gain of a path is a product, so its logarithm is a sum over the connections, and the derivative by a value of an object is the sum of
closed forms over the connections inside that object.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from ..graph.haptic_graph import HapticGraph, ObjectTable
from ..propagation import propagate
from ..scene.bands import BAND_COUNT
from ..scene.choices import Mode, Strategy
from ..scene.coefficients import coefficients_of, transfer_coefficient
from ..scene.values import Settings


@dataclass(frozen=True, slots=True)
class LogLevels:
    """``level`` (l,): half the logarithm of the energy that arrives at each listener over the best path of each source, minus infinity if
    none does; ``slope`` (l, o): its derivative by ln K of each object."""

    level: FloatArray
    slope: FloatArray


def log_levels(graph: HapticGraph, settings: Settings, energies: FloatArray) -> LogLevels:
    """The levels on a graph. ``energies`` (s, bands): squared amplitudes of each source by frequency band."""
    found = propagate(graph, replace(settings, mode=Mode.HT, strategy=Strategy.AUTO, threshold=0.0, localise=0.0))
    total = np.zeros(len(graph.listeners))
    weighted = np.zeros((len(graph.listeners), len(graph.table.names)))
    for (row, column), path in found.best_path.items():
        gain = np.full(BAND_COUNT, found.gain[row, column]) if found.band_gain is None else found.band_gain[row, column]
        energy = energies[row] * gain**2
        total[column] += energy.sum()
        for a, b in pairwise(path):
            if graph.partner[a] != b:
                item = graph.table.objects[int(graph.node_object[a])]
                distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
                slopes = item.propagation.slopes(distance, item.kappa, item.rho, graph.table.epsilon)
                weighted[column, graph.node_object[a]] += energy @ slopes
    with np.errstate(divide="ignore"):
        level = np.log(total) / 2
    return LogLevels(level, weighted / np.where(total > 0, total, 1.0)[:, None])


def with_changed_k(graph: HapticGraph, groups: Sequence[Sequence[int]], change: FloatArray) -> HapticGraph:
    """The graph whose objects of each group (numbers) have their ln K raised by ``change`` (f,)."""
    objects = list(graph.table.objects)
    for numbers, rise in zip(groups, change.tolist(), strict=True):
        for number in numbers:
            item = objects[number]
            kappa, rho = coefficients_of(transfer_coefficient(item.kappa, item.rho) * math.exp(rise), item.rho)
            objects[number] = replace(item, kappa=kappa, rho=rho)
    return replace(graph, table=ObjectTable.of(objects, graph.table.epsilon))
