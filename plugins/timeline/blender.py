"""The lane over Timeline and Dope Sheet in Blender: its property and draw handler, and the operator
that moves one-shots in it."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Event, Header, Operator, SpaceDopeSheetEditor

from ...addon.blender.polling import is_editable
from ...addon.blender.words import report_text
from ...addon.gateway import StandIn, is_loaded
from ...addon.properties.callbacks import view_changed
from ...addon.properties.kinds import choice
from ...addon.session import session, sessions

baked = StandIn(f"{__package__}.baked")
lane = StandIn(f"{__package__}.lane")


class HAPTIC_OT_drag_one_shot(Operator):
    """Move a one-shot in time; it snaps to impacts and markers, and with Ctrl to whole frames"""

    bl_idname = "haptic.drag_one_shot"
    bl_label = "Move One-Shot"
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        area = context.area
        return is_loaded(lane) and area is not None and area.type == "DOPESHEET_EDITOR"

    def invoke(self, context: Context, event: Event) -> set[str]:
        mark = lane.under(context, (event.mouse_region_x, event.mouse_region_y))
        if mark is None or not is_editable(bpy.data.objects[mark.source]):
            return {"PASS_THROUGH"}
        self.mark, self.frame = mark, mark.frame
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        is_over = event.type in {"RIGHTMOUSE", "ESC"}
        if event.type == "MOUSEMOVE":
            x, view = event.mouse_region_x, context.region.view2d
            frame = round(view.region_to_view(x, 0)[0]) if event.ctrl else lane.snap(context, x)
            self._put(context, float(frame))
            context.area.header_text_set(report_text("One-shot at frame {:g}", round(frame, 2)))
        elif is_over:
            self._put(context, self.mark.frame)
        elif event.type == "LEFTMOUSE" and event.value == "RELEASE":
            self._curve().update()
            is_over = True
        if not is_over:
            return {"RUNNING_MODAL"}
        context.area.header_text_set(None)
        return {"CANCELLED"} if self.frame == self.mark.frame else {"FINISHED"}

    def _curve(self) -> Any:
        return lane.trigger_curve(bpy.data.objects[self.mark.source])

    def _put(self, context: Context, frame: float) -> None:
        self.frame = self._curve().keyframe_points[self.mark.key].co_ui[0] = frame
        context.area.tag_redraw()


CLASSES = (HAPTIC_OT_drag_one_shot,)


def _draw() -> None:
    if is_loaded(session) and bpy.context.scene is not None:
        lane.draw(baked.waves_of(bpy.context.scene))


def _draw_choice(self: Header, context: Context) -> None:
    if sessions.known(context.scene) is not None:
        self.layout.prop(context.scene, "haptic_lane", text="", icon_only=True)


_drawing: list[Any] = []
_items: list[Any] = []
_TYPES: Any = bpy.types


def register() -> None:
    choices = (
        ("OFF", "Off", "Not shown", "HIDE_ON", 0),
        (
            "LEVELS",
            "Levels",
            "Levels from -60 to 0 dB, filled above the threshold of feeling, and impacts",
            "FORCE_HARMONIC",
            1,
        ),
        ("WAVES", "Waves", "The waves of the listeners", "RNDCURVE", 2),
    )
    _TYPES.Scene.haptic_lane = choice(
        "Timeline of Touch",
        "What is drawn over Timeline and Dope Sheet of the frames baked or played. One-shots can "
        "be dragged",
        choices,
        default="LEVELS",
        update=view_changed,
    )
    _drawing.append(SpaceDopeSheetEditor.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))
    _TYPES.DOPESHEET_HT_header.append(_draw_choice)
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is not None:  # None in the background
        keymap = configuration.keymaps.new(name="Dopesheet", space_type="DOPESHEET_EDITOR")
        drag = HAPTIC_OT_drag_one_shot.bl_idname
        item = keymap.keymap_items.new(drag, "LEFTMOUSE", "PRESS", any=True)
        _items.append((keymap, item))


def unregister() -> None:
    while _items:
        keymap, item = _items.pop()
        keymap.keymap_items.remove(item)
    _TYPES.DOPESHEET_HT_header.remove(_draw_choice)
    while _drawing:
        SpaceDopeSheetEditor.draw_handler_remove(_drawing.pop(), "WINDOW")
    del _TYPES.Scene.haptic_lane
