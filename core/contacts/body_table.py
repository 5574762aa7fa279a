"""What the tracker knows of bodies apart from their poses: sizes, masses, and their shapes as the
narrow phase has them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..scene.rules import full_energy_of
from .narrow.frames import turned
from .narrow.narrow_phase import NarrowPhase
from .settings import Body, Motion
from .shapes import Compound, Shape
from .time_of_impact import TimeOfImpact

STILL = 1e-5
"""Metres of motion below which a body counts as at rest: simulations at rest tremble, and poses are
float32."""


_SMALL = 0.1
"""Part of a body's middle extent up to which a gap may count as none: what is 10 cm wide touches
over 1 cm, the usual tolerance, and a cube of 1 mm over 0.1 mm."""


class BodyTable:
    """``bodies`` as arrays by their number, from 0 to n - 1. What is known of shapes that are also
    in the table ``before`` is taken over. ``passing`` as in `ContactSettings`.

    Attributes:
        middle, extent: (3, n) middle and half extents of a body's bounds in its own space [m].
        radius: (n,) of the bounds about their middle [m].
        reach: (n,) of the bounds about the body's origin [m].
        small: (n,) gap up to which the body can touch [m], by the middle one of its extents: so a
            sheet counts by its width.
        rest_limits: (12, n) changes of the elements of a pose that count as rest.
        mass: (n,) [kg], 0 of a body without.
        weighed: (n,) which bodies have the mass of their volume.
        dynamic: (n,) which bodies a simulation moves.
        movable: (n,) which bodies yield to a blow: they have a mass, and move or are moved.
        full_energy: of blows of full strength where no rule says which that is [J].
        medium: (n,) which bodies are volumes of air or water.
        layers: (n,) in which bodies are struck, see `Body.struck_in`.
        passing: (q,) keys of the pairs that pass through each other, ascending.
        limbs: by number of a skin that of its first part in ``narrow``, where parts follow bodies.
        narrow, time_of_impact: queries between the bodies.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        before: BodyTable | None = None,
        passing: Sequence[tuple[str, str]] = (),
    ) -> None:
        shapes = [body.shape for body in bodies]
        local = np.array([shape.local_bounds for shape in shapes]).reshape(-1, 2, 3)
        count = len(bodies)
        self.middle, self.extent = np.empty((2, 3, count))
        self.radius, self.reach, self.small = np.empty((3, count))
        self.rest_limits = np.empty((12, count))
        self._set_sizes(slice(count), local)
        self.mass = np.array([body.mass or 0.0 for body in bodies], dtype=np.float64)
        self.weighed = np.array([body.is_weighed_by_volume for body in bodies], dtype=np.bool_)
        self.dynamic = np.array([body.motion is Motion.DYNAMIC for body in bodies], dtype=np.bool_)
        self.medium = np.array([body.medium for body in bodies], dtype=np.bool_)
        static = np.array([body.motion is Motion.STATIC for body in bodies], dtype=np.bool_)
        self.limbs: dict[int, int] = {}
        limbs = list[Shape]()
        for row, body in enumerate(bodies):
            shape = body.shape
            if body.limbs and isinstance(shape, Compound) and body.motion is not Motion.DYNAMIC:
                self.limbs[row] = count + len(limbs)
                limbs += shape.parts
                self.mass[row] = 0.0
        self.movable = (self.mass > 0) & ~static & ~self.medium
        self.full_energy = full_energy_of(self.mass[self.movable].tolist())
        self.layers = np.array([body.struck_in for body in bodies], dtype=np.int64)
        number = {body.name: k for k, body in enumerate(bodies)} if passing else {}
        pairs = [[number[one], number[two]] for one, two in passing if {one, two} <= number.keys()]
        self.passing = np.sort(self.keys(np.sort(np.array(pairs, dtype=np.int64).reshape(-1, 2))))
        self.narrow: NarrowPhase = NarrowPhase(
            shapes + limbs,
            self.medium.tolist() + [False] * len(limbs),
            None if before is None else before.narrow,
        )
        self.time_of_impact = TimeOfImpact(self.narrow, local)

    def __len__(self) -> int:
        return len(self.mass)

    def _set_sizes(self, bodies: slice, local: FloatArray) -> None:
        """Set what depends on the ``local`` bounds (k, 2, 3) of some bodies."""
        low, high = local.transpose(1, 2, 0)
        self.middle[:, bodies] = (low + high) / 2
        self.extent[:, bodies] = (high - low) / 2
        self.radius[bodies] = np.sqrt((self.extent[:, bodies] ** 2).sum(axis=0))
        reach = self.reach[bodies] = np.sqrt((np.abs(local).max(axis=1) ** 2).sum(axis=1))
        middle = np.median(self.extent[:, bodies], axis=0)
        self.small[bodies] = np.maximum(2 * _SMALL * middle, STILL)
        self.rest_limits[:9, bodies] = STILL / reach.clip(1e-9)
        self.rest_limits[9:, bodies] = STILL

    def move_parts(self, number: int, old: Body, body: Body) -> bool:
        """Give the parts of a compound other poses, as bones do. Returns False, without a change,
        if ``body`` differs from ``old``, the body ``number``, in anything but the poses of its
        parts."""
        shape = old.shape
        new = body.shape
        if (
            not isinstance(shape, Compound)
            or not isinstance(new, Compound)
            or shape.parts != new.parts
            or shape.margin != new.margin
            or replace(body, shape=shape) != old
        ):
            return False
        local = new.local_bounds
        if not self.narrow.place(number, new, local):
            return False
        self._set_sizes(slice(number, number + 1), local[None])
        self.time_of_impact.measure(number, local)
        return True

    def tolerance(self, one: IntArray, other: IntArray, most: float) -> FloatArray:
        """Gaps (k,) up to which bodies touch others [m]: ``most``, or less where one is small."""
        return np.minimum(np.minimum(self.small[one], self.small[other]), most)

    def keys(self, pairs: IntArray) -> IntArray:
        """One number (k,) for each pair of bodies (k, 2), ascending with the first, then the
        second body."""
        return np.asarray(pairs @ (len(self), 1))

    def numbers(self, key: IntArray) -> IntArray:
        """The bodies (k, 2) of pairs by ``key``, smaller number first."""
        return np.array(np.divmod(key, max(len(self), 1))).T

    def by_size(self, key: IntArray) -> tuple[IntArray, IntArray]:
        """Numbers of the larger and of the smaller body of each pair, by ``key``."""
        first, second = np.divmod(key, max(len(self), 1))
        larger = self.radius[first] >= self.radius[second]
        return np.where(larger, first, second), np.where(larger, second, first)

    def extents(self, bodies: IntArray, pose: FloatArray, grow: float) -> FloatArray:
        """How far ``bodies`` (k,) in ``pose`` (12, k) extend in the world, against and along the
        axes (2, 3, k), and so many metres farther."""
        turn = pose[:9].reshape(3, 3, -1)
        centre = turned(turn, self.middle.take(bodies, axis=1)) + pose[9:]
        half = turned(np.abs(turn), self.extent.take(bodies, axis=1)) + grow
        return np.array([half - centre, half + centre])
