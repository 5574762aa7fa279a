"""Panel "Export", entries in File > Export and File > Import, exporters of collections, and files
dropped into the viewport."""

from __future__ import annotations

from bpy.types import Context, FileHandler, Menu, UILayout

from ...core.formats.io.catalogue import readers, track_formats
from ..blender import job
from ..blender.words import show, ui_text
from ..io import last_export
from ..properties.sound import SOUNDS
from .drawing import ScenePanel, draw_more

MOST_SHOWN, MOST_TIMES = 12, 4
"""Listeners, and onsets of a listener, that are shown."""
POOR = 3.0
"""Change of level (dB) from which a listener is marked."""


class HAPTIC_PT_export(ScenePanel):
    bl_label = "Export"

    def draw(self, context: Context) -> None:
        layout = self.layout
        if job.draw_running(layout):
            return
        _draw_losses(layout)


def _draw_losses(layout: UILayout) -> None:
    """Draw what each listener loses in the files of the last export, those who lose most first."""
    done = last_export.written
    if done is None or done.fidelity is None:
        return
    column = layout.box().column(align=True)
    show(column, ui_text("Lost in {}", done.files[0].name))
    for listener in done.fidelity.listeners[:MOST_SHOWN]:
        row = column.row()
        row.alert = abs(listener.level) > POOR or bool(listener.missing or listener.invented)
        show(row, listener.name)
        show(row, f"{listener.level:+z.1f} dB")
        for text, times in (
            (ui_text("Missing onsets: {}"), listener.missing),
            (ui_text("Invented onsets: {}"), listener.invented),
        ):
            if times:
                show(column, text.format(len(times)), "ERROR")
                shown = ", ".join(f"{time:.2f}" for time in times[:MOST_TIMES])
                more = " …" if times[MOST_TIMES:] else ""
                show(column, f"{shown} s{more}", "BLANK1")
    draw_more(column, len(done.fidelity.listeners) - MOST_SHOWN)


class HAPTIC_FH_scene(FileHandler):
    """Haptic scenes"""

    bl_label = "Haptic Scene"
    bl_import_operator = "haptic.drop_scene"
    bl_export_operator = "export_scene.haptic_scene"
    bl_file_extensions = ".json;.gz"

    @classmethod
    def poll_drop(cls, context: Context) -> bool:
        return _in_viewport(context)


class _OntoObject:
    """Drops on the viewport that need an active object."""

    @classmethod
    def poll_drop(cls, context: Context) -> bool:
        return _in_viewport(context) and context.object is not None


class HAPTIC_FH_tracks(_OntoObject, FileHandler):
    """Haptic tracks for export; on import, vibrations as signals"""

    bl_label = "Haptic Tracks"
    bl_import_operator = "haptic.import_signal"
    bl_export_operator = "export_scene.haptic_tracks"

    @classmethod
    def complete(cls) -> None:
        """Before its registration: the files follow from the formats that there are."""
        cls.bl_file_extensions = ";".join(readers())


class HAPTIC_FH_sound(_OntoObject, FileHandler):
    """Sounds, whose vibration the active object emits"""

    bl_label = "Sound to Vibration"
    bl_import_operator = "haptic.import_sound"
    bl_file_extensions = ";".join(SOUNDS)


def _in_viewport(context: Context) -> bool:
    return context.area is not None and context.area.type == "VIEW_3D"


def draw_export(self: Menu, context: Context) -> None:
    """Entries of File > Export."""
    self.layout.operator("export_scene.haptic_scene", text="Haptic Scene (.json)")
    endings = "/".join(form.suffix for form in track_formats().values())
    _draw_entry(self.layout, "export_scene.haptic_tracks", ui_text("Haptic Tracks"), endings)


def draw_import(self: Menu, context: Context) -> None:
    """Entries of File > Import."""
    _draw_entry(
        self.layout,
        "haptic.import_signal",
        ui_text("Haptic Signal for the Active Object"),
        "/".join(readers()),
    )
    title = ui_text("Sound for the Active Object")
    _draw_entry(self.layout, "haptic.import_sound", title, "/".join(SOUNDS))


def _draw_entry(layout: UILayout, operator: str, title: str, endings: str) -> None:
    """Draw an entry of a menu of files."""
    layout.operator(operator, text=f"{title} ({endings})", translate=False)
