"""What contacts pass on by the impedances of the two bodies, by frequency band and direction.

The signal is a velocity. A wave in a body of impedance Z1 moves a body of impedance Z2 that it
meets with ``2 Z1 / (Z1 + Z2)`` of its own velocity, at most 1 here: what is light rides on what is
heavy, what is heavy hardly heeds what is light.

Impedances are magnitudes at the driven point [N s/m]. A point of a body moves with what lies within
``l = 2 sqrt(2) / k`` of it, where k is the wave number: ``Z = omega density a b c``, each size at
most l. That is ``8 sqrt(B m'')`` of a wide plate, ``2 sqrt(2) m' c_B`` of a long beam, and ``omega
m`` of a compact body (Cremer, Heckl and Petersson, *Structure-Borne Sound*, point impedances). A
half-space under a disc of radius r has the spring ``4 G r / (1 - nu)`` and the damper ``3.4 r^2
sqrt(G density) / (1 - nu)`` (Lysmer and Richart, 1966); with the shear modulus of flesh and the
area of a fingertip these are the published 1 N/mm and 1.5 N s/m (Wiertlewski and Hayward, 2012). A
limb moves as a whole up to its resonance, above which its impedance stays as it is there: seated
people have an apparent mass that falls by half from octave to octave above 5 Hz (ISO 5982), hands
some 100 N s/m (ISO 10068).

A small body moves with what stands behind it: as what drives another body it has the impedance of
the strongest body at one of its other contacts, in series with its own stiffness ``64 B / d^2 =
omega^2 m'' l^4 / d^2`` at the distance d beside its middle (Timoshenko: 16 pi B / d^2 in the middle
of a clamped plate of radius d). Along the normal of a contact bodies are rigid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..contacts.contact_set import ContactSet
from ..frozen import frozen
from ..scene.bands import BAND_CENTRES
from ..scene.functions.body import Body
from ..scene.functions.contacts import sprung
from ..scene.rules import Motion
from ..scene.values import HapticObject
from .object_frames import ObjectFrames

FREQUENCY = np.array(BAND_CENTRES)
OMEGA = 2 * math.pi * FREQUENCY
POISSON = 0.3
_UNKNOWN = Body()
_CHAIN = 4
"""Small bodies in a row through which a body is carried."""
_LEAST = 1e-6
"""Distance of a contact beside a body's middle [m] below which the body is rigid."""


@frozen(eq=False)
class Bodies:
    """The bodies of n objects by frequency band (n, bands).

    Attributes:
        known: (n,) whether the object has an impedance: is no medium, and of measured material.
        kind: (n,) a number that bodies share whose impedances are equal to 1e-6; no two springs do.
        carries: (n,) whether it moves with what stands behind it.
        impedance: [N s/m], of springs their stiffness over omega, infinite if unknown.
        bending: 64 B over omega [N s m]; 0 where nothing is carried: in half-spaces, limbs, and
            unknown bodies.
        half_space: (3, n) radius^2 [m^2], and per metre and square metre the spring [N/m^2] and
            the damper [N s/m^3] of half-spaces; 0 for other bodies.
        spring: (2, n) stiffness [N/m], infinite if it is none, and loss factor.
    """

    known: BoolArray
    kind: IntArray
    carries: BoolArray
    impedance: FloatArray
    bending: FloatArray
    half_space: FloatArray
    spring: FloatArray

    @classmethod
    def of(cls, objects: Sequence[HapticObject]) -> Bodies:
        """The bodies of objects. Blender's mass counts for those that it moves."""
        # Large scenes are of few materials: each function is asked once.
        functions = {id(o.propagation): o.propagation for o in objects}
        bodies = {key: function.body for key, function in functions.items()}
        found = [None if o.medium else bodies[id(o.propagation)] for o in objects]
        known = np.array([body is not None for body in found], dtype=np.bool_)
        rows = np.array([body or _UNKNOWN for body in found]).reshape(-1, len(_UNKNOWN))
        density, speed, radius, resonance, stiffness, loss = rows[:, :6].T
        sizes = rows[:, 6:]
        weighed = np.array(
            [o.mass if o.motion is Motion.DYNAMIC and o.mass else math.nan for o in objects]
        )
        volume = sizes.prod(axis=1)
        finite = np.isfinite(weighed / volume) & (volume < math.inf)
        density = np.where(finite, weighed / volume, density)
        bending = 1.8 * speed[:, None] * sizes[:, 2:] * FREQUENCY
        reach = math.sqrt(8) / np.sqrt(1 / bending + 1 / speed[:, None] ** 2) / OMEGA
        moved = density[:, None] / np.sqrt(
            1 / sizes[:, :, None] ** 2 + 1 / reach[:, None] ** 2
        ).prod(axis=1)
        limb = resonance < math.inf
        whole = (density * volume)[:, None] / np.hypot(1, FREQUENCY / resonance[:, None])
        is_spring = stiffness < math.inf
        impedance = OMEGA * np.where(limb[:, None], whole, moved)
        impedance = np.where(is_spring[:, None], stiffness[:, None] / OMEGA, impedance)
        bends = known & ~limb & ~is_spring & (radius == 0)
        # Blender's sizes are of single precision: what differs by less is alike.
        part, power = np.frexp(np.column_stack([density, rows[:, 1:]]))
        alike = np.ldexp(np.rint(part * 2**20), power)
        _, kind = np.unique(alike, axis=0, return_inverse=True)
        shear = density * speed**2
        ground = radius > 0
        return cls(
            known,
            np.where(is_spring, len(kind) + np.arange(len(kind)), kind),
            bends | is_spring,
            np.where(known[:, None], impedance, math.inf),
            np.where(bends[:, None], OMEGA * density[:, None] * sizes[:, 2:] * reach**4, 0.0),
            np.where(
                ground,
                [
                    radius**2,
                    4 * shear / (1 - POISSON),
                    3.4 * np.sqrt(density * shear) / (1 - POISSON),
                ],
                0.0,
            ),
            np.array([stiffness, loss]),
        )

    def at(self, index: IntArray, area: FloatArray) -> FloatArray:
        """Impedances (m, bands) of objects ``index`` (m,) at patches of ``area`` (m,) [m^2]."""
        found = self.impedance.take(index, axis=0)
        square, spring, damper = self.half_space.take(index, axis=1)
        chosen = np.flatnonzero(square)
        if len(chosen):
            driven = square[chosen] + area[chosen] / math.pi
            found[chosen] = np.hypot(
                (damper[chosen] * driven)[:, None],
                (spring[chosen] * np.sqrt(driven))[:, None] / OMEGA,
            )
        return found

    def flexibility(self, index: IntArray, away: FloatArray, normal: FloatArray) -> FloatArray:
        """Mobility (m, bands) [m/(N s)] with which objects ``index`` (m,) give way between their
        middles and points ``away`` (3, m) from these, across the ``normal`` (3, m)."""
        (x, y, z), (a, b, c) = away, normal
        aside = (y * c - z * b) ** 2 + (z * a - x * c) ** 2 + (x * b - y * a) ** 2
        aside = np.maximum(aside, _LEAST**2)
        aside[np.isnan(aside)] = math.inf
        with np.errstate(divide="ignore"):
            found = np.asarray(aside[:, None] / self.bending.take(index, axis=0))
        stiffness = self.spring[0].take(index)
        springs = np.flatnonzero(stiffness < math.inf)
        found[springs] = OMEGA / (2 * stiffness[springs, None])
        return found


def ask_for_bodies(bodies: Bodies, contacts: ContactSet) -> bool:
    """Whether what contacts pass on depends on the impedances of their bodies."""
    between = (function.between_bodies for function in contacts.transmissions)
    return len(contacts) > 0 and any(between) and bool(bodies.known.any())


def passed_by_bodies(
    bodies: Bodies, contacts: ContactSet, frames: ObjectFrames
) -> tuple[IntArray, FloatArray]:
    """Numbers of contacts (k,), and what these pass on by the impedances of their bodies (k, 2,
    bands), from the first object to the second and back: at most 1. All others pass everything:
    those of like bodies, of unknown ones and with another function."""
    if not ask_for_bodies(bodies, contacts):
        return np.zeros(0, dtype=np.int64), np.zeros((0, 2, len(OMEGA)))
    between = [function.between_bodies for function in contacts.transmissions]
    asks = np.array([row is not None for row in between])[contacts.transmission]
    inside = np.array([row or (math.inf, 0.0) for row in between])[contacts.transmission]
    return passed(bodies, contacts, frames, inside.T, asks)


def passed(
    bodies: Bodies,
    contacts: ContactSet,
    frames: ObjectFrames,
    inside: FloatArray,
    asks: BoolArray | bool = True,
) -> tuple[IntArray, FloatArray]:
    """As `passed_by_bodies`, of contacts of which ``asks`` (c,). ``inside`` (2, c): of springs in
    them the stiffness [N/m], infinite without one, and the loss factor."""
    first, second = contacts.pairs.T
    unlike = (bodies.kind.take(first) != bodies.kind.take(second)) | (inside[0] < math.inf)
    chosen = np.flatnonzero(unlike & bodies.known.take(first) & bodies.known.take(second) & asks)
    body = contacts.pairs.take(chosen, axis=0).T.reshape(-1)
    driving = bodies.at(body, np.tile(contacts.area.take(chosen), 2))
    load = np.roll(driving, len(chosen), axis=0)
    hard, loss = np.tile(inside.take(chosen, axis=1), 2)
    soft = (hard < math.inf) | (bodies.spring[0].take(body) < math.inf)
    # What drives no less than it meets passes everything, whatever stands behind it.
    asked = np.flatnonzero((driving < load).any(axis=1) | soft)
    sides = np.concatenate([chosen, chosen + len(contacts)])[asked]
    driving[asked] = _carried(bodies, contacts, frames, inside[0], sides, driving[asked])
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.minimum(2 / (1 + load / driving), 1.0)
        if soft.any():
            stiff = 1 / (1 / driving[soft] + OMEGA / hard[soft, None])
            damping = np.where(hard < math.inf, loss, bodies.spring[1].take(body))[soft]
            gain[soft] = sprung(load[soft] / stiff, damping[:, None])
    return chosen, gain.reshape(2, len(chosen), len(OMEGA)).transpose(1, 0, 2)


def _carried(
    bodies: Bodies,
    contacts: ContactSet,
    frames: ObjectFrames,
    inside: FloatArray,
    asked: IntArray,
    own: FloatArray,
) -> FloatArray:
    """Impedances (k, bands) with which bodies drive others at the sides ``asked`` (k,) of contacts,
    which are numbered through the first objects, then the second: their ``own`` (k, bands), or that
    of what stands behind them; of springs that of what stands behind them, as far as they are
    stiff. ``inside`` (c,): stiffness of springs in the contacts."""
    count = len(contacts)
    body = contacts.pairs.T.reshape(-1)
    several = np.bincount(body, minlength=len(bodies.known)) > 1
    carries = (bodies.carries & several).take(body)
    near = np.zeros(len(bodies.known), dtype=np.bool_)
    near[body[asked]] = True
    for _ in range(_CHAIN - 1):
        near[np.roll(body, count)[near.take(body) & carries]] = True
    side = np.flatnonzero(near.take(body) & carries)
    if len(side) == 0:
        return own
    side = side.take(body.take(side).argsort(kind="stable"))
    contact, other = side % count, (side + count) % (2 * count)
    # Mobilities, which add up in a row: of the sides, then of those across.
    both = body.take(np.concatenate([side, other]))
    with np.errstate(divide="ignore"):
        mobility = 1 / bodies.at(both, np.tile(contacts.area.take(contact), 2))
    mobility[(bodies.spring[0] < math.inf).take(both) & several.take(both)] = math.inf
    least = mobility[: len(side)].copy()
    place = np.full(2 * count, -1)
    place[side] = np.arange(len(side))
    across = place.take(other)
    across = np.where(across < 0, np.arange(len(side), len(both)), across)
    of = both[: len(side)]
    places = np.concatenate([contacts.positions[:, 0].T, contacts.positions[:, 1].T], axis=1)
    flexible = bodies.flexibility(
        of,
        places.take(side, axis=1) - frames.centre.T.take(of, axis=1),
        contacts.normal.T.take(contact, axis=1),
    )
    between = flexible + OMEGA / inside.take(contact)[:, None]
    opening = 1 / np.maximum(contacts.weight.take(contact), _LEAST**2)[:, None]
    others = _Others(of)
    for _ in range(_CHAIN):
        behind = opening * (mobility.take(across, axis=0) + between)
        driving = np.minimum(least, others.least(behind) + flexible)
        if np.array_equal(driving, mobility[: len(side)]):
            break
        mobility[: len(side)] = driving
    found = place.take(asked)
    with np.errstate(divide="ignore"):
        return np.where((found < 0)[:, None], own, 1 / mobility.take(found, axis=0))


class _Others:
    """For each of rows that are sorted by their ``group`` (m,), of at least two each, the others of
    its group, in a circle: steps that double the length of a run of them, and the two runs that
    together are all others."""

    def __init__(self, group: IntArray) -> None:
        start = np.flatnonzero(np.diff(group, prepend=-1))
        size = np.diff(start, append=len(group))
        first = np.repeat(start, size)
        size = np.repeat(size, size)
        along = np.arange(len(group)) - first
        run = np.ones_like(size)
        self._steps = []
        while (grows := 2 * run < size).any():
            self._steps.append(first + (along + np.where(grows, run, 0)) % size)
            run = np.where(grows, 2 * run, run)
        self._runs = first + (along + 1) % size, first + (along - run) % size

    def least(self, values: FloatArray) -> FloatArray:
        """The least value (m, bands) of the others."""
        for step in self._steps:
            values = np.minimum(values, values.take(step, axis=0))
        one, other = self._runs
        return np.asarray(np.minimum(values.take(one, axis=0), values.take(other, axis=0)))
