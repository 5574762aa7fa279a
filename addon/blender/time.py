"""Frames and seconds of a scene, and whether its timeline plays."""

from __future__ import annotations

import bpy
from bpy.types import Scene

from ...core.frozen import frozen


@frozen
class Moment:
    """A frame of a scene's timeline; ``is_whole``: not between two frames."""

    frame: int
    is_whole: bool

    @classmethod
    def of(cls, scene: Scene) -> Moment:
        """The current one."""
        return cls(scene.frame_current, scene.frame_subframe == 0)


def frame_seconds(scene: Scene) -> float:
    """Duration of a frame [s]."""
    return scene.render.fps_base / scene.render.fps


def seconds_of(scene: Scene, frame: float) -> float:
    """Time of a frame in seconds from the scene's first frame."""
    return (frame - scene.frame_start) * scene.render.fps_base / scene.render.fps


def stretching(scene: Scene) -> float:
    """Frames of the timeline in which a frame of the animation passes, see *Time Stretching*."""
    return float(scene.render.frame_map_new / scene.render.frame_map_old)


def is_playing() -> bool:
    """True while the timeline plays in the context's screen."""
    screen = bpy.context.screen
    return screen is not None and screen.is_animation_playing


def is_playing_anywhere() -> bool:
    """True while the timeline plays in any window; callable from timers, which have no screen."""
    return any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)
