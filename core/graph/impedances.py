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
        impedance: [N s/m], of springs their stiffness over omega, infinite if unknown.
        bending: 64 B over omega [N s m]; 0 where nothing is carried: in half-spaces, limbs, and
            unknown bodies.
        half_space: (3, n) radius^2 [m^2], and per metre and square metre the spring [N/m^2] and
            the damper [N s/m^3] of half-spaces; 0 for other bodies.
        spring: (2, n) stiffness [N/m], infinite if it is none, and loss factor.
    """

    known: BoolArray
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
        carries = known & ~limb & (radius == 0)
        shear = density * speed**2
        ground = radius > 0
        return cls(
            known,
            np.where(known[:, None], impedance, math.inf),
            np.where(carries[:, None], OMEGA * density[:, None] * sizes[:, 2:] * reach**4, 0.0),
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
        square, spring, damper = self.half_space[:, index]
        chosen = np.flatnonzero(square)
        if len(chosen):
            driven = square[chosen] + area[chosen] / math.pi
            found[chosen] = np.hypot(
                (damper[chosen] * driven)[:, None],
                (spring[chosen] * np.sqrt(driven))[:, None] / OMEGA,
            )
        return found


def ask_for_bodies(bodies: Bodies, contacts: ContactSet) -> bool:
    """Whether what contacts pass on depends on the impedances of their bodies."""
    between = (function.between_bodies for function in contacts.transmissions)
    return len(contacts) > 0 and any(between) and bool(bodies.known.any())


def passed_by_bodies(
    bodies: Bodies, contacts: ContactSet, frames: ObjectFrames
) -> FloatArray | None:
    """What contacts pass on by the impedances of their bodies (c, 2, bands), from the first object
    to the second and back: at most 1, and 1 where a body is unknown or the contact's function is
    another. None if all is 1."""
    if not ask_for_bodies(bodies, contacts):
        return None
    between = [function.between_bodies for function in contacts.transmissions]
    inside = np.array([row or (math.inf, 0.0) for row in between])[contacts.transmission]
    gains = passed(bodies, contacts, frames, inside.T)
    gains[~np.array([row is not None for row in between])[contacts.transmission]] = 1.0
    return gains if gains.min() < 1 else None


def passed(
    bodies: Bodies, contacts: ContactSet, frames: ObjectFrames, inside: FloatArray
) -> FloatArray:
    """What contacts pass on (c, 2, bands), whatever their functions. ``inside`` (2, c): of springs
    in them the stiffness [N/m], infinite without one, and the loss factor."""
    count = len(contacts)
    body = contacts.pairs.T.reshape(-1)
    own = bodies.at(body, np.tile(contacts.area, 2))
    hard, loss = np.tile(inside, 2)
    between = hard[:, None] / OMEGA
    driving = _carried(bodies, contacts, frames, body, own, between)
    load = np.roll(own, count, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.nan_to_num(np.minimum(2 / (1 + load / driving), 1.0), nan=1.0)
    driving = _in_series(driving, between)
    soft = np.where(hard < math.inf, loss, bodies.spring[1, body])
    chosen = np.flatnonzero((hard < math.inf) | (bodies.spring[0, body] < math.inf))
    gain[chosen] = sprung(load[chosen] / driving[chosen], soft[chosen, None])
    known = bodies.known[contacts.pairs].all(axis=1)
    gain[~np.tile(known, 2)] = 1.0
    return np.asarray(gain.reshape(2, count, -1).transpose(1, 0, 2))


def _in_series(one: FloatArray, other: FloatArray) -> FloatArray:
    """The impedance of two in a row, of which the softer one gives way."""
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(1 / (1 / one + 1 / other))


def _carried(
    bodies: Bodies,
    contacts: ContactSet,
    frames: ObjectFrames,
    body: IntArray,
    own: FloatArray,
    inside: FloatArray,
) -> FloatArray:
    """Impedances (2 c, bands) with which bodies drive others at the sides of contacts, first those
    of the first objects: their ``own``, or that of what stands behind them; of springs that of what
    stands behind them, as far as they are stiff. ``inside`` (2 c, bands): of springs in the
    contacts."""
    order = body.argsort(kind="stable")
    start = np.flatnonzero(np.diff(body[order], prepend=-1))
    sizes = np.diff(start, append=len(body))
    if (sizes == 1).all():
        return own
    away = contacts.positions.transpose(1, 0, 2).reshape(-1, 3) - frames.centre.take(body, axis=0)
    along = (away * np.tile(contacts.normal, (2, 1))).sum(axis=1)
    aside = np.maximum((away**2).sum(axis=1) - along**2, _LEAST**2)[:, None]
    half = np.nan_to_num(bodies.bending.take(body, axis=0) / aside, nan=0.0)
    spring = bodies.spring[0].take(body)
    soft = np.flatnonzero(spring < math.inf)
    half[soft] = 2 * spring[soft, None] / OMEGA
    least = own
    if len(soft):
        least = own.copy()
        least[soft[sizes[np.searchsorted(body[order][start], body[soft])] > 1]] = 0.0
    # From here on all is in the order of the bodies.
    place = order.argsort(kind="stable")
    partner = place[(order + len(contacts)) % len(body)]
    group = np.repeat(np.arange(len(start)), sizes)
    half, inside, least = (values.take(order, axis=0) for values in (half, inside, least))
    weight = np.tile(contacts.weight, 2)[order, None]
    driving = least
    for _ in range(_CHAIN):
        behind = _in_series(driving.take(partner, axis=0), half)
        if (inside < math.inf).any():
            behind = _in_series(behind, inside)
        carried = _most_of_the_others(weight * behind, start, group)
        before, driving = driving, np.maximum(least, _in_series(carried, half))
        if np.array_equal(before, driving):
            break
    return driving.take(place, axis=0)


def _most_of_the_others(values: FloatArray, start: IntArray, group: IntArray) -> FloatArray:
    """For each of the rows of ``values`` (m, bands) the greatest of the others of its group, 0
    without any. Groups begin at ``start``; ``group`` (m,) is the number of each row's."""
    most = np.maximum.reduceat(values, start)
    most_here = most.take(group, axis=0)
    is_most = values == most_here
    rest = np.maximum.reduceat(np.where(is_most, 0.0, values), start)
    rest = np.where(np.add.reduceat(is_most, start, dtype=np.int64) > 1, most, rest)
    return np.where(is_most, rest.take(group, axis=0), most_here)
