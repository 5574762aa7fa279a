"""The result of the reader: one frame of a scene in values of the core."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ...core.arrays import FloatArray
from ...core.contacts.authored import AuthoredContacts
from ...core.contacts.settings import Body, ContactSettings
from ...core.scene.values import HapticObject, Listener, Settings, Source
from .problem import Problem
from .world_transforms import pose_of


@dataclass(frozen=True, slots=True)
class Reading:
    """One frame of a scene. ``transforms`` (n, 4, 4) of ``objects`` are rigid: the scale is in the bodies' shapes. ``settled``: the names
    of those that have not moved since their import; ``authored``: the imported contacts, None without any."""

    objects: tuple[HapticObject, ...]
    bodies: tuple[Body, ...]
    transforms: FloatArray
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings
    contact_settings: ContactSettings
    problems: tuple[Problem, ...]
    settled: frozenset[str] = frozenset()
    authored: AuthoredContacts | None = None

    def posed_objects(self) -> tuple[HapticObject, ...]:
        """The objects with the shape and pose that they have in this frame."""
        return tuple(
            replace(item, shape=body.shape, pose=pose_of(transform))
            for item, body, transform in zip(self.objects, self.bodies, self.transforms, strict=True)
        )
