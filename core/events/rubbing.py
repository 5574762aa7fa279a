"""Temporary sources of sliding and rolling contacts.

The sliding speed of a contact is the relative speed of its two material points along the surface,
including rotation about the normal. The rolling speed is the rate of the relative rotation about
the other axes (less than half a turn per frame) times the distance from the contact to the middle
of the faster rotating body; the other body is assumed flat. Rolling bodies creep slightly even
without slip.

The phase of a contact's tone is a function of the path length over the surface. To limit the
dependence on earlier frames, the length is accumulated in blocks of frames, from zero in each. The
fraction of a cycle that remains from the block before is added as a phase offset, which decreases
to zero over the block. The tone is therefore continuous across blocks with an error of at most half
a cycle per block, and a frame depends only on its own block and the one before: tracing from any
earlier frame gives identical bits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from hashlib import blake2b

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts.body_table import STILL
from ..contacts.contact_set import ContactSet
from ..contacts.forces import contact_forces
from ..contacts.motion import spins
from ..contacts.settings import Body, ContactSettings, Motion
from ..contacts.tracker import FrameContacts
from ..frozen import frozen
from ..scene.rule_table import RuleTable
from ..scene.texture import Texture
from ..scene.values import Source
from ..unchanged import Unchanged
from .frame import EXACT_FRAMES, Frame

CREEP = 0.02
"""Part of the rolling speed up to which bodies creep without slipping: wheels on rails slip from a
creep of one or two per cent on."""

_PIVOT = 2.0 / 3.0
"""Mean distance of the points of a disc from its middle, relative to its radius: the sliding speed
of a disc that turns on the spot."""


_NAMES = ("{0} sliding on {1}", "{1} sliding on {0}"), ("{0} rolling on {1}", "{1} rolling on {0}")
"""Names of sliding and rolling sources in even and in odd frames: a source plays for two frames and
overlaps the next one."""


@frozen
class _Moving:
    """A contact that slides or rolls in a frame.

    Attributes:
        rows: numbers of both bodies.
        names: of these bodies.
        positions: of the contact node on either body [m, world].
        speeds: of sliding and of rolling [m/s].
        force: normal force [N], NaN if unknown.
    """

    rows: tuple[int, int]
    names: tuple[str, str]
    positions: tuple[list[float], list[float]]
    speeds: tuple[float, float]
    force: float


@frozen
class FrameRubbing:
    """Sliding and rolling contacts of one frame.

    Attributes:
        number: of the frame.
        start: time at which it begins [s].
        step: its duration [s].
        moving: the contacts that slide or roll.
        paths: by names of both bodies and whether it rolls: length of the path over the surface [m]
            within this block of frames, and within the whole block before.
        last: sources of the frame before.
    """

    number: int = 0
    start: float = 0.0
    step: float = 0.0
    moving: tuple[_Moving, ...] = ()
    paths: Mapping[tuple[str, str, bool], tuple[float, float]] = field(default_factory=dict)
    last: tuple[Source, ...] = ()

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Numbers of the bodies that move along each other."""
        return tuple(item.rows for item in self.moving)


class Rubbing:
    """Follows sliding and rolling from frame to frame. Path lengths begin at zero again in each
    block of `EXACT_FRAMES`; blocks end at frames whose number is a multiple of it."""

    def __init__(self) -> None:
        self._middles = Unchanged(_middles)
        self.clear()

    def clear(self) -> None:
        """Drop all state."""
        self._before: Frame | None = None
        self._paths: dict[tuple[str, str, bool], tuple[float, float]] = {}  # as in `FrameRubbing`
        self._now = FrameRubbing()
        self._sources: tuple[Source, ...] = ()

    def snapshot(self) -> FrameRubbing | None:
        """State after the last frame, for `restore`; None without sliding or rolling."""
        return self._now if self._now.moving or self._now.last else None

    def restore(self, kept: FrameRubbing | None) -> None:
        """Return to the state after the frame ``kept``."""
        self._now = kept or FrameRubbing()
        self._paths = dict(self._now.paths)

    def history(self) -> str:
        """The state that later frames depend on, except poses."""
        return repr(
            (
                sorted(self._paths.items()),
                [(source.name, source.onset, source.amplitude) for source in self._sources],
            )
        )

    def follow(
        self, frame: Frame, since: float | None, found: FrameContacts, settings: ContactSettings
    ) -> tuple[Source, ...]:
        """The sources of a ``frame`` with the contacts ``found`` in it; ``since``: time of the
        frame before [s], None without one."""
        if not settings.textures.rows or not frame.bodies:  # whose contacts are given
            self.clear()
            return ()
        before, self._before = self._before, frame
        if since is not None:
            self._now = FrameRubbing()
            if before is not None:
                self._advance(frame, since, before, found.contacts, settings)
        self._sources = self._of_frame(frame.bodies, settings.textures)
        return self._sources

    def _advance(
        self,
        frame: Frame,
        since: float,
        before: Frame,
        contacts: ContactSet,
        settings: ContactSettings,
    ) -> None:
        """Advance to a ``frame`` from that ``before``, at the time ``since`` [s]."""
        now, then = frame.placed, before.placed
        if before.bodies != frame.bodies or frame.anew:
            old = {
                body.name: pose
                for body, pose in zip(before.bodies, then, strict=True)
                if body.name not in frame.anew
            }
            then = np.array(
                [old.get(body.name, pose) for body, pose in zip(frame.bodies, now, strict=True)]
            ).reshape(-1, 4, 4)
        step = frame.time - since
        if (frame.number - 1) % EXACT_FRAMES == 0:
            self._paths = {key: (0.0, path) for key, (path, _) in self._paths.items() if path}
        middles = self._middles(frame.bodies)
        placing = _BodyPoses(then, now, _placed(then, middles), _placed(now, middles), step)
        moving = _moving_contacts(frame.bodies, contacts, placing, settings)
        for item in moving:
            for rolls, speed in zip((False, True), item.speeds, strict=True):
                if speed:
                    key = *item.names, rolls
                    path, earlier = self._paths.get(key, (0.0, 0.0))
                    self._paths[key] = path + speed * step, earlier
        last = tuple(source for source in self._sources if source.onset > since - 1.5 * step)
        self._now = FrameRubbing(frame.number, since, step, moving, dict(self._paths), last)

    def _of_frame(self, bodies: Sequence[Body], textures: RuleTable[Texture]) -> tuple[Source, ...]:
        """The sources of the last frame, by the materials of ``bodies`` and by these rules."""
        new = [source for item in self._now.moving for source in self._of(item, bodies, textures)]
        there = {item.names: item.positions for item in self._now.moving}
        last = [
            source.moved(*there[pair])
            if (pair := (source.object, source.second_object or "")) in there
            else source
            for source in self._now.last
        ]
        return (*last, *new)

    def _of(
        self, item: _Moving, bodies: Sequence[Body], textures: RuleTable[Texture]
    ) -> list[Source]:
        now, (first, second) = self._now, item.rows
        texture = textures.of(bodies[first].named, bodies[second].named)
        found = []
        for rolls, speed in zip((False, True), item.speeds, strict=True):
            amplitude = (
                texture.amplitude(speed, item.force, rolls)
                if texture is not None and speed
                else 0.0
            )
            if texture is None or not amplitude:
                continue
            name = _NAMES[rolls][now.number % 2].format(*item.names)
            seed = int.from_bytes(
                blake2b(f"{name}\0{now.number}".encode(), digest_size=6).digest(), "big"
            )
            signal = texture.piece(
                speed, self._cycles(item, rolls, speed, texture.period), now.step, seed
            )
            source = Source(
                name,
                item.names[0],
                amplitude=amplitude,
                signal=signal,
                second_object=item.names[1],
                onset=now.start,
            )
            found.append(source.moved(*item.positions))
        return found

    def _cycles(self, item: _Moving, rolls: bool, speed: float, period: float) -> float:
        """Phase of the tone, in cycles, in the middle of a piece, half a frame before its end."""
        path, earlier = self._now.paths[(*item.names, rolls)]
        left = earlier / period
        part = ((self._now.number - 1) % EXACT_FRAMES + 1) / EXACT_FRAMES
        return (path - speed * self._now.step / 2) / period + (left - round(left)) * (1.0 - part)


def _middles(bodies: Sequence[Body]) -> FloatArray:
    """The middles (n, 3) of the bounds of bodies, in their own space."""
    return np.array([body.shape.local_bounds.mean(axis=0) for body in bodies]).reshape(-1, 3)


@frozen
class _BodyPoses:
    """Transforms (n, 4, 4) of bodies and the places (n, 3) of their middles, ``before`` and
    ``now``, ``step`` seconds later."""

    before: FloatArray
    now: FloatArray
    middle_before: FloatArray
    middle: FloatArray
    step: float


def _moving_contacts(
    bodies: Sequence[Body], contacts: ContactSet, poses: _BodyPoses, settings: ContactSettings
) -> tuple[_Moving, ...]:
    """The touching pairs with a texture that move along each other."""
    moved = (poses.before != poses.now).any(axis=(1, 2))
    rows = np.flatnonzero(moved[contacts.pairs].any(axis=1))
    passing = set(map(frozenset, settings.passing))
    textured = [
        bodies[a].struck_in & bodies[b].struck_in
        and {bodies[a].name, bodies[b].name} not in passing
        and settings.textures.of(bodies[a].named, bodies[b].named) is not None
        for a, b in contacts.pairs[rows].tolist()
    ]
    rows = rows[np.array(textured, dtype=np.bool_)]
    speeds = np.stack(_surface_speeds(contacts, rows, poses))
    speeds = np.where(speeds * poses.step > STILL, speeds, 0.0)
    rows = rows[speeds.any(axis=0)]
    speeds = speeds[:, speeds.any(axis=0)]
    if len(rows) == 0:
        return ()
    forces = _forces(bodies, contacts, rows, poses.middle, settings.gravity).tolist()
    found = zip(
        contacts.pairs[rows].tolist(),
        contacts.positions[rows].tolist(),
        speeds.T.tolist(),
        forces,
        strict=True,
    )
    return tuple(
        _Moving((a, b), (bodies[a].name, bodies[b].name), (first, second), (slides, rolls), force)
        for (a, b), (first, second), (slides, rolls), force in found
    )


def _surface_speeds(
    contacts: ContactSet, rows: IntArray, poses: _BodyPoses
) -> tuple[FloatArray, FloatArray]:
    """Speeds (k,) of sliding and of rolling at contacts ``rows`` [m/s], seen from the bodies that
    turn less."""
    pairs = contacts.pairs[rows]
    rates = [
        np.linalg.norm(spins(_rows(poses.before[body]), _rows(poses.now[body]), poses.step), axis=0)
        for body in pairs.T
    ]
    faster = np.where(rates[0] >= rates[1], 0, 1)
    body, base = (
        np.take_along_axis(pairs, side[:, None], axis=1)[:, 0] for side in (faster, 1 - faster)
    )
    before = poses.before[base, :3, :3].swapaxes(1, 2)
    now = poses.now[base, :3, :3].swapaxes(1, 2)
    spin = spins(
        _rows(before @ poses.before[body, :3, :3]), _rows(now @ poses.now[body, :3, :3]), poses.step
    ).T
    place_before = _turned(before, poses.middle_before[body] - poses.middle_before[base])
    travel = _turned(now, poses.middle[body] - poses.middle[base]) - place_before
    arm = _turned(now, contacts.positions[rows, faster] - poses.middle[body])
    normal = _turned(now, contacts.normal[rows])
    pivot = _PIVOT * np.sqrt(contacts.area[rows] / np.pi) * _dot(spin, normal)
    slip = np.hypot(
        np.linalg.norm(_tangential(travel / poses.step + np.cross(spin, arm), normal), axis=1),
        pivot,
    )
    roll = np.linalg.norm(_tangential(spin, normal), axis=1) * np.abs(_dot(arm, normal))
    return np.maximum(slip - CREEP * roll, 0.0), roll


def _forces(
    bodies: Sequence[Body],
    contacts: ContactSet,
    rows: IntArray,
    middle: FloatArray,
    gravity: tuple[float, float, float],
) -> FloatArray:
    """The forces (k,) of some contacts [N]: those of resting bodies; where that can't be known, the
    weight of the lighter of the two that move and have a mass; NaN where neither does, and without
    gravity.

    Args:
        bodies: all of them.
        contacts: all between them.
        rows: numbers of those contacts (k,).
        middle: of each body (n, 3) [m, world].
        gravity: [m/s^2].
    """
    strength = math.hypot(*gravity)
    if not strength:
        return np.full(len(rows), np.nan)
    mass = np.array([body.mass or 0.0 for body in bodies])
    held = np.array([body.motion is not Motion.DYNAMIC or body.medium for body in bodies])
    asked = np.zeros(len(contacts), dtype=np.bool_)
    asked[rows] = True
    pressed = contact_forces(contacts, np.where(held, 0.0, mass), middle, gravity, asked)[rows]
    weighs = (mass > 0) & np.array([body.motion is not Motion.STATIC for body in bodies])
    lighter = np.fmin.reduce(np.where(weighs, mass, np.nan)[contacts.pairs[rows]], axis=1)
    return np.where(np.isfinite(pressed), pressed, lighter * strength)


def _placed(transforms: FloatArray, points: FloatArray) -> FloatArray:
    """World positions (n, 3) of a point of each body."""
    return _turned(transforms[:, :3, :3], points) + transforms[:, :3, 3]


def _turned(rotations: FloatArray, vectors: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("nij,nj->ni", rotations, vectors))


def _rows(rotations: FloatArray) -> FloatArray:
    """Rotations in the upper left of matrices (k, 3, 3) or (k, 4, 4), as `spins` takes them, (9,
    k)."""
    return rotations[:, :3, :3].reshape(-1, 9).T


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("ki,ki->k", a, b))


def _tangential(vectors: FloatArray, normal: FloatArray) -> FloatArray:
    return vectors - _dot(vectors, normal)[:, None] * normal
