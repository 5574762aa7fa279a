"""The result of the reader: one frame of a scene in values of the core."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from ...core.arrays import FloatArray
from ...core.contacts.settings import Body, ContactSettings
from ...core.contacts.surface_shape import SurfaceShape
from ...core.frozen import frozen
from ...core.scene.values import HapticObject, Listener, Settings, Source
from .problem import Problem


@frozen
class Reading:
    """One frame of a scene of Blender, in values of the core.

    Attributes:
        objects, bodies: the n haptic objects, and these as the tracker's bodies.
        transforms: (n, 4, 4) of these in the world, rigid: the scale is in the bodies' shapes.
        sources, listeners: at their positions in this frame; temporary sources only while they
            sound.
        settings, contact_settings: of propagation, and of contacts and impacts.
        problems: for the designer to fix.
        hulls: shapes of the objects, by name, whose convex hull deviates from their surface.
        moving_instances: number of instances read again in this frame, and how long that took [ms].
        rebuilt: how long reading a changed surface took the last time [ms], by name of the object.
    """

    objects: tuple[HapticObject, ...]
    bodies: tuple[Body, ...]
    transforms: FloatArray
    sources: tuple[Source, ...]
    listeners: tuple[Listener, ...]
    settings: Settings
    contact_settings: ContactSettings
    problems: tuple[Problem, ...]
    hulls: Mapping[str, SurfaceShape] = field(default_factory=dict)
    moving_instances: tuple[int, float] | None = None
    rebuilt: Mapping[str, float] = field(default_factory=dict)
