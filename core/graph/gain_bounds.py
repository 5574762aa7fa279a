"""Upper bounds on gains, with which contact detection skips objects that no signal can reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.gain_bound import GainBound
from ..scene.functions import ModulationFunction
from ..scene.values import Mode, Settings, Strategy
from .distance_only import DISTANCE_ONLY
from .haptic_graph import ObjectTable

_FAR = 1e6
"""Distance [m] up to which a designer's formula is bounded."""


def _balances_energy(settings: Settings) -> bool:
    return settings.strategy is Strategy.ENERGY_BALANCE and settings.mode is not Mode.SD


def object_bounds(table: ObjectTable, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Factor and decay (n,) such that no gain of an object over d metres exceeds ``factor * exp(-decay * d)``.

    1 and 0 for the energy balance, which is not a product of gains along a path.
    """
    count = len(table.names)
    if settings.mode is Mode.SD:
        return np.ones(count), np.full(count, DISTANCE_ONLY.alpha)
    if _balances_energy(settings):
        return np.ones(count), np.zeros(count)
    factor, decay = table.factor.copy(), table.decay.copy()
    for index in table.special:
        factor[index], decay[index] = table.gain_bounds(index, _FAR)[1], 0.0
    return factor, decay


def signal_gain_bound(
    bounds: tuple[FloatArray, FloatArray],
    bodies: IntArray,
    positions: FloatArray,
    settings: Settings,
    transmissions: Sequence[ModulationFunction] = (),
    impacts: bool = True,
) -> GainBound:
    """The gain bound of signals from the given sources.

    Args:
        bounds: factor and decay of each body, as from `object_bounds`.
        bodies: (k,) numbers of the bodies that sources are on.
        positions: (k, 3) places of the sources [m, world].
        settings: mode, strategy and threshold.
        transmissions: functions that contacts may have; without any, the identity.
        impacts: whether impacts of the frame make sources.
    """
    if settings.mode not in (Mode.HT, Mode.SD):
        bodies, positions, impacts = bodies[:0], positions[:0], False
    most = [np.inf if f.name == "expression" else f.bounds(0.0, 0.0, 1.0, settings.epsilon)[1] for f in transmissions]
    return GainBound(
        bodies=bodies,
        positions=positions,
        strengths=np.ones(len(bodies)),
        factor=bounds[0],
        decay=bounds[1],
        threshold=0.0 if _balances_energy(settings) else settings.threshold,
        transmission=max(most, default=1.0),
        from_impacts=impacts,
    )
