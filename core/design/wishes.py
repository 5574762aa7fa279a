"""Material values that give listeners the desired levels, and the levels along the best paths with
their derivatives.

The gain of a path is a product, so its logarithm is a sum over the connections, and the derivative
by a value of an object is the sum of closed forms over the connections inside that object.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from ..frozen import frozen
from ..graph.haptic_graph import HapticGraph, ObjectTable
from ..least_squares import bounded_least_squares
from ..propagation import propagate
from ..scene.bands import BAND_COUNT
from ..scene.choices import Mode, Strategy
from ..scene.coefficients import coefficients_of, transfer_coefficient
from ..scene.values import Settings

DECIBELS = 20 / np.log(10)
"""Decibels per neper."""

_ROUNDS = 60
_SOFTNESS = 1e-6
"""Regularisation: weight of a material's change relative to a deviation from a wish, so that the
smallest of several solutions is taken."""
_FIRST_STEP, _LAST_STEP = 0.5, 1e-6
"""Largest change of ln K in the first step, and that at which the search ends."""


@frozen
class FreeMaterial:
    """Objects that change together, by name, all with the same K = (1 - kappa) rho, which may lie
    from ``least`` to ``most``, in (0, 1]."""

    objects: tuple[str, ...]
    least: float = 0.01
    most: float = 0.99


@frozen
class Wish:
    """A listener, and the desired change of its level [dB]."""

    listener: str
    change: float


@frozen
class Answer:
    """``k``: the new K of each free material. ``changes``: the resulting change of the level of
    each wish's listener [dB]; NaN if nothing arrives."""

    k: tuple[float, ...]
    changes: tuple[float, ...]


def fulfil(
    graph: HapticGraph,
    settings: Settings,
    energies: FloatArray,
    wishes: Sequence[Wish],
    free: Sequence[FreeMaterial],
) -> Answer:
    """The values of free materials that change the levels as wished, or as closely as their bounds
    and paths allow (least squares).

    Gauss-Newton steps within a trust region, which shrinks if a step fails because other paths
    become the best ones.

    Args:
        graph: the scene.
        settings: of propagation.
        energies: as for `log_levels`.
        wishes: the levels that are wished for.
        free: materials that may change, with their bounds.
    """
    index = graph.table.index()
    groups = [[index[name] for name in material.objects] for material in free]
    objects = [graph.table.objects[numbers[0]] for numbers in groups]
    start = np.log([max(transfer_coefficient(item.kappa, item.rho), 1e-9) for item in objects])
    low = np.log([m.least for m in free]) - start
    high = np.log([m.most for m in free]) - start
    columns = [graph.listeners.index(wish.listener) for wish in wishes]
    wished = np.array([wish.change for wish in wishes]) / DECIBELS
    before = log_levels(graph, settings, energies).level[columns]
    arrives = np.isfinite(before)
    change = np.clip(0.0, low, high)

    def at(change: FloatArray) -> tuple[LogLevels, FloatArray]:
        found = log_levels(with_changed_k(graph, groups, change), settings, energies)
        with np.errstate(invalid="ignore"):
            return found, np.where(arrives, wished - (found.level[columns] - before), 0.0)

    found, missing = at(change)
    region = _FIRST_STEP
    for _ in range(_ROUNDS):
        slope = np.stack(
            [found.slope[columns][:, numbers].sum(axis=1) for numbers in groups], axis=1
        )
        step = bounded_least_squares(
            slope,
            missing,
            np.maximum(low - change, -region),
            np.minimum(high - change, region),
            _SOFTNESS,
        )
        tried, left = at(change + step)
        if left @ left < missing @ missing:
            change = change + step
            found = tried
            missing = left
            region = 2 * region
        else:
            region = float(np.abs(step).max(initial=0.0)) / 4
        if region < _LAST_STEP or np.abs(missing).max(initial=0.0) < _LAST_STEP:
            break
    reached = np.where(arrives, (wished - missing) * DECIBELS, np.nan)
    return Answer(tuple(np.exp(start + change).tolist()), tuple(reached.tolist()))


@frozen
class LogLevels:
    """``level`` (l,): half the logarithm of the energy that arrives at each listener over the best
    path of each source, minus infinity if none does; ``slope`` (l, o): its derivative by ln K of
    each object."""

    level: FloatArray
    slope: FloatArray


def log_levels(graph: HapticGraph, settings: Settings, energies: FloatArray) -> LogLevels:
    """The levels on a graph. ``energies`` (s, bands): squared amplitudes of each source by
    frequency band."""
    found = propagate(
        graph, replace(settings, mode=Mode.HT, strategy=Strategy.AUTO, threshold=0.0, localise=0.0)
    )
    total = np.zeros(len(graph.listeners))
    weighted = np.zeros((len(graph.listeners), len(graph.table.names)))
    for (row, column), path in found.best_path.items():
        gain = (
            np.full(BAND_COUNT, found.gain[row, column])
            if found.band_gain is None
            else found.band_gain[row, column]
        )
        energy = energies[row] * gain**2
        total[column] += energy.sum()
        for a, b in pairwise(path):
            if graph.partner[a] != b:
                item = graph.table.objects[int(graph.node_object[a])]
                distance = float(graph.node_distances(np.array([a]), np.array([b]))[0])
                slopes = item.propagation.slopes(
                    distance, item.kappa, item.rho, graph.table.epsilon
                )
                weighted[column, graph.node_object[a]] += energy @ slopes
    with np.errstate(divide="ignore"):
        level = np.log(total) / 2
    return LogLevels(level, weighted / np.where(total > 0, total, 1.0)[:, None])


def with_changed_k(
    graph: HapticGraph, groups: Sequence[Sequence[int]], change: FloatArray
) -> HapticGraph:
    """The graph whose objects of each group (numbers) have their ln K raised by ``change`` (f,)."""
    objects = list(graph.table.objects)
    for numbers, rise in zip(groups, change.tolist(), strict=True):
        for number in numbers:
            item = objects[number]
            kappa, rho = coefficients_of(
                transfer_coefficient(item.kappa, item.rho) * math.exp(rise), item.rho
            )
            objects[number] = replace(item, kappa=kappa, rho=rho)
    return replace(graph, table=ObjectTable.of(objects, graph.table.epsilon))
