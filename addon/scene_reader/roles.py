"""The haptic roles of objects. Needs nothing of the core: panels and handlers ask for them in every scene."""

from __future__ import annotations

from bpy.types import Object


def is_tagged(obj: Object) -> bool:
    """True where the object has any haptic role."""
    haptics = obj.haptics
    return haptics.enabled or haptics.source.enabled or haptics.listener.enabled


def haptic_carrier(obj: Object | None) -> Object | None:
    """The object itself if it is haptic, else its nearest haptic ancestor, else None; for an armature the haptic body that it moves."""
    while obj is not None and not obj.haptics.enabled:
        body = obj.haptics.body
        obj = body if body is not None and body.haptics.enabled else obj.parent
    return obj
