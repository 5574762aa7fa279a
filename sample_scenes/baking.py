"""Rigid bodies baked into the file, so that it plays the same from any frame on."""

from __future__ import annotations

from collections.abc import Callable

import bpy
from bpy.types import Scene

from ..addon.changes.suspension import suspended


def bake_rigid_bodies(scene: Scene, progress: Callable[[int], None] = lambda frame: None) -> None:
    """Simulate all frames of the scene that the window shows and keep the result in its cache; ``progress`` is told every frame.

    A scene without a rigid body world is left alone.
    """
    if scene.rigidbody_world is None:
        return
    cache = scene.rigidbody_world.point_cache
    with suspended():
        for frame in range(cache.frame_start, cache.frame_end + 1):
            scene.frame_set(frame)
            progress(frame)
        with bpy.context.temp_override(scene=scene, point_cache=cache):
            bpy.ops.ptcache.bake_from_cache()
        scene.frame_set(scene.frame_start)
