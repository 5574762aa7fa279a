"""The operator that makes a mesh of the haptic graph, and its button."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Panel

from ...addon.blender.polling import Edit, Need, Refused
from ...addon.gateway import StandIn
from ...addon.properties.kinds import number, switch
from ...addon.session import session, sessions

graph_mesh = StandIn(f"{__package__}.graph_mesh")


class HAPTIC_OT_graph_to_geometry(Edit):
    """Make a mesh of the haptic graph as it is drawn now, for renderings; an earlier one of this scene is replaced"""

    bl_label = "Graph to Geometry"

    in_front: switch(
        "In Front",
        "Bring the graph close to the camera, so that objects do not hide it. It looks right "
        "from where the camera is now",
        True,
    )
    thickness: number(
        "Thickness", "How thick lines and symbols are", 1.0, (0.01, 5.0), soft_min=0.2
    )
    labels: switch(
        "Labels", "Add names and amplitudes, and the legend where there is a camera", True
    )

    needs = (
        *Edit.needs,
        Need(
            lambda context: sessions.shown(context.scene) or sessions.is_begun(context.scene),
            "Nothing has been traced yet: tag objects, then play or change the frame",
        ),
    )

    def apply(self, context: Context) -> None:
        # While its settings are adjusted (F9), undo has dropped the result.
        result = session.result_of(context.scene) or session.trace(
            context.scene, context.evaluated_depsgraph_get(), live=True
        )
        if result is None:
            raise Refused(
                "This frame could not be traced: see the problems in the panel Haptic Tracing"
            )
        options = {"in_front": self.in_front, "labels": self.labels}
        graph, collection = graph_mesh.graph_in_collection(
            context.scene, result, self.thickness, **options
        )
        self.tell("{:,} vertices in collection '{}'", len(graph.data.vertices), collection.name)


CLASSES = (HAPTIC_OT_graph_to_geometry,)


def _draw(self: Panel, context: Context) -> None:
    self.layout.operator("haptic.graph_to_geometry", icon="MESH_DATA")


_TYPES: Any = bpy.types


def register() -> None:
    _TYPES.HAPTIC_PT_overlay.append(_draw)


def unregister() -> None:
    _TYPES.HAPTIC_PT_overlay.remove(_draw)
