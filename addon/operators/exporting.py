"""File > Export: haptic scenes and haptic tracks, also as collection exporters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event, UILayout
from bpy_extras.io_utils import ExportHelper

from ...core.declaration import Declaration, Number
from ...core.formats import haptic_scene, registry
from ...core.formats.io.catalogue import SCENE, Format, Value, named, track_formats
from ..bake import playback
from ..blender import job
from ..blender.polling import Action
from ..blender.single_precision import shortest
from ..blender.text import wrapped
from ..blender.words import TranslatedError, report_text, ui_text
from ..io import capture, frame_scene, last_export
from ..properties.declared import property_of
from ..properties.kinds import FRAMES, choice, switch, text, whole

if TYPE_CHECKING:
    from ...core.formats.export import Export

SCENE_ENDINGS = (".json.gz", ".json")
LINE = 34
"""Width of the file browser's sidebar in characters."""
MOST_REPORTED = 12


class RangeExport(ExportHelper):
    """Mixin: an export of a range of frames, optionally of one collection, with its losses shown beforehand."""

    # Those of the scene unless given: they are not kept for the next one.
    frame_start: whole("Start", "First frame", 1, FRAMES, options={"SKIP_SAVE"})
    frame_end: whole("End", "Last frame", 250, FRAMES, options={"SKIP_SAVE"})
    collection: text(
        "Collection", "Only the objects of this collection", options={"HIDDEN", "SKIP_SAVE"}
    )
    endings: Collection[str] = ()
    """File name endings; any of them is replaced by that of the chosen options."""

    def check(self, context: Context) -> bool:
        before: str = self.properties.filepath
        self.properties.filepath = with_ending(before, self.endings, self.filename_ext)
        return self.properties.filepath != before

    def invoke(self, context: Context, event: Event) -> set[str]:
        self._complete_range(context)
        return ExportHelper.invoke(self, context, event)

    def execute(self: Any, context: Context) -> set[str]:
        self._complete_range(context)
        return super().execute(context)

    def _complete_range(self, context: Context) -> None:
        for key in ("frame_start", "frame_end"):
            if not self.properties.is_property_set(key):
                setattr(self, key, getattr(context.scene, key))

    def names(self) -> Collection[str] | None:
        """The objects to export; None: all. Raises ValueError if the collection does not exist."""
        if not self.collection:
            return None
        collection = bpy.data.collections.get(self.collection)
        if collection is None:
            raise TranslatedError("There is no collection '{}'", self.collection)
        return {obj.name_full for obj in collection.all_objects}

    def captured(
        self,
        context: Context,
        recorded: bool,
        felt: bool,
        finish: Callable[[Export, job.Job], list[job.Report]],
    ) -> set[str]:
        """Step through the range, then ``finish``."""
        scene, start, end = context.scene, self.frame_start, self.frame_end
        track = None if recorded else playback.fitting_track(scene, start, end)
        work = capture.Capture(
            scene, start, end, recorded, felt, self.names(), None if track is None else track.result
        )
        name = export_name(self.filepath)
        return job.run(
            self,
            context,
            job.Job(
                "Exporting",
                work.frames,
                work.steps(),
                lambda running: finish(work.export(name), running),
            ),
        )

    def options_layout(self) -> UILayout:
        """The layout of the file browser's sidebar, with labels beside values."""
        layout: UILayout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        return layout

    def draw_range(self, layout: UILayout) -> None:
        column = layout.column(align=True)
        column.prop(self, "frame_start", text="Frame Start")
        column.prop(self, "frame_end")


class HAPTIC_OT_export_scene(RangeExport, Action):
    """Write the haptic objects, sources, listeners and contacts as a haptic scene"""

    bl_idname = "export_scene.haptic_scene"
    bl_label = "Export Haptic Scene"
    bl_options = {"PRESET"}
    endings = SCENE_ENDINGS

    filter_glob: StringProperty(default="*.json;*.json.gz", options={"HIDDEN"})
    frames: choice(
        "Frames",
        "What is written",
        (
            ("CURRENT", "This Frame", "The scene as it stands now"),
            (
                "RANGE",
                "Range",
                "The scene at the first frame, and what changes from frame to frame",
            ),
        ),
        default="CURRENT",
    )
    tracks: property_of(SCENE.options["tracks"])
    encoding: property_of(SCENE.options["encoding"])
    compressed: property_of(SCENE.options["compressed"])

    @property
    def filename_ext(self) -> str:
        return ".json.gz" if self.compressed else ".json"

    def draw(self, context: Context) -> None:
        layout = self.options_layout()
        layout.prop(self, "frames", expand=True)
        if self.frames == "RANGE":
            self.draw_range(layout)
            layout.prop(self, "tracks")
            if self.tracks != "none":
                layout.prop(self, "encoding")
        layout.prop(self, "compressed")
        draw_losses(
            layout,
            "scene",
            capture.expected(context.scene, self.frames == "RANGE"),
            self._options(),
        )

    def apply(self, context: Context) -> set[str]:
        if not self.filepath.lower().endswith(SCENE_ENDINGS):
            self.properties.filepath += self.filename_ext
        if self.frames == "RANGE":
            return self.captured(context, True, self.tracks != "none", self._writer())
        for kind, words in self._writer()(self._current(context), None):
            self.report(kind, words)
        return {"FINISHED"}

    def _current(self, context: Context) -> Export:
        scene = frame_scene.current_scene(context)
        names = self.names()
        scene = scene if names is None else frame_scene.within(scene, names)
        return frame_scene.written_export(export_name(self.filepath), context.scene, scene, names)

    def _writer(self) -> Callable[[Export, object], list[job.Report]]:
        """A function that writes the file after all frames are captured, independent of this
        operator, which then no longer exists."""
        path = Path(bpy.path.abspath(self.filepath))
        options = self._options()

        def write(export: Export, _: object) -> list[job.Report]:
            tracks = options["tracks"] if export.tracks is not None else "none"
            files = haptic_scene.write_export(
                export, path, tracks=tracks, encoding=options["encoding"]
            )
            return written(files, registry.losses("scene", export, options))

        return write

    def _options(self) -> dict[str, Any]:
        return {
            "tracks": self.tracks if self.frames == "RANGE" else "none",
            "encoding": self.encoding,
        }


def track_endings() -> tuple[str, ...]:
    """The file name endings of the formats of tracks."""
    return tuple(form.suffix for form in track_formats().values())


def option_properties(formats: Mapping[str, Format]) -> dict[str, Any]:
    """Annotations of an operator: ``<format>_<option>`` for every option of the formats."""
    return {
        f"{name}_{key}": property_of(option)
        for name, form in formats.items()
        for key, option in form.options.items()
    }


def chosen(operator: Any, name: str) -> dict[str, Value]:
    """The chosen options of a format."""
    return {
        key: _value(option, getattr(operator, f"{name}_{key}"))
        for key, option in named(name).options.items()
    }


def draw_options(layout: UILayout, operator: Any, name: str) -> None:
    """Draw the options of a format in a column."""
    for key in named(name).options:
        layout.prop(operator, f"{name}_{key}")


def _value(option: Declaration, value: Any) -> Value:
    if not isinstance(option, Number) or option.whole:
        return value
    return min(max(shortest(value), option.low), option.high)


class HAPTIC_OT_export_tracks(RangeExport, Action):
    """Write what the haptic listeners feel over a range of frames"""

    bl_idname = "export_scene.haptic_tracks"
    bl_label = "Export Haptic Tracks"
    bl_options = {"PRESET"}

    @classmethod
    def complete(cls) -> None:
        """Before its registration: its properties follow from the formats that there are."""
        formats = track_formats()
        cls.endings = track_endings()
        cls.__annotations__ = {
            "filter_glob": StringProperty(
                default=";".join(f"*{ending}" for ending in cls.endings), options={"HIDDEN"}
            ),
            "formats": choice(
                "Formats",
                "Where it will be felt; Shift adds a format",
                tuple(
                    (name, form.label, "", "NONE", 1 << number)
                    for number, (name, form) in enumerate(formats.items())
                ),
                default={"wav"},
                options={"ENUM_FLAG"},
            ),
            "absolute": switch(
                "Absolute Levels",
                "Keep the traced levels and every listener; else one gain uses the range, and who "
                "feels nothing is left out",
            ),
            **option_properties(formats),
        }

    @property
    def filename_ext(self) -> str:
        return named((*self._wanted(), "wav")[0]).suffix

    def draw(self, context: Context) -> None:
        layout = self.options_layout()
        column = layout.column(align=True)
        column.use_property_split = False
        column.props_enum(self, "formats")
        layout.prop(self, "absolute")
        self.draw_range(layout)
        export = capture.expected(context.scene, True, self.collection)
        for name in self._wanted():
            layout.label(text=named(name).label)
            draw_options(layout, self, name)
            draw_losses(layout, name, export, chosen(self, name))

    def _wanted(self) -> list[str]:
        """The chosen formats, in their order."""
        return [name for name in track_formats() if name in self.formats]

    def apply(self, context: Context) -> set[str]:
        folder = Path(bpy.path.abspath(self.filepath)).parent
        writers = [track_writer(name, folder, chosen(self, name)) for name in self._wanted()]
        if not writers:
            raise TranslatedError("Choose a format")
        absolute = self.absolute

        def write(export: Export, running: job.Job) -> list[job.Report]:
            clips, changes = (export, ()) if absolute else export.as_clips()
            reports: list[job.Report] = [({"INFO"}, words) for words in changes]
            return reports + [report for one in writers for report in one(clips, running)]

        return self.captured(context, False, True, write)


def track_writer(
    name: str, folder: Path, options: dict[str, Any]
) -> Callable[[Export, job.Job], list[job.Report]]:
    """A function that writes a format, and asks before files are replaced."""

    def write(export: Export, running: job.Job) -> list[job.Report]:
        def consent(new: registry.Written) -> bool:
            names = shown(new.replaced)
            if not new.is_poor or new.fidelity is None:
                return running.ask((ui_text("Replace {}?", names),))
            question = ui_text("The new files keep little of the vibration. Replace {}?", names)
            return running.ask((question, *new.fidelity.sentences()))

        done = registry.write(name, export, folder, options, consent, running.progress)
        if not done.files:
            return [({"WARNING"}, report_text("Nothing was replaced"))]
        last_export.written = done
        return written(done.files, done.losses)

    return write


def draw_losses(layout: UILayout, name: str, export: Export, options: dict[str, Any]) -> None:
    """Draw the losses of a format, or why it cannot be written."""
    try:
        losses = registry.losses(name, export, options)
    except ValueError as error:
        losses = (str(error).partition(": ")[2] or str(error),)
        heading = "Can't be written"
        icon = "ERROR"
    else:
        heading, icon = (
            ("Not in these files", "INFO") if losses else ("Everything is carried", "CHECKMARK")
        )
    box = layout.box()
    box.label(text=heading, icon=icon)
    for loss in losses:
        column = box.column(align=True)
        for line in wrapped(loss, LINE):
            column.label(text=line)


def written(files: Collection[Path], losses: Collection[str]) -> list[job.Report]:
    """The report on written files and their losses."""
    reports: list[job.Report] = [
        (
            {"INFO"},
            report_text(
                "Not in these files: {}" if len(files) > 1 else "Not in this file: {}", loss
            ),
        )
        for loss in losses
    ]
    return [*reports[:MOST_REPORTED], ({"INFO"}, report_text("Written: {}", shown(files)))]


def shown(files: Collection[Path]) -> str:
    """The names of the first three files, and the number of further ones."""
    names = [path.name for path in files]
    return ", ".join(names[:3]) + (
        " " + report_text("and {} more", len(names) - 3) if len(names) > 3 else ""
    )


def with_ending(path: str, known: Collection[str], ending: str) -> str:
    """``path`` with its known ending replaced by ``ending``."""
    if not path or path.endswith(("/", "\\")):
        return path
    has = next(
        (
            suffix
            for suffix in sorted(known, key=len, reverse=True)
            if path.lower().endswith(suffix)
        ),
        "",
    )
    return path[: len(path) - len(has)] + ending


def export_name(path: str) -> str:
    """The chosen name without its ending, from which file names are made, "haptics" without one."""
    return with_ending(Path(path).name, (*SCENE_ENDINGS, *track_endings()), "") or "haptics"
