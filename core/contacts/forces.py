"""Estimated forces of resting contacts from static equilibrium.

Every body that physics moves is at rest: the forces and torques of its contacts balance its weight.
A contact pushes, never pulls, and its friction is at most a fraction of its normal force. If
supports are redundant, the solution with the least sum of squares is taken, in which symmetric
supports have equal loads.
"""

from __future__ import annotations

import math

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, connected
from .contact_set import ContactSet
from .least_squares import bounded_least_squares

MOST_BODIES = 150
"""Largest group of bodies connected by contacts whose forces are estimated, because time grows with
the cube of their number."""

UNBALANCED = 0.05
"""Largest fraction of a body's weight that its contacts may leave unbalanced; above it, the body
does not rest on them."""

_FRICTIONS = (0.25, 0.5)
"""Friction coefficients: the product of two bodies' default friction in Blender, and a larger one
if that leaves a body unbalanced."""
_ROUNDS = 2
"""Solutions per friction coefficient, each with friction bounded by the normal forces of the one
before; the very first is unbounded."""
_RELUCTANCE = 0.3
"""Scale of friction in the sum of squares, beside 2 for the normal force at a point: friction
carries only what normal forces do not."""
_SOFTNESS = 1e-7
_TORQUE = 0.3
"""Weight of a torque relative to a force: patches are approximated by squares, whose torques differ
slightly from those of the patches."""


def contact_forces(
    contacts: ContactSet,
    mass: FloatArray,
    centre: FloatArray,
    gravity: tuple[float, float, float],
    asked: BoolArray | None = None,
) -> FloatArray:
    """The normal force (n,) of each contact [N], NaN if it is unknown.

    Args:
        contacts: all of them.
        mass: (o,) of the bodies that physics moves [kg], 0 for fixed ones, NaN if unknown.
        centre: (o, 3) of mass [m, world].
        gravity: [m/s^2].
        asked: (n,) the contacts of interest, None for all; others have a force only if they are
            connected to these.
    """
    forces = np.full(len(contacts), np.nan)
    movable = mass > 0
    known = np.isfinite(mass) & (np.isfinite(centre).all(axis=1) | ~movable)
    group = connected(contacts.pairs[movable[contacts.pairs].all(axis=1)], len(movable))
    fixed = ~movable[contacts.pairs].any(axis=1)
    for label in np.unique(group[movable]).tolist():
        bodies = np.flatnonzero(movable & (group == label))
        rows = np.flatnonzero(
            (movable[contacts.pairs] & (group[contacts.pairs] == label)).any(axis=1) & ~fixed
        )
        wanted = len(rows) > 0 and (asked is None or asked[rows].any())
        if wanted and len(bodies) <= MOST_BODIES and known[contacts.pairs[rows]].all():
            forces[rows] = _of_group(contacts, rows, bodies, mass, centre, np.array(gravity))
    return forces


def _of_group(
    contacts: ContactSet,
    rows: IntArray,
    bodies: IntArray,
    mass: FloatArray,
    centre: FloatArray,
    gravity: FloatArray,
) -> FloatArray:
    """The normal forces of contacts between connected bodies; NaN at bodies that are not balanced.

    Args:
        contacts: all of them.
        rows: those of the group.
        bodies: the group that physics moves.
        mass: of all bodies [kg].
        centre: of mass of all bodies (o, 3) [m, world].
        gravity: (3,) [m/s^2].
    """
    place = np.full(len(mass), -1)
    place[bodies] = np.arange(len(bodies))
    strength = float(np.linalg.norm(gravity))
    _, first, second = directions = _directions(contacts.normal[rows])
    # The middle of each contact, and the ways from there to the corners of half the square that has
    # the patch's area.
    half = np.sqrt(contacts.area[rows])[:, None] / 2
    points = contacts.positions[rows].mean(axis=1)
    offsets = np.stack([half * (a * first + b * second) for a in (-1, 1) for b in (-1, 1)])
    unit = float(mass[bodies].mean()) * max(strength, 1e-9)
    # A length [m] of the size of the levers.
    size = max(float(np.linalg.norm(np.ptp(points, axis=0))) / math.sqrt(len(rows)), 1e-3)
    # A column per direction and point: 4 points press along the normal, and friction acts at the
    # middle.
    matrix = np.zeros((6 * len(bodies), 6 * len(rows)))
    for side, sign in ((0, -1.0), (1, 1.0)):
        body = contacts.pairs[rows, side]
        moved = np.flatnonzero(place[body] >= 0)
        for column in range(6):
            push = sign * directions[max(column - 3, 0)][moved]
            arm = (
                points[moved]
                + (offsets[column][moved] if column < 4 else 0.0)
                - centre[body[moved]]
            )
            row = 6 * place[body[moved]]
            for axis in range(3):
                matrix[row + axis, column * len(rows) + moved] = push[:, axis]
                matrix[row + 3 + axis, column * len(rows) + moved] = (
                    _TORQUE / size * np.cross(arm, push)[:, axis]
                )
    target = np.zeros((len(bodies), 6))
    target[:, :3] = -mass[bodies, None] * gravity / unit
    falls = np.zeros(len(mass), dtype=np.bool_)
    solved = _balanced(matrix, target.reshape(-1), len(rows), np.full(2 * len(rows), np.inf))
    for friction in _FRICTIONS:
        for _ in range(_ROUNDS):
            pressed = solved[: 4 * len(rows)].reshape(4, -1).sum(axis=0)
            solved = _balanced(
                matrix, target.reshape(-1), len(rows), friction * np.tile(pressed, 2)
            )
        left = (
            np.linalg.norm((matrix @ solved - target.reshape(-1)).reshape(-1, 6)[:, :3], axis=1)
            * unit
        )
        falls[bodies] = left > UNBALANCED * mass[bodies] * strength
        if not falls.any():
            break
    pressed = solved[: 4 * len(rows)].reshape(4, -1).sum(axis=0)
    return np.where(falls[contacts.pairs[rows]].any(axis=1), np.nan, pressed * unit)


def _balanced(matrix: FloatArray, target: FloatArray, count: int, most: FloatArray) -> FloatArray:
    """Normal forces at 4 points and friction in 2 directions (6 * count,) that come nearest to the
    target.

    ``most``: of friction (2 * count,).
    """
    # Of the unknowns: the smaller, the more a force costs.
    scale = np.repeat([2.0, _RELUCTANCE], [4 * count, 2 * count])
    low = np.concatenate([np.zeros(4 * count), -most / _RELUCTANCE])
    high = np.concatenate([np.full(4 * count, np.inf), most / _RELUCTANCE])
    return scale * bounded_least_squares(matrix * scale, target, low, high, _SOFTNESS)


def _directions(normal: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals and two tangents (k, 3)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return normal, first, np.cross(normal, first)
