"""Which bodies are fast and heavy enough for an impact: only these are searched for hits."""

from __future__ import annotations

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from .body_table import BodyTable
from .known_motion import Samples
from .motion import MotionHistory, Paths
from .narrow.frames import dot
from .settings import ContactSettings, ImpactEnergy

_FRAMES_AHEAD = 3
"""Frames in which gravity may accelerate a body to an impact: its contacts are watched that long
before, requested or not."""


class Striking:
    """Bounds on the energies of impacts under ``settings``, of which ``least`` is the smallest that
    counts [J]; ``gravity`` (3,) in the scene's time [m/s^2]."""

    def __init__(self, settings: ContactSettings) -> None:
        self._settings = settings
        self.least = min(item.least_energy or 0.0 for item in settings.all_limits())
        self.gravity = np.array(settings.gravity) * settings.time_scale**2
        self._weight = float(np.linalg.norm(self.gravity))
        self._effective = settings.energy is ImpactEnergy.EFFECTIVE

    def _energies(self, table: BodyTable, speed: FloatArray) -> FloatArray:
        """Upper bound on the energy (n,) that bodies with at most this ``speed`` (n,) bring into an
        impact."""
        mass = table.mass
        if self._effective:
            # Twice the speed of the faster of two at most, and no more than the mass of one of them
            # that can be moved.
            mass = 4 * np.where(table.movable, mass, np.max(mass, where=table.movable, initial=0.0))
        return mass / 2 * (speed / self._settings.time_scale) ** 2

    def _none_strikes(self, table: BodyTable) -> bool:
        """Whether no body has a mass, and impacts without energy don't count."""
        return self.least > 0 and not table.mass.any()

    def soon(self, table: BodyTable, history: MotionHistory) -> BoolArray:
        """Which bodies (n,) may take part in an impact within the next `_FRAMES_AHEAD` frames: all
        that move and have a mass, as soon as one of them may have the energy for it."""
        if self._none_strikes(table):
            return np.zeros(len(table), dtype=np.bool_)
        gain = self._weight * history.step * _FRAMES_AHEAD
        energy = self._energies(table, history.speeds() + gain)
        moving = history.moving()
        return moving & (table.mass > 0) & (moving & (energy >= self.least / 2)).any()

    def paths(
        self,
        table: BodyTable,
        history: MotionHistory,
        airborne: BoolArray,
        samples: Samples | None,
    ) -> tuple[Paths, FloatArray] | None:
        """The paths of the bodies, and upper bounds on their speeds (n,) [m/s]; None if none is
        fast enough for an impact. ``airborne`` as in `MotionHistory.paths`; ``samples`` of known
        motion."""
        if self._none_strikes(table):
            return None
        if not history.moving().any():
            return None
        paths = history.paths(~table.dynamic, airborne, self.gravity)
        if paths is None:
            return None
        speed = paths.fastest() + np.sqrt(dot(paths.spin, paths.spin)) * table.reach
        if samples is not None:
            speed[samples.bodies] = samples.speeds(table.reach)
        return (paths, speed) if self.rapid(table, speed).any() else None

    def rapid(self, table: BodyTable, speed: FloatArray) -> BoolArray:
        """Which bodies (n,) with at most this ``speed`` (n,) may take part in an impact."""
        return self._energies(table, speed) >= self.least / 2

    def able(self, table: BodyTable, speed: FloatArray, a: IntArray, b: IntArray) -> BoolArray:
        """Which pairs (p,) of bodies ``a`` and ``b`` with at most this ``speed`` (n,) may have the
        energy for an impact."""
        if self._effective:
            mass = np.where(table.movable, table.mass, np.inf)
            mass = np.minimum(mass[a], mass[b])
            fast = (speed[a] + speed[b]) / self._settings.time_scale
            energy = np.where(np.isfinite(mass), mass, 0.0) / 2 * fast**2
        else:
            energy = self._energies(table, speed)[a] + self._energies(table, speed)[b]
        return np.asarray(energy >= self.least)
