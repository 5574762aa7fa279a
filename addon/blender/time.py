"""Frames and seconds of a scene."""

from __future__ import annotations

from bpy.types import Scene


def frame_seconds(scene: Scene) -> float:
    """Duration of a frame [s]."""
    return scene.render.fps_base / scene.render.fps


def seconds_of(scene: Scene, frame: float) -> float:
    """Time of a frame in seconds from the scene's first frame."""
    return (frame - scene.frame_start) * scene.render.fps_base / scene.render.fps
