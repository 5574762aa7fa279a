"""Energies under powers at a few subsystems of a large balance, from their neighbourhoods alone.

Where what leaves a neighbourhood is lost, power p brings about energies E in it, of which p·E is at
most the true energy p·A⁻¹ p where the power is put in. That is at most the one in a second balance
A' of the neighbourhood, in which part of what leaves comes back: what a subsystem k outside
receives, it loses at least to the part D_k / A_kk, even if its other neighbours return everything.
With the residual r' of E in A', which is E times what comes back, and the damping D' of A',

    p·E <= p·A⁻¹ p <= p·E + r'·E + Σ r'_i² / D'_i,

and the middle less the left is the square of the bound on the error of E (`Balanced`).
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray, added_by, ranges
from ..frozen import frozen
from .conjugate_gradients import PowerBalance, solve, solve_at_once, summed

RINGS, FEW = 2, 72
"""Rings of neighbours around a subsystem; those beyond the first only as long as no more subsystems
than that are in the neighbourhoods together."""

PART = 0.1
"""How exact the energies within a neighbourhood are, relative to what is asked."""


@frozen
class Near:
    """Approximate energies in the neighbourhoods of t powers, with bounds on their errors.

    Attributes:
        where: (u,) the subsystems with other energies than 0, ascending.
        energy: (u, k, t) of these.
        own: (k, t) energies where the powers are put in.
        doubt: (k, t) bounds on their errors.
        bound: (k, t) as in `Balanced`.
    """

    where: IntArray
    energy: FloatArray
    own: FloatArray
    doubt: FloatArray
    bound: FloatArray


def near(
    balance: PowerBalance, inputs: tuple[IntArray, IntArray, FloatArray], goal: FloatArray
) -> Near:
    """Energies near the subsystems at which power is put in.

    Args:
        balance: k systems.
        inputs: the powers, by their number (b,), subsystem (b,) and size (k, b).
        goal: (k, t) bounds that are good enough.
    """
    number, region, size = inputs
    where, entries = _around(balance, region)
    inside, returned = _alone(balance, where, entries)
    power = np.zeros((len(where), *goal.shape))
    power[where.searchsorted(region), :, number] = size.T
    found = (solve_at_once(inside, power) if len(where) <= FEW else None) or solve(
        inside, power, lambda energy, bound: PART * goal
    )
    back = returned.T[:, :, None]
    residual = found.residual + back * found.energy
    left = np.abs(residual) + found.rounding
    lost = (inside.damping + inside.leak - returned).T[:, :, None]
    own = summed((power + found.residual) * found.energy)
    rounding = summed(found.rounding * found.energy)
    square = summed(back * found.energy**2 + left**2 / lost) + rounding
    return Near(where, found.energy, own + square / 2, square / 2 + rounding, np.sqrt(square))


def _around(balance: PowerBalance, start: IntArray) -> tuple[IntArray, IntArray]:
    """Some subsystems and those around them, ascending, and the numbers of their couplings."""
    reached = np.zeros(balance.damping.shape[1], dtype=np.bool_)
    reached[start] = True
    where = further = np.flatnonzero(reached)
    for ring in range(RINGS + 1):
        if ring > 1 and len(further) > FEW:
            break
        where = further
        first = balance.row.searchsorted(where)
        entries = ranges(first, balance.row.searchsorted(where, side="right") - first)
        reached[balance.column[entries]] = True
        further = np.flatnonzero(reached)
    return where, entries


def _alone(
    balance: PowerBalance, where: IntArray, entries: IntArray
) -> tuple[PowerBalance, FloatArray]:
    """The balance of a neighbourhood (u,) with these couplings, in which what leaves it is lost,
    and of that what may come back (k, u)."""
    count = len(where)
    place = np.full(balance.damping.shape[1], -1)
    place[where] = np.arange(count)
    row, column = place.take(balance.row.take(entries)), balance.column.take(entries)
    coupling = balance.coupling.take(entries, axis=1)
    kept = 1 - (balance.damping + balance.leak) / balance.diagonal
    outside = place[column] < 0
    leaves = added_by(row[outside], coupling[:, outside], count)
    returned = added_by(row[outside], coupling[:, outside] * kept[:, column[outside]], count)
    blocks = []
    for begin, block in balance.blocks:
        size = block.shape[1]
        first, last = where.searchsorted([begin, begin + size]).tolist()
        if first == last:
            continue
        mine = where[first:last] - begin
        other = place[begin : begin + size] < 0
        across = block[:, mine] * other
        leaves[:, first:last] += across.sum(axis=2)
        returned[:, first:last] += (across * kept[:, None, begin : begin + size]).sum(axis=2)
        blocks.append((first, block[:, mine][:, :, mine]))
    inside = PowerBalance(
        balance.damping[:, where],
        balance.leak[:, where] + leaves,
        row[~outside],
        place[column[~outside]],
        coupling[:, ~outside],
        blocks,
    )
    return inside, returned
