"""Energies of hits, by the masses and moments of inertia of both bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from .body_table import BodyTable
from .impacts import Hits
from .inertia import inertia_of
from .settings import Body, ImpactEnergy


def impact_energies(
    hits: Hits, bodies: Sequence[Body], table: BodyTable, kind: ImpactEnergy
) -> FloatArray:
    """Energies (k,) of hits between ``bodies``, those of the ``table`` [J].

    EFFECTIVE: ``1/2 m v_n^2`` of the speed of approach ``v_n``, with the effective mass ``1/m``,
    the sum over both bodies of ``1/m + (r x n) I^-1 (r x n)``; ``r`` leads from the centre of mass
    to the contact with normal ``n``. A body that can't be moved adds 0.

    AS_IN_THE_PAPER: ``1/2 m v^2 + 1/2 w I w`` of both bodies, of their velocities just before.
    """
    return np.array([_energy(hits, k, bodies, table, kind) for k in range(len(hits))])


def _energy(
    hits: Hits, k: int, bodies: Sequence[Body], table: BodyTable, kind: ImpactEnergy
) -> float:
    total = 0.0
    normal = hits.normal[k]
    for side, number in enumerate(hits.pairs[k].tolist()):
        mass = float(table.mass[number])
        if not mass:
            continue
        inertia = inertia_of(bodies[number].shape)
        turn = hits.poses[k, side, :9].reshape(3, 3)
        centre = turn @ inertia.centre
        moment = turn @ inertia.moment @ turn.T
        if kind is ImpactEnergy.EFFECTIVE:
            if table.movable[number]:
                arm = hits.centre[k] - hits.poses[k, side, 9:] - centre
                twist = np.cross(arm, normal)
                total += float(1.0 + twist @ np.linalg.pinv(moment, hermitian=True) @ twist) / mass
        else:
            spin = hits.spins[k, side]
            velocity = hits.velocities[k, side] + np.cross(spin, centre)
            total += mass * float(velocity @ velocity + spin @ moment @ spin) / 2
    if kind is ImpactEnergy.AS_IN_THE_PAPER:
        return total
    return float(hits.approach[k]) ** 2 / (2 * total) if total else 0.0
