"""The haptic roles of objects, independent of the core, because panels and handlers need them in
every scene."""

from __future__ import annotations

from collections.abc import Iterable

from bpy.types import Object, Scene

from ..blender.compatibility import is_animated
from ..changes import revisions

_SWITCHES = frozenset({"haptics.enabled", "haptics.source.enabled", "haptics.listener.enabled"})


def is_tagged(obj: Object) -> bool:
    """True if the object has any haptic role, or if its animation switches one on and off."""
    haptics = obj.haptics
    if haptics.enabled or haptics.source.enabled or haptics.listener.enabled:
        return True
    return is_animated(obj, _SWITCHES)


def solo_roles(objects: Iterable[Object]) -> frozenset[str]:
    """The roles, "source" and "listener", with at least one solo object."""
    roles = "source", "listener"
    found = {
        role
        for obj in objects
        for role in roles
        if getattr(obj.haptics, role).enabled and getattr(obj.haptics, role).solo
    }
    return frozenset(found)


def is_silenced(obj: Object, role: str, solo: frozenset[str]) -> bool:
    """Whether a source or listener is muted, or not solo while others are (``solo``)."""
    properties = getattr(obj.haptics, role)
    return properties.muted or (role in solo and not properties.solo)


_untagged: dict[int, int] = {}
"""The last revision without a tagged object, by session id of the scene."""


def is_any_tagged(scene: Scene) -> bool:
    """True if an object of the scene has a role. A negative result is cached until a change."""
    if _untagged.get(scene.session_uid) == revisions.authored():
        return False
    if any(map(is_tagged, scene.objects)):
        return True
    _untagged[scene.session_uid] = revisions.authored()
    return False


def haptic_carrier(obj: Object | None) -> Object | None:
    """The object itself if it is haptic, else its nearest haptic ancestor, else None; for an
    armature the haptic body that it moves."""
    while obj is not None and not obj.haptics.enabled:
        body = obj.haptics.body
        obj = body if body is not None and body.haptics.enabled else obj.parent
    return obj
