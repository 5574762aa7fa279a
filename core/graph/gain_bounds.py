"""Where the signals of a frame can get to, as bounds that contact detection looks for contacts by."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.gain_bound import Reach
from ..scene.functions import ModulationFunction
from ..scene.values import Mode, Settings, Strategy
from .distance_only import DISTANCE_ONLY
from .haptic_graph import ObjectTable

_FAR = 1e6
"""Metres within which a designer's formula is bounded."""


def object_bounds(table: ObjectTable, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Factor and decay (n,) such that no gain of an object over d metres is more than ``factor * exp(-decay * d)``; all 1 and 0 where
    signals are not followed along paths."""
    count = len(table.names)
    if settings.mode is Mode.SD:
        return np.ones(count), np.full(count, DISTANCE_ONLY.alpha)
    if settings.strategy is Strategy.ENERGY_BALANCE:
        return np.ones(count), np.zeros(count)
    factor, decay = table.factor.copy(), table.decay.copy()
    for index in table.special:
        factor[index], decay[index] = table.gain_bounds(index, _FAR)[1], 0.0
    return factor, decay


def signal_reach(
    bounds: tuple[FloatArray, FloatArray],
    bodies: IntArray,
    positions: FloatArray,
    settings: Settings,
    transmission: ModulationFunction | None = None,
    impacts: bool = True,
) -> Reach:
    """What signals can reach that start at ``positions`` (k, 3) [m] on ``bodies`` (k,), of whose propagation ``bounds`` are known, and
    that ``impacts`` of the frame make. ``transmission`` of all contacts; None: identity."""
    if settings.mode not in (Mode.HT, Mode.SD):
        bodies, positions, impacts = bodies[:0], positions[:0], False
    passed = 1.0
    if transmission is not None:
        passed = np.inf if transmission.name == "expression" else transmission.bounds(0.0, 0.0, 1.0, settings.epsilon)[1]
    return Reach(
        bodies=bodies,
        positions=positions,
        strengths=np.ones(len(bodies)),
        factor=bounds[0],
        decay=bounds[1],
        threshold=0.0 if settings.strategy is Strategy.ENERGY_BALANCE else settings.threshold,
        transmission=passed,
        from_impacts=impacts,
    )
