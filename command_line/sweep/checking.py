"""Check of a study against its scenes before tracing."""

from __future__ import annotations

from itertools import zip_longest

from bpy.types import Scene

from ..trace import open_file, start_blender
from .study import SweepStudy
from .task import frames_of, vary


def check(study: SweepStudy) -> float:
    """Set every value once in every scene. Returns the size of the tracks of all variants in bytes.

    Raises ValueError with the scene and the missing item, or the value that is out of range.
    """
    start_blender()
    size = 0.0
    for path in study.scenes:
        scene = open_file(str(path))
        try:
            _check_values(scene, study)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
        first, last = frames_of(scene, {"frames": study.frames})
        listeners = sum(obj.haptics.listener.enabled for obj in scene.objects)
        size += (
            BYTES_PER_SECOND * listeners * (last - first) * scene.render.fps_base / scene.render.fps
        )
    return size * study.count / len(study.scenes)


BYTES_PER_SECOND = 4 * 8000
"""Data rate of a listener's track."""


def _check_values(scene: Scene, study: SweepStudy) -> None:
    ranges = {**study.settings, **study.random}
    for values in zip_longest(*ranges.values(), fillvalue=None):
        settings = {
            path: value for path, value in zip(ranges, values, strict=True) if value is not None
        }
        vary(scene, {"mode": None, "settings": settings, "materials": {}})
    for materials in zip_longest(*study.materials.values(), fillvalue=None):
        made_of = {
            name: material
            for name, material in zip(study.materials, materials, strict=True)
            if material is not None
        }
        vary(scene, {"mode": None, "settings": {}, "materials": made_of})
