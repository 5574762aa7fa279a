"""What is known of a scene at one frame: the input of every stage."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ..arrays import FloatArray
from ..contacts.authored import AuthoredContacts
from ..contacts.contact_set import ContactSet
from ..contacts.impacts import Impact
from ..contacts.known_motion import KnownMotion
from ..contacts.settings import Body
from ..frozen import frozen
from ..scene.values import HapticObject, Listener, Settings, Source

EXACT_FRAMES = 32
"""Frames whose number is a multiple of this are `Frame.exact`: later frames can be traced from
there with bit-identical results."""


@frozen
class Frame:
    """The state of a scene at one frame.

    ``time`` [s]; the tracer renders the samples from the previous frame's time to this one's, so
    that an impact between the two is placed at its time. ``continuous``: this frame follows the one
    traced last; otherwise contact history, velocities and active signals are dropped.
    ``transforms`` (n, 4, 4): rigid, of the ``objects`` in the world; None where they are unknown.
    Contacts are found between ``bodies``, which are the first of the objects in the same order; or
    ``contacts`` are given, which number the objects by their sorted names. ``authored`` contacts
    replace detected ones. ``restore``: where this frame is not continuous, it has the
    impacts stored when it was last traced as a continuous one, see `core.collisions`. ``exact``:
    contacts and gains are recomputed also after motions below the tolerance of rest. ``duration``
    [s]: of a frame that is not continuous, for triggers at given times. ``heard``: its samples are
    rendered. ``struck``: the impacts since the previous frame, which number the objects; None: they
    are found. ``anew``: names of bodies that appeared or were set elsewhere since the previous
    frame, without a motion in between: they make no impact in this frame. ``motion``: known of some
    bodies since the previous frame.
    """

    number: int
    time: float
    objects: tuple[HapticObject, ...]
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings = field(default_factory=Settings)
    bodies: tuple[Body, ...] = ()
    transforms: FloatArray | None = None
    contacts: ContactSet | None = None
    continuous: bool = True
    authored: AuthoredContacts | None = None
    restore: bool = False
    exact: bool = False
    duration: float = 0.0
    heard: bool = True
    struck: tuple[Impact, ...] | None = None
    anew: frozenset[str] = frozenset()
    motion: KnownMotion | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the objects."""
        return tuple(item.name for item in self.objects)

    @property
    def placed(self) -> FloatArray:
        """The transforms of the bodies."""
        return (
            np.zeros((0, 4, 4)) if self.transforms is None else self.transforms[: len(self.bodies)]
        )
