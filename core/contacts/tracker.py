"""Contacts from frame to frame: begin, end and impacts, with work done only where something moved."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .broad_phase import overlapping_pairs
from .contact_set import ContactSet
from .narrow_phase import NarrowPhase, PairPatches
from .shapes import Shape, transformed_bounds

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


class Motion(enum.StrEnum):
    """What moves a body."""

    STATIC = "static"  # nothing
    KINEMATIC = "kinematic"  # animation
    DYNAMIC = "dynamic"  # the simulation


class ImpactEnergy(enum.StrEnum):
    """The energy that an impact is judged by."""

    KINETIC = "kinetic"  # the paper's: 1/2 m1 v1^2 + 1/2 m2 v2^2
    NORMAL = "normal"  # 1/2 mu v_n^2: relative motion along the normal, the same in every frame of reference


@dataclass(frozen=True, slots=True)
class Body:
    """What the tracker knows of an object. ``mass`` in kg; None where it has none: then its impacts carry no energy of its own."""

    name: str
    shape: Shape
    mass: float | None = None
    motion: Motion = Motion.DYNAMIC
    medium: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", Motion(self.motion))
        if self.mass is not None and not 0 <= self.mass < math.inf:
            raise ValueError(f"mass: must be finite and >= 0 kg, got {self.mass!r}")


@dataclass(frozen=True, slots=True)
class ContactSettings:
    """``tolerance``: a pair touches at a signed distance of at most so many metres, and goes on up to ``slack`` more.
    ``patch_points``: one contact per point of a patch, with shares, instead of one at its centre.
    An impact is a begin of contact with at least ``least_energy`` (E_min) joules; ``full_energy`` (E_max) gives amplitude 1. A pair makes
    no second impact within ``refractory`` seconds."""

    tolerance: float = 0.01
    slack: float = 0.005
    patch_points: bool = False
    energy: ImpactEnergy = ImpactEnergy.KINETIC
    least_energy: float = 5.0
    full_energy: float = 100.0
    refractory: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "energy", ImpactEnergy(self.energy))
        for key in ("tolerance", "slack", "least_energy", "refractory"):
            if not 0 <= getattr(self, key) < math.inf:
                raise ValueError(f"{key}: must be finite and >= 0, got {getattr(self, key)!r}")
        if not 0 < self.full_energy < math.inf:
            raise ValueError(f"full_energy: must be finite and > 0 J, got {self.full_energy!r}")


@dataclass(frozen=True, slots=True)
class Impact:
    """Two bodies (numbers, smaller first) that begin to touch. ``time`` [s]; ``position`` of the contact node on either body then
    [m, world]; unit ``normal`` from first to second; ``energy`` [J]; ``amplitude`` = min(energy / E_max, 1)."""

    objects: tuple[int, int]
    time: float
    positions: tuple[tuple[float, float, float], tuple[float, float, float]]
    normal: tuple[float, float, float]
    energy: float
    amplitude: float


@dataclass(frozen=True, slots=True)
class ContactStatistics:
    """Of one update: ``candidates`` pairs with overlapping bounds, narrow-phase ``queries`` made and ``avoided``."""

    candidates: int = 0
    queries: int = 0
    avoided: int = 0


@dataclass(frozen=True, slots=True)
class FrameContacts:
    """One frame: all ``contacts`` (pairs by number of the body, sorted), the pairs (k, 2) that ``began`` and ``ended``, ``impacts`` by
    time, and ``warnings`` that name the object they are about."""

    contacts: ContactSet
    began: IntArray
    ended: IntArray
    impacts: tuple[Impact, ...]
    statistics: ContactStatistics
    warnings: tuple[str, ...]


class ContactTracker:
    """Follows the contacts of ``bodies`` from frame to frame."""

    def __init__(self, bodies: Sequence[Body], settings: ContactSettings | None = None) -> None:
        self.bodies = tuple(bodies)
        self.settings = settings or ContactSettings()
        self._moving = np.array([b.motion is not Motion.STATIC for b in self.bodies], dtype=np.bool_)
        self._bounds = np.array([b.shape.local_bounds() for b in self.bodies], dtype=np.float64).reshape(-1, 2, 3)
        self._narrow = NarrowPhase([b.shape for b in self.bodies], [b.medium for b in self.bodies])
        self._mass = np.array([0.0 if b.mass is None else b.mass for b in self.bodies])
        self.reset()

    def reset(self) -> None:
        """Forget the past: the next update begins no contact and makes no impact."""
        self._touching: frozenset[tuple[int, int]] | None = None
        self._history: list[tuple[float, FloatArray]] = []
        self._last_impact: dict[tuple[int, int], float] = {}

    def update(self, time: float, transforms: FloatArray, wanted: BoolArray | None = None, continuous: bool = True) -> FrameContacts:
        """The contacts at ``time`` [s] under rigid world ``transforms`` (n, 4, 4), scale being in the shapes.

        ``wanted`` (n,): only contacts with at least one such body are found; None: all. ``continuous`` False says that this is not the step
        that follows the last one: history is forgotten.
        """
        transforms = np.asarray(transforms, dtype=np.float64)
        if transforms.shape != (len(self.bodies), 4, 4):
            raise ValueError(f"transforms: expected {len(self.bodies)} matrices of 4 x 4, got an array of shape {transforms.shape}")
        if not continuous or (self._history and time <= self._history[-1][0]):
            self.reset()
        bounds = transformed_bounds(self._bounds, transforms)
        reach = self.settings.tolerance + self.settings.slack
        bounds += np.array([[-reach / 2], [reach / 2]])
        candidates = overlapping_pairs(bounds, None)
        if wanted is not None:
            candidates = candidates[wanted[candidates].any(axis=1)]
        before = self._touching or frozenset()
        touched = np.array([tuple(pair) in before for pair in candidates.tolist()], dtype=np.bool_)
        limit = self.settings.tolerance + np.where(touched, self.settings.slack, 0.0)
        first, second = candidates.T
        patches = self._narrow.query(candidates, transforms[first], transforms[second], limit, self.settings.patch_points)
        near = patches.distance <= limit
        found = contact_set(candidates[near], patches, np.flatnonzero(near), self.settings.patch_points)
        touching = frozenset((a, b) for a, b in candidates[near].tolist())
        known = self._touching is not None
        began = sorted(touching - before) if known else []
        ended = sorted(before - touching)
        self._history = [*self._history[-2:], (time, transforms.copy())]
        rows = {(a, b): k for k, (a, b) in enumerate(candidates.tolist())}
        impacts = self._impacts(rows, patches, began)
        self._touching = touching
        return FrameContacts(
            contacts=found,
            began=np.array(began, dtype=np.int64).reshape(-1, 2),
            ended=np.array(ended, dtype=np.int64).reshape(-1, 2),
            impacts=impacts,
            statistics=ContactStatistics(len(candidates), len(candidates), 0),
            warnings=(),
        )

    def _impacts(
        self, rows: dict[tuple[int, int], int], patches: PairPatches, began: Sequence[tuple[int, int]]
    ) -> tuple[Impact, ...]:
        if len(self._history) < 3:
            return ()
        (t0, m0), (t1, m1), (t2, _) = self._history
        velocity = (m1[:, :3, 3] - m0[:, :3, 3]) / (t1 - t0)
        impacts = []
        for pair in began:
            a, b = pair
            va, vb = velocity[a], velocity[b]
            row = rows[pair]
            if self.settings.energy is ImpactEnergy.KINETIC:
                energy = float(0.5 * self._mass[a] * va @ va + 0.5 * self._mass[b] * vb @ vb)
            else:
                ma, mb = self._mass[pair,]
                reduced = ma * mb / (ma + mb) if ma and mb else max(ma, mb)
                energy = float(0.5 * reduced * ((vb - va) @ patches.normal[row]) ** 2)
            if energy < self.settings.least_energy or t2 - self._last_impact.get(pair, -math.inf) < self.settings.refractory:
                continue
            self._last_impact[pair] = t2
            x, y, z = patches.centre[row].tolist()
            nx, ny, nz = patches.normal[row].tolist()
            impacts.append(
                Impact(pair, t2, ((x, y, z), (x, y, z)), (nx, ny, nz), energy, min(energy / self.settings.full_energy, 1.0))
            )
        return tuple(impacts)


def contact_set(pairs: IntArray, patches: PairPatches, rows: IntArray, patch_points: bool) -> ContactSet:
    """Contacts of touching ``pairs`` (n, 2), whose patches are ``rows`` (n,): one each at the centre, or one per point of the patch."""
    repeats = np.ones(len(rows), dtype=np.int64)
    if patch_points:
        repeats = np.array([len(patches.corners[row]) for row in rows.tolist()], dtype=np.int64)
    row = np.repeat(rows, repeats)
    points = np.concatenate([patches.corners[k] for k in rows.tolist()] or [np.zeros((0, 3))]) if patch_points else patches.centre[row]
    normal, distance = patches.normal[row], patches.distance[row]
    gap = normal * (distance / 2)[:, None]
    share = 1.0 / np.repeat(repeats, repeats)
    return ContactSet(
        pairs=np.repeat(pairs, repeats, axis=0),
        positions=np.stack([points - gap, points + gap], axis=1),
        normal=normal,
        depth=np.maximum(-distance, 0.0),
        distance=distance,
        area=patches.area[row] * share,
        share=share,
        transmission=np.zeros(len(row), dtype=np.int64),
    )
