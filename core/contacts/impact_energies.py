"""Energies of hits, by the masses and moments of inertia of both bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from .body_table import BodyTable
from .impacts import Hits
from .inertia import inertia_of
from .narrow.frames import cross
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
        pose, spin, velocity = hits.poses[k, side], hits.spins[k, side], hits.velocities[k, side]
        mass = float(table.mass[number])
        if kind is ImpactEnergy.EFFECTIVE:
            moves = bool(spin.any() or velocity.any())
            total += inverse_mass(
                bodies[number], bool(table.movable[number]), moves, pose, hits.centre[k], normal
            )
        elif mass:
            inertia = inertia_of(bodies[number].shape)
            turn = pose[:9].reshape(3, 3)
            velocity = velocity + np.cross(spin, turn @ inertia.centre)
            moment = turn @ inertia.moment @ turn.T
            total += mass * float(velocity @ velocity + spin @ moment @ spin) / 2
    if kind is ImpactEnergy.AS_IN_THE_PAPER:
        return total
    return float(hits.approach[k]) ** 2 / (2 * total) if total else 0.0


def inverse_mass(
    body: Body,
    is_movable: bool,
    moves: bool,
    pose: FloatArray,
    centre: FloatArray,
    normal: FloatArray,
) -> float:
    """``1/m + (r x n) I^-1 (r x n)`` of a body [1/kg], 0 if it can't be moved.

    Args:
        body: the body.
        is_movable: whether it yields with the mass that it has.
        moves: whether it moves; what animation moves yields with the mass of its volume, where it
            has none. What stands may be a part of a building.
        pose: of it (12,).
        centre: of the contact (3,) [m].
        normal: of the contact (3,).
    """
    weighed = moves and body.is_weighed_by_volume
    if not (is_movable or weighed):
        return 0.0
    inertia = inertia_of(body.shape)
    mass = (body.mass or 0.0) if is_movable else inertia.volume * body.density
    back = pose[:9].reshape(3, 3).T
    twist = cross(back @ (centre - pose[9:]) - inertia.centre, back @ normal)
    return float(1.0 + twist @ inertia.inverse @ twist) / mass
