"""Export for an engine: a glTF file, and the haptic scene and a tracer's tables with the same
names."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import bpy

from ...addon.blender.words import TranslatedError
from ...addon.changes.suspension import suspended
from ...addon.io.frame_scene import written_export, written_frame
from ...addon.io.written_objects import WrittenObjects
from ...addon.session import session, timeline
from ...core.formats.haptic_scene import write_export
from ...core.formats.io.atomic import staging
from ...core.scene.values import HapticScene, SourceKind
from . import gltf, tables


def write(scene: bpy.types.Scene, start: int, end: int, path: Path) -> list[Path]:
    """Write ``<path>.glb``, with everything that moves in the frames ``start`` to ``end``, and
    ``<path>.json`` and ``<path>.tracer.json``, the haptic scene of the first one and its tables.
    Raises ValueError, with a message for the user, or OSError."""
    authored = _authored_scene(scene, start)
    export = written_export(path.name, scene, authored)
    with staging(path.parent) as stage:
        model = stage.folder / f"{path.name}.glb"
        gltf.origin = export.provenance
        try:
            with suspended():
                _write_model(scene, start, end, model)
        finally:
            gltf.origin = None
        files = [model, *write_export(export, stage.folder / f"{path.name}.json")]
        files.append(tables.write(authored, stage.folder / f"{path.name}.tracer.json"))
        stage.commit(files)
        return stage.targets(files)


def _authored_scene(scene: bpy.types.Scene, frame: int) -> HapticScene:
    """The scene at a frame without the sources of blows, sliding and rolling, which a run makes by
    itself."""
    with closing(timeline.steps(scene, frame, frame)) as steps:
        result = next(steps).result
        reading = session.of(scene).reading
    assert reading is not None  # the frame was traced
    written = written_frame(result, reading, scene, WrittenObjects().of(reading))
    return replace(
        written,
        sources=tuple(
            item
            for item in written.sources
            if item.kind is not SourceKind.TEMPORARY and not item.rubs
        ),
    )


def _write_model(scene: bpy.types.Scene, start: int, end: int, path: Path) -> None:
    """The scene as glTF, with everything that moves as one animation."""
    before = scene.frame_start, scene.frame_end, scene.frame_current
    try:
        scene.frame_start, scene.frame_end = start, end
        scene.frame_set(start)
        bpy.ops.export_scene.gltf(
            filepath=str(path),
            export_format="GLB",
            export_apply=True,
            export_animation_mode="SCENE",
            export_anim_scene_split_object=False,
            export_anim_slide_to_zero=True,
            use_active_scene=True,
        )
    except (AttributeError, RuntimeError) as error:
        reason = str(error).strip().removeprefix("Error: ")
        raise TranslatedError("Blender's glTF exporter failed: {}", reason) from None
    finally:
        scene.frame_start, scene.frame_end = before[:2]
        scene.frame_set(before[2])
