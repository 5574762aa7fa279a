"""Panel "Bake"."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Context, Panel, Scene, UILayout

from ..bake import playback, storage
from ..blender.text import wrapped
from ..operators.bake import running
from .drawing import HapticsPanel

if TYPE_CHECKING:
    from ..bake.track import HapticTrack


class HAPTIC_PT_bake(HapticsPanel, Panel):
    bl_idname = "HAPTIC_PT_bake"
    bl_label = "Bake"
    bl_order = 50
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        scene = context.scene
        bake = scene.haptics.bake
        baking = running()
        if baking is not None:
            layout.progress(factor=baking.part, text=f"{100 * baking.part:.0f} %")
            layout.label(text="Esc cancels", icon="EVENT_ESC")
            return
        layout.prop(bake, "use_range")
        column = layout.column(align=True)
        column.active = bake.use_range
        column.prop(bake if bake.use_range else scene, "frame_start")
        column.prop(bake if bake.use_range else scene, "frame_end", text="End")
        column = layout.column(heading="Also")
        column.prop(bake, "write_curves")
        column.prop(bake, "write_sound")
        layout.operator("haptic.bake", text="Bake" if bake.track is None else "Bake Again", icon="REC")
        _draw_track(layout, scene, storage.track_of(scene))


def _draw_track(layout: UILayout, scene: Scene, track: HapticTrack | None) -> None:
    """Draw the baked track, whether the scene has changed since, and its options."""
    bake = scene.haptics.bake
    if track is None:
        for line in wrapped(storage.trouble(scene)):
            layout.label(text=line, icon="ERROR")
        return
    box = layout.box()
    reasons = playback.known_stale_reasons(scene) or ()
    baked = iface_("Frames {} to {} are baked").format(track.frame_start, track.frame_end)
    words = iface_("The scene has changed since") if reasons else baked
    box.label(text=words, icon="ERROR" if reasons else "CHECKMARK", translate=False)
    column = box.column(align=True)
    for reason in reasons:
        for line in wrapped(reason):
            column.label(text=line, translate=False)
    count = len(track.listeners)
    length = iface_("{:.1f} s, 1 listener") if count == 1 else iface_("{:.1f} s, {} listeners")
    box.label(text=length.format(track.duration, count), translate=False)
    box.prop(bake, "use_track")
    layout.operator("haptic.delete_bake", icon="TRASH")


CLASSES = (HAPTIC_PT_bake,)
