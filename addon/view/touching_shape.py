"""The shape of the selected object that touches others, drawn as lines over it."""

from __future__ import annotations

import bpy
import gpu
from bpy.types import Context
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ...core.arrays import FloatArray
from ...core.contacts.shape_surface import edges
from ...core.contacts.shapes import Mesh, Shape
from ..blender.units import metres_per_unit
from ..session import sessions
from .screen import Recent

_COLOUR = (0.2, 0.9, 1.0, 0.4)
_WIDTH = 1.0  # points
_MOST_TRIANGLES = 50_000  # of a mesh whose edges are drawn

_batches = Recent(4)  # by the id of the shape, which the value keeps alive


def draw(context: Context, scale: float) -> None:
    """Draw the edges of the active object's shape in the last traced frame, if the object is
    selected. ``scale``: pixels per point."""
    active = context.view_layer.objects.active
    traced = sessions.shown(context.scene)
    if (
        active is None
        or traced is None
        or traced.reading is None
        or not active.haptics.enabled
        or not active.select_get()
    ):
        return
    reading, name = traced.reading, active.name_full
    number = next((k for k, body in enumerate(reading.bodies) if body.name == name), None)
    if number is None or _is_too_fine(reading.bodies[number].shape):
        return
    draw_edges(
        reading.bodies[number].shape,
        reading.transforms[number],
        _COLOUR,
        _WIDTH * scale,
        context.scene.haptics.xray,
    )


def draw_edges(
    shape: Shape,
    transform: FloatArray,
    colour: tuple[float, float, float, float],
    width: float,
    in_front: bool,
) -> None:
    """Draw the edges of a shape in the current view.

    Args:
        shape: The shape.
        transform: Where it is [m] (4, 4).
        colour: With opacity.
        width: Of the edges [pixels].
        in_front: Over all objects; otherwise objects hide edges.
    """
    program = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    known = _batches.get(id(shape))
    if known is None:
        points, lines = edges(shape)
        positions = {"pos": points.astype("f").tolist()}
        known = _batches[id(shape)] = (
            shape,
            batch_for_shader(program, "LINES", positions, indices=lines.tolist()),
        )
    program.bind()
    program.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    program.uniform_float("lineWidth", width)
    program.uniform_float("color", colour)
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("NONE" if in_front else "LESS_EQUAL")
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.scale_uniform(1 / metres_per_unit(bpy.context.scene))
            gpu.matrix.multiply_matrix(Matrix(transform.tolist()))
            known[1].draw(program)
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _is_too_fine(shape: Shape) -> bool:
    return isinstance(shape, Mesh) and len(shape.triangles) > _MOST_TRIANGLES


def forget() -> None:
    """Free what is on the GPU."""
    _batches.clear()
