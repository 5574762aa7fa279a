"""The haptic graph over every 3D viewport: draw callbacks, and their state between redraws.

The shapes are made on the worker thread. A redraw with nothing changed compares one signature and
issues two draw calls: one for the graph, one for the plates of labels and legend, and the texts.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import gpu
import numpy as np
from bpy.types import Context, Scene
from mathutils import Matrix

from ...core.arrays import FloatArray
from ...core.frozen import frozen
from ...core.graph.haptic_graph import HapticGraph
from ...core.propagation import Propagation
from ...core.render.frame_result import FrameResult
from ...core.scene.values import Settings
from ..blender.time import seconds_of
from ..blender.units import metres_per_unit
from ..changes.events import file_changed
from ..session import sessions
from ..session.derived import Derived
from . import meters, shader, touching_shape
from .annotations import LegendSide, placed_annotations
from .cues import cues_of
from .layout import (
    camera_frame,
    free_rectangle,
    is_main_view,
    navigation,
    pixels_per_point,
    redo_panels,
)
from .options import options_of
from .quads import Quads, quads
from .render_data import Options, RenderData, Size, render_data
from .screen import Recent, draw_flat, in_theme, is_light, uploaded
from .watched import levels_of

HIDDEN = 0.15  # opacity of parts hidden by objects, where the graph is not drawn in front
PULSE_LENGTH = 0.8  # metres between two pulses of the signal flow
PULSE_SPEED = 1.6  # metres per second of the timeline

_drawings: dict[int, GraphDrawing] = {}  # by session id of the scene


@frozen
class GraphShapes:
    """What is drawn of the graph of a frame: ``data`` and ``quads``, and ``made_of``, the values
    that they follow from."""

    made_of: tuple[HapticGraph, Propagation, Settings, Options]
    data: RenderData
    quads: Quads

    @classmethod
    def of(
        cls,
        result: FrameResult,
        settings: Settings,
        options: Options,
        before: GraphShapes | None = None,
        paths: FloatArray | None = None,
    ) -> GraphShapes:
        """The shapes of a frame, or those ``before`` if nothing visible has changed: the tracer
        reuses an unchanged graph and its gains.

        Args:
            result: the frame.
            settings: that it was traced with.
            options: what is shown and selected.
            before: shapes of the frame before.
            paths: connections kept in a track, None for a traced frame.
        """
        now = result.graph, result.propagation, settings, options
        if before is not None and now == before.made_of:
            return before
        data = render_data(result, settings, options, paths)
        return cls(now, data, quads(data))


@dataclass(slots=True)
class GraphDrawing:
    """Shapes and their batch on the GPU; labels and legend per view."""

    shapes: GraphShapes
    batch: Any
    views: Recent = field(default_factory=lambda: Recent(8))

    @classmethod
    def of(cls, shapes: GraphShapes) -> GraphDrawing:
        """Upload the shapes."""
        return cls(shapes, shader.upload(shapes.quads))


_SHAPES: Derived[Options, GraphShapes] = Derived(
    lambda one, choice, before: GraphShapes.of(one.result, one.settings, choice, before, one.paths),
    every_frame=True,
)


def drawing_of(scene: Scene) -> GraphDrawing | None:
    """The last complete graph, without waiting; None if there is none."""
    traced = sessions.shown(scene)
    latest = None if traced is None else _SHAPES.latest(scene, options_of(scene, traced.result))
    if latest is None:
        _drawings.pop(scene.session_uid, None)
        return None
    known = _drawings.get(scene.session_uid)
    if known is None or known.shapes is not latest.value:
        for gone in _drawings.keys() - {other.session_uid for other in bpy.data.scenes}:
            del _drawings[gone]
        known = _drawings[scene.session_uid] = GraphDrawing.of(latest.value)
    return known


def draw_graph(
    drawing: GraphDrawing,
    projection: Any,
    view: Any,
    size: Size,
    scale: float,
    *,
    xray: bool,
    flow: float | None,
) -> None:
    """Draw lines and points of the graph.

    Args:
        drawing: The graph on the GPU.
        projection: From the viewer to clip space.
        view: From metres in the world to the viewer.
        size: Of the viewport [pixels].
        scale: Pixels per point.
        xray: Over all objects; otherwise parts behind objects are pale.
        flow: Time of the signal flow [s], None for no flow.
    """
    if drawing.batch is None:
        return
    passes = (("NONE", 1.0),) if xray else (("GREATER", HIDDEN), ("LESS_EQUAL", 1.0))
    gpu.state.blend_set("ALPHA_PREMULT")
    gpu.state.depth_mask_set(False)
    try:
        for test, opacity in passes:
            gpu.state.depth_test_set(test)
            shader.draw(
                drawing.batch,
                projection @ view,
                size,
                pixels_per_point=scale,
                bias=depth_bias(projection, view.median_scale),
                flow=(0.0, 0.0)
                if flow is None
                else (flow * PULSE_SPEED / PULSE_LENGTH, PULSE_LENGTH),
                opacity=opacity,
            )
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def depth_bias(projection: Any, units: float) -> tuple[float, float]:
    """Depth bias towards the viewer, so that surfaces do not hide elements on them: 1 % of the
    distance in perspective, 2 cm in an orthographic view. ``units`` per metre."""
    orthographic = projection[3][3] == 1.0
    return (0.0, 0.02 * units * abs(projection[2][2])) if orthographic else (0.01, 0.0)


def draw_annotations(
    drawing: GraphDrawing,
    perspective: FloatArray,
    size: Size,
    scale: float,
    *around: Any,
) -> None:
    """Draw labels, cues and legend.

    Args:
        drawing: The graph, which keeps what was placed for the last views.
        perspective: From metres in the world to clip space (4, 4).
        size: Of the viewport [pixels].
        scale: Pixels per point.
        around: What else `placed_annotations` takes.
    """
    key = (perspective.tobytes(), size, scale, *around, bpy.app.translations.locale, is_light())
    known = drawing.views.get(key)
    if known is None:
        hud = placed_annotations(drawing.shapes.data, perspective, size, scale, *around)
        known = uploaded(in_theme(hud))
        drawing.views[key] = known
    draw_flat(known, size, scale)


def from_metres(scene: Scene) -> Matrix:
    """From metres, in which results are, to the scene's units."""
    return Matrix.Scale(1 / metres_per_unit(scene), 4)


def is_shown(context: Context) -> bool:
    """Whether a viewport shows the graph."""
    scene, space = context.scene, context.space_data
    return (
        scene is not None
        and space is not None
        and scene.haptics.show_overlay
        and space.overlay.show_overlays
    )


def draw_view() -> None:
    """Draw callback: the graph, in world space."""
    context = bpy.context
    scene = context.scene
    if not is_shown(context):
        return
    region, view = context.region, context.region_data
    drawing = drawing_of(scene)
    if drawing is None:
        return
    touching_shape.draw(context, pixels_per_point(context))
    draw_graph(
        drawing,
        view.window_matrix,
        view.view_matrix @ from_metres(scene),
        (region.width, region.height),
        pixels_per_point(context),
        xray=scene.haptics.xray,
        flow=seconds_of(scene, scene.frame_current_final) if scene.haptics.show_flow else None,
    )


def draw_pixels() -> None:
    """Draw callback: labels and legend of the graph, over it."""
    context = bpy.context
    # `draw_view` has just drawn it.
    drawing = _drawings.get(context.scene.session_uid) if is_shown(context) else None
    if drawing is None:
        return
    region, scene = context.region, context.scene
    seen = context.region_data.perspective_matrix
    perspective = np.array(seen @ from_metres(scene), dtype=np.float64)
    free = free_rectangle(context)
    draw_annotations(
        drawing,
        perspective,
        (region.width, region.height),
        pixels_per_point(context),
        free,
        meters.occupied(context) + redo_panels(context) + navigation(context),
        _legend_side(context),
        camera_frame(context),
        cues_of(context, np.array(seen), free) if scene.haptics.show_best_paths else (),
        tuple((level.listener, level.title, level.words()) for level in levels_of(scene)),
    )


def _legend_side(context: Context) -> LegendSide:
    """The side of the legend, opposite the meters."""
    meters_shown = context.scene.haptics.meters
    if not is_main_view(context):
        return "NONE"
    return "LEFT" if meters_shown.show and meters_shown.corner.endswith("RIGHT") else "RIGHT"


def forget() -> None:
    """Free everything cached between redraws."""
    _drawings.clear()
    touching_shape.forget()


file_changed.subscribe(forget)
