"""Panel "Bake", with the takes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from bpy.types import Context, Scene, UILayout

from ..bake import playback, storage, takes
from ..blender import job
from ..blender.words import show, show_pair, ui_text
from ..view import levels
from .drawing import ScenePanel, settings_layout
from .texts import draw_lines, draw_sentence, fitted

if TYPE_CHECKING:
    from ..bake.track import HapticTrack


_MOST_TAKES = 20


class HAPTIC_PT_bake(ScenePanel):
    bl_label = "Bake"
    bl_order = 50

    def draw(self, context: Context) -> None:
        layout = settings_layout(self)
        scene = context.scene
        bake = scene.haptics.bake
        if job.draw_running(layout):
            return
        column = layout.column(align=True)
        column.prop(scene, "frame_start")
        column.prop(scene, "frame_end", text="End")
        layout.operator(
            "haptic.bake", text="Bake" if bake.track is None else "Bake Again", icon="REC"
        )
        _draw_track(layout, scene, storage.track_of(scene))
        if bake.track is not None or bake.takes:
            _draw_takes(layout, scene)


def _draw_track(layout: UILayout, scene: Scene, track: HapticTrack | None) -> None:
    """Draw the baked track, whether the scene has changed since, and its options."""
    bake = scene.haptics.bake
    if track is None:
        draw_sentence(layout, storage.trouble(scene), "ERROR")
        return
    box = layout.box()
    reasons = playback.known_stale_reasons(scene) or ()
    baked = ui_text("Frames {} to {} are baked", track.frame_start, track.frame_end)
    words = ui_text("The scene has changed since") if reasons else baked
    show(box, words, "ERROR" if reasons else "CHECKMARK")
    column = box.column(align=True)
    for reason in reasons:
        draw_lines(column, reason)
    count = len(track.listeners)
    length = ui_text("{:.1f} s, 1 listener") if count == 1 else ui_text("{:.1f} s, {} listeners")
    show(box, length.format(track.duration, count))
    box.prop(bake, "use_track")
    layout.operator("haptic.delete_bake", icon="TRASH")


def _draw_takes(layout: UILayout, scene: Scene) -> None:
    """Draw the takes, and how the one played differs from the one played before."""
    bake = scene.haptics.bake
    layout.operator("haptic.keep_take", icon="ADD")
    column = layout.column(align=True)
    for index, take in enumerate(bake.takes[:_MOST_TAKES]):
        row = column.row(align=True)
        row.prop(take, "name", text="")
        is_played = take.track == bake.track
        row.operator("haptic.play_take", text="", icon="PLAY", depress=is_played).index = index
    other = next((i for i, take in enumerate(bake.takes) if take.track == bake.compared), None)
    if other is not None and bake.compared != bake.track:
        name = bake.takes[other].name
        words = ui_text("Switch to {}", name)
        layout.operator(
            "haptic.play_take", text=words, icon="ARROW_LEFTRIGHT", translate=False
        ).index = other
        _draw_differences(layout, scene, name)


def _draw_differences(layout: UILayout, scene: Scene, other: str) -> None:
    """Draw each listener's level over the whole take, relative to that in the other take."""
    latest = takes.differences(scene)
    if latest is None or not latest.is_current:
        layout.label(text="Comparing...", icon="SORTTIME")
        return
    column = layout.column(align=True)
    column.scale_y = 0.8
    show(column, ui_text("Compared with {}", fitted(other, 0.5)))
    for item in latest.value:
        change = item.here - item.there
        words = levels.change_words(change) if math.isfinite(change) else "\N{EM DASH}"
        show_pair(column, fitted(item.listener, 0.68), words, 0.7)
