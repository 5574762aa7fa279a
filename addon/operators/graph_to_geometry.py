"""Operator that converts the haptic graph to geometry."""

from __future__ import annotations

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.props import BoolProperty, FloatProperty
from bpy.types import Context, Operator

from ..blender.polling import Edit, Refused, poll_object_mode
from ..session import session, sessions
from ..view import graph_mesh


class HAPTIC_OT_graph_to_geometry(Edit, Operator):
    """Make a mesh of the haptic graph as it is drawn now, for renderings; an earlier one of this scene is replaced"""

    bl_label = "Graph to Geometry"

    in_front: BoolProperty(
        name="In Front",
        description="Bring the graph close to the camera, so that objects do not hide it. It looks right from where the camera is now",
        default=True,
    )
    thickness: FloatProperty(
        name="Thickness", description="How thick lines and symbols are", default=1.0, min=0.01, soft_min=0.2, soft_max=5.0
    )
    labels: BoolProperty(name="Labels", description="Add names and gains, and the legend where there is a camera", default=True)

    @classmethod
    def poll(cls, context: Context) -> bool:
        if not poll_object_mode(cls, context):
            return False
        if sessions.shown(context.scene) is None and not sessions.is_behind(context.scene):
            cls.poll_message_set("Nothing has been traced yet: tag objects, then play or change the frame")
            return False
        return True

    def apply(self, context: Context) -> None:
        result = session.result_of(context.scene)
        if result is None:
            raise Refused(_rpt("This frame could not be traced: see the problems in the panel Haptic Tracing"))
        options = {"in_front": self.in_front, "labels": self.labels}
        graph, collection = graph_mesh.graph_in_collection(context.scene, result, self.thickness, **options)
        self.report({"INFO"}, _rpt("{:,} vertices in collection '{}'").format(len(graph.data.vertices), collection.name))
