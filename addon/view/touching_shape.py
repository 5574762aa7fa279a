"""The shape of the selected object that touches others, drawn as lines over it."""

from __future__ import annotations

import gpu
from bpy.types import Context
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ...core.contacts.shape_surface import edges
from ...core.contacts.shapes import Mesh, Shape
from ..session import sessions
from .screen import Recent

_COLOUR = (0.2, 0.9, 1.0, 0.4)
_WIDTH = 1.0  # points
_MOST_TRIANGLES = 50_000  # of a mesh whose edges are drawn

_batches = Recent(4)  # by the id of the shape, which the value keeps alive


def draw(context: Context, scale: float) -> None:
    """Draw the edges of the active object's shape in the last traced frame, if the object is
    selected. ``scale``: pixels per point."""
    active, traced = context.view_layer.objects.active, sessions.shown(context.scene)
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
    shape = reading.bodies[number].shape
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
    program.uniform_float("viewportSize", (context.region.width, context.region.height))
    program.uniform_float("lineWidth", _WIDTH * scale)
    program.uniform_float("color", _COLOUR)
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL" if not context.scene.haptics.xray else "NONE")
    try:
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(Matrix(reading.transforms[number].tolist()))
            known[1].draw(program)
    finally:
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


def _is_too_fine(shape: Shape) -> bool:
    return isinstance(shape, Mesh) and len(shape.triangles) > _MOST_TRIANGLES


def forget() -> None:
    """Free what is on the GPU."""
    _batches.clear()
