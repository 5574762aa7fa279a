"""Operator that converts the haptic graph to geometry."""

from __future__ import annotations

from bpy.app.translations import pgettext_rpt as _rpt
from bpy.types import Context, Operator

from ..blender.polling import Edit, Refused, permitted, poll_object_mode
from ..properties.kinds import number, switch
from ..session import session, sessions
from ..view import graph_mesh


class HAPTIC_OT_graph_to_geometry(Edit, Operator):
    """Make a mesh of the haptic graph as it is drawn now, for renderings; an earlier one of this scene is replaced"""

    bl_label = "Graph to Geometry"

    in_front: switch(
        "In Front", "Bring the graph close to the camera, so that objects do not hide it. It looks right from where the camera is now", True
    )
    thickness: number("Thickness", "How thick lines and symbols are", 1.0, (0.01, 5.0), soft_min=0.2)
    labels: switch("Labels", "Add names and gains, and the legend where there is a camera", True)

    @classmethod
    def poll(cls, context: Context) -> bool:
        is_traced = sessions.shown(context.scene) is not None or sessions.is_behind(context.scene)
        return poll_object_mode(cls, context) and permitted(
            cls, is_traced, "Nothing has been traced yet: tag objects, then play or change the frame"
        )

    def apply(self, context: Context) -> None:
        result = session.result_of(context.scene)
        if result is None:
            raise Refused(_rpt("This frame could not be traced: see the problems in the panel Haptic Tracing"))
        options = {"in_front": self.in_front, "labels": self.labels}
        graph, collection = graph_mesh.graph_in_collection(context.scene, result, self.thickness, **options)
        self.report({"INFO"}, _rpt("{:,} vertices in collection '{}'").format(len(graph.data.vertices), collection.name))
