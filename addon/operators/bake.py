"""Operators that bake, and that delete a bake."""

from __future__ import annotations

from bpy.props import IntProperty
from bpy.types import Context

from ..bake import baking, storage, takes
from ..blender import job
from ..blender.polling import UNDO, Action, Edit, Need
from ..changes.redraw import redraw_viewports


class HAPTIC_OT_bake(Edit):
    """Trace the frame range in order and store the result in the file, to be played without tracing"""

    bl_label = "Bake Haptics"
    bl_options = {"REGISTER"}  # the job pushes its undo step

    needs = (job.IDLE, *Edit.needs)

    def apply(self, context: Context) -> set[str]:
        return job.run(self, context, baking.bake_job(context.scene))


def _is_baked(context: Context) -> bool:
    return context.scene.haptics.bake.track is not None


class HAPTIC_OT_delete_bake(Edit):
    """Remove the haptic track of this scene; a track that was kept as a take is removed from the takes"""

    bl_label = "Delete Bake"

    needs = (job.IDLE, Need(_is_baked, "Nothing has been baked in this scene"))

    def apply(self, context: Context) -> None:
        scene = context.scene
        storage.drop(scene)
        redraw_viewports()


class HAPTIC_OT_keep_take(Edit):
    """Store this bake under a name, so that the next one does not replace it"""

    bl_label = "Keep as Take"

    needs = (
        Need(
            lambda context: context.scene.haptics.bake.track,
            "Bake first: a take is a bake with a name",
        ),
        Need(lambda context: not takes.is_take(context.scene), "This bake is a take already"),
    )

    def apply(self, context: Context) -> None:
        takes.keep(context.scene)


class HAPTIC_OT_play_take(Action):
    """Play this take whenever the timeline plays, and compare it with the one played before"""

    bl_label = "Play Take"
    bl_options = {*UNDO, "INTERNAL"}

    index: IntProperty(name="Take", options={"HIDDEN"}, min=0)

    def apply(self, context: Context) -> set[str]:
        if self.index >= len(context.scene.haptics.bake.takes):
            return {"CANCELLED"}
        takes.play(context.scene, self.index)
        return {"FINISHED"}
