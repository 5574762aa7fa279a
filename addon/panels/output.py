"""Panel "Output": what is felt as sound, on devices, baked, and in files."""

from __future__ import annotations

from bpy.types import Context, UILayout

from ..blender import job
from ..blender.words import show
from ..io import last_export
from ..live_output import outputs
from ..view import watched
from .drawing import SidebarPanel, draw_more
from .live_output import draw_search
from .texts import fitted

_DEVICES = 4


class HAPTIC_PT_output(SidebarPanel):
    bl_label = "Output"
    bl_order = 30

    @classmethod
    def poll(cls, context: Context) -> bool:
        return bool(watched.levels_of(context.scene)) or bool(outputs.running())

    def draw(self, context: Context) -> None:
        layout = self.layout
        haptics = context.scene.haptics
        layout.prop(haptics.live_output, "preview_volume")
        row = layout.row(align=True)
        draw_search(row)
        if outputs.inventory() is not None or outputs.running():
            row.popover("HAPTIC_PT_live_output", text="", icon="PREFERENCES")
        _draw_devices(layout.column(align=True))
        if job.draw_running(layout):
            return
        row = layout.row(align=True)
        words = "Bake" if haptics.bake.track is None else "Bake Again"
        row.operator("haptic.bake", text=words, icon="REC")
        if haptics.bake.track is not None:
            row.operator("haptic.keep_take", text="", icon="ADD")
        row.popover("HAPTIC_PT_bake", text="", icon="PREFERENCES")
        row = layout.row(align=True)
        row.operator("export_scene.haptic_tracks", text="Export Tracks", icon="EXPORT")
        if last_export.written is not None:
            row.popover("HAPTIC_PT_export", text="", icon="PREFERENCES")


def _draw_devices(layout: UILayout) -> None:
    """Draw the connected devices and those found, each with the button that (dis)connects it."""
    running = outputs.running()
    inventory = outputs.inventory()
    found = () if inventory is None else inventory.devices
    titles = {device.key: device.title for device in found}
    titles |= {key: output.profile.title for key, output in running.items()}
    for key, title in list(titles.items())[:_DEVICES]:
        row = layout.row(align=True)
        is_open = key in running and running[key].status.state == "open"
        icon = "CHECKMARK" if is_open else "ERROR" if key in running else "MOUSE_MOVE"
        show(row, fitted(title, 0.8, icon=True), icon)
        icon = "UNLINKED" if key in running else "LINKED"
        row.operator("haptic.connect_device", text="", icon=icon).device = key
    draw_more(layout, len(titles) - _DEVICES)
    if inventory is not None and not titles:
        layout.label(text="No haptic device is connected", icon="INFO")
