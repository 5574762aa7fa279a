"""Export for an engine: a glTF file, the haptic scene with the same names, and a baked pack."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import bpy

from ...core.formats.haptic_scene import write_export
from ...core.formats.io.atomic import staging
from ...core.formats.io.json_text import write_compact
from ...core.forms import Form
from ...core.run_time.pack import PackRecorder
from ...core.scene.values import HapticScene, SourceKind
from ..blender.words import TranslatedError
from ..changes.suspension import suspended
from ..session import session, timeline
from . import gltf
from .frame_scene import written_export, written_frame
from .written_objects import WrittenObjects

ENDINGS = (".glb", ".json", ".pack.json")
"""Endings of the files, which have one name."""


class EngineExport:
    """The export of the frames ``start`` to ``end`` of ``scene`` to files in the place of ``path``,
    each with its own ending: `steps`, then `write`, which does not access Blender's data.

    ``packed``: with a baked pack.
    """

    def __init__(
        self, scene: bpy.types.Scene, start: int, end: int, path: Path, packed: bool
    ) -> None:
        self.scene, self.start, self.end, self._path = scene, start, end, path
        self._pack = PackRecorder() if packed else None
        self._first: HapticScene | None = None
        self._folder = tempfile.TemporaryDirectory()
        self._files: list[Path] = []
        self._origin: Form = {}

    def steps(self) -> Iterator[int]:
        """Trace the frames, then write glTF file and scene into a temporary folder; yields the
        number of each frame. Raises ValueError, with a message for the user."""
        with closing(timeline.steps(self.scene, self.start, self.end)) as steps:
            for step in steps:
                if self._first is None:
                    reading = session.of(self.scene).reading
                    assert reading is not None  # the frame was traced
                    objects = WrittenObjects().of(reading)
                    written = written_frame(step.result, reading, self.scene, objects)
                    self._first = _authored(written)
                if self._pack is not None:
                    self._pack.add(step.result)
                yield step.result.number
        assert self._first is not None
        name = self._path.name
        model, scene = (Path(self._folder.name) / f"{name}{ending}" for ending in ENDINGS[:2])
        export = written_export(name, self.scene, self._first)
        self._origin = gltf.origin = export.provenance
        try:
            with suspended():
                self._write_model(model)
        finally:
            gltf.origin = None
        write_export(export, scene)
        self._files = [model, scene]

    def _write_model(self, path: Path) -> None:
        """The scene as glTF, with everything that moves as one animation."""
        scene = self.scene
        before = scene.frame_start, scene.frame_end, scene.frame_current
        try:
            scene.frame_start, scene.frame_end = self.start, self.end
            scene.frame_set(self.start)
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

    def write(self) -> tuple[Path, ...]:
        """Write the files, and return their paths. Raises ValueError or OSError."""
        with self._folder, staging(self._path.parent) as stage:
            files = [Path(shutil.copy(file, stage.folder)) for file in self._files]
            if self._pack is not None:
                assert self._first is not None
                pack = stage.folder / f"{self._path.name}{ENDINGS[2]}"
                document = self._pack.document(self._first) | {"provenance": self._origin}
                files.append(write_compact(pack, document))
            stage.commit(files)
            return tuple(stage.targets(files))


def _authored(scene: HapticScene) -> HapticScene:
    """A written frame without the sources of blows, sliding and rolling, which a run makes by
    itself."""
    return replace(
        scene,
        sources=tuple(
            item
            for item in scene.sources
            if item.kind is not SourceKind.TEMPORARY and not item.rubs
        ),
    )
