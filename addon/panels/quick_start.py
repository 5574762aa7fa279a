"""Panel "Quick Start": six steps from the user's own object to a vibration that is felt. The scene
says which are done, so that undo takes the tick back."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from bpy.types import AddonPreferences, Context

from ...core.scene.choices import SourceKind
from ..blender.time import is_playing
from ..io import last_export
from ..properties.preferences import preferences
from ..session import sessions
from ..view import watched
from .drawing import SidebarPanel

_OBJECTS = 3
"""Haptic objects of a scene up to which it is one that may be a newcomer's."""


class HAPTIC_PT_quick_start(SidebarPanel):
    bl_label = "Quick Start"
    bl_order = -1

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not isinstance(preferences(), AddonPreferences) or not preferences().show_quick_start:
            return False
        traced = sessions.shown(context.scene)
        return traced is None or (
            len(traced.result.objects) <= _OBJECTS and len(_sources(traced)) <= 1
        )

    def draw(self, context: Context) -> None:
        layout = self.layout
        column = layout.column(align=True)
        is_first = True
        for words, is_done in steps(context):
            row = column.row()
            row.active = is_first and not is_done
            icon = "CHECKMARK" if is_done else "TRIA_RIGHT" if is_first else "BLANK1"
            row.label(text=words, icon=icon)
            is_first = is_first and is_done
        row = layout.row(align=True)
        row.prop(preferences(), "show_quick_start", text="Skip", toggle=True, invert_checkbox=True)
        row.menu("HAPTIC_MT_samples")


def steps(context: Context) -> Iterator[tuple[str, bool]]:
    """The steps, and whether each is done."""
    scene = context.scene
    traced = sessions.shown(scene)
    sources = [] if traced is None else _sources(traced)
    is_felt = any(level.is_felt for level in watched.levels_of(scene))
    moves = is_playing() or scene.frame_current != scene.frame_start
    bake = scene.haptics.bake
    is_out = bake.track is not None or last_export.written is not None
    yield "Select the cube: Make Haptic", traced is not None and bool(traced.result.objects)
    yield "It vibrates: Add Source", bool(sources)
    yield "Who feels it: Add Body Listeners", traced is not None and bool(traced.result.listeners)
    yield "Play: the bars rise", is_felt and moves
    yield "Drag Amplitude, or choose a signal", any(map(_is_changed, sources))
    yield "Bake, or Export Tracks", is_out


def _sources(traced: sessions.Traced) -> list[str]:
    """The names of the sources that are objects."""
    found = traced.result.sources if traced.reading is None else traced.reading.sources
    return [source.name for source in found if source.kind is SourceKind.PERSISTENT]


def _is_changed(name: str) -> bool:
    """Whether a source of this file differs from a new one."""
    obj = bpy.data.objects.get(name)
    return obj is not None and any(
        getattr(obj.haptics.source, key) != obj.haptics.source.bl_rna.properties[key].default
        for key in ("signal", "amplitude", "frequency")
    )
