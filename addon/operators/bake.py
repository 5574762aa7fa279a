"""Operators that bake, and that delete a bake."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import bpy
from bpy.props import IntProperty
from bpy.types import Context, Event, Operator, Timer

from ..bake import baking, curves, playback, sound, storage, takes
from ..blender.polling import UNDO, poll_object_mode
from ..changes.redraw import redraw_viewports

_rpt = bpy.app.translations.pgettext_rpt

_PIECE = 0.08  # seconds of baking between two rounds of events

_running: list[baking.Baking] = []


def running() -> baking.Baking | None:
    """The bake in progress, None where there is none."""
    return _running[0] if _running else None


class HAPTIC_OT_bake(Operator):
    """Trace the frame range in order and keep what is felt with the scene, to be played without tracing"""

    bl_idname = "haptic.bake"
    bl_label = "Bake Haptics"
    bl_options = UNDO

    _baking: Any = None
    _timer: Timer | None = None

    @classmethod
    def poll(cls, context: Context) -> bool:
        if running() is not None:
            cls.poll_message_set("A bake is going on; press Esc to cancel it")
            return False
        return poll_object_mode(cls, context)

    def execute(self, context: Context) -> set[str]:
        try:
            work = baking.Baking(context.scene)
            work.finish()
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._finished(work)

    def invoke(self, context: Context, event: Event) -> set[str]:
        if context.window is None or bpy.app.background:
            return self.execute(context)
        try:
            self._baking = baking.Baking(context.scene)
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        _running.append(self._baking)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(0.005, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        work = self._baking
        if work is None or work not in _running:  # the add-on was disabled meanwhile
            self._end(context)
            return {"CANCELLED"}
        if event.type == "ESC":
            self.cancel(context)
            self.report({"INFO"}, _rpt("Bake cancelled"))
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            done = work.advance(_PIECE)
        except ValueError as error:
            self.cancel(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.window_manager.progress_update(100 * work.part)
        context.workspace.status_text_set(f"{work.words}   ({100 * work.part:.0f} %)   Esc to cancel")
        redraw_viewports()
        if not done:
            return {"RUNNING_MODAL"}
        self._end(context)
        return self._finished(work)

    def cancel(self, context: Context) -> None:
        """Also called by Blender where a file is loaded or the window is closed."""
        work = self._baking
        self._end(context)
        if work is not None:
            with suppress(ReferenceError):  # the scene may be gone
                work.close()

    def _end(self, context: Context) -> None:
        if self._baking in _running:
            _running.remove(self._baking)
        self._baking = None
        manager = context.window_manager
        if self._timer is not None:
            manager.event_timer_remove(self._timer)
            self._timer = None
            manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        redraw_viewports()

    def _finished(self, work: baking.Baking) -> set[str]:
        redraw_viewports()
        done = _rpt("1 frame baked") if work.frame_count == 1 else _rpt("{} frames baked").format(work.frame_count)
        self.report({"WARNING"} if work.warnings else {"INFO"}, "; ".join((done, *work.warnings)))
        return {"FINISHED"}


class HAPTIC_OT_delete_bake(Operator):
    """Remove the haptic track of this scene, its F-curves and its sound strip; a track that was kept as a take is removed from the takes"""

    bl_idname = "haptic.delete_bake"
    bl_label = "Delete Bake"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        if running() is not None:
            cls.poll_message_set("A bake is going on; press Esc to cancel it")
            return False
        bake = context.scene.haptics.bake
        if bake.track is None and bake.sound is None:
            cls.poll_message_set("Nothing has been baked in this scene")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        storage.drop(scene)
        sound.remove_strip(scene)
        curves.remove_curves(scene)
        playback.show_current(scene)
        return {"FINISHED"}


class HAPTIC_OT_keep_take(Operator):
    """Keep this bake under a name; the next one takes a place of its own"""

    bl_idname = "haptic.keep_take"
    bl_label = "Keep as Take"
    bl_options = UNDO

    @classmethod
    def poll(cls, context: Context) -> bool:
        bake = context.scene.haptics.bake
        if bake.track is None or any(take.track == bake.track for take in bake.takes):
            cls.poll_message_set("Bake first: what is baked is kept" if bake.track is None else "This bake is a take already")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        takes.keep(context.scene)
        return {"FINISHED"}


class HAPTIC_OT_play_take(Operator):
    """Play this take from the same place on, and compare it with the one played before"""

    bl_idname = "haptic.play_take"
    bl_label = "Play Take"
    bl_options = {*UNDO, "INTERNAL"}

    index: IntProperty(name="Take", options={"HIDDEN"}, min=0)

    def execute(self, context: Context) -> set[str]:
        if self.index >= len(context.scene.haptics.bake.takes):
            return {"CANCELLED"}
        takes.play(context.scene, self.index)
        return {"FINISHED"}


def stop() -> None:
    """Cancel the bake in progress, as the add-on is disabled."""
    while _running:
        _running.pop().close()
