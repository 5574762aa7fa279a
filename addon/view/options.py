"""Drawing options of a scene."""

from __future__ import annotations

from bpy.types import Scene

from ...core.render.frame_result import FrameResult
from ..blender.full_names import object_named
from .render_data import Options
from .watched import active_name, watched


def options_of(scene: Scene, result: FrameResult) -> Options:
    """The scene's options, with the selected sources and listeners, and the chosen row of the panel
    Path highlighted."""
    haptics = scene.haptics
    listener = watched(scene)
    active = active_name()
    return Options(
        show_intra=haptics.show_intra,
        show_best_paths=haptics.show_best_paths,
        labelled=None if haptics.show_labels else listener,
        sources=frozenset(source.name for source in result.sources if _is_selected(source.name)),
        listeners=frozenset(
            listener.name for listener in result.listeners if _is_selected(listener.name)
        ),
        highlight=(listener, active) if listener and active in result.objects else None,
    )


def _is_selected(full_name: str) -> bool:
    obj = object_named(full_name)
    return obj is not None and obj.select_get()
