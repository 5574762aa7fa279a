"""The shader of all drawing (`quads.*.glsl`), made by GPUShaderCreateInfo for OpenGL, Vulkan and
Metal, and draw calls of quads with it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import gpu
from gpu.types import GPUBatch, GPUShader, GPUShaderCreateInfo, GPUStageInterfaceInfo
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from .quads import ATTRIBUTES, Quads
from .render_data import Size
from .symbols import LOOKS, Symbol


@cache
def shader() -> GPUShader:
    """The shader, compiled at first use."""
    stage = GPUStageInterfaceInfo("haptic_quad")
    for kind, name in (
        ("VEC2", "local"),
        ("VEC2", "plate"),
        ("VEC4", "colour_a"),
        ("VEC4", "colour_b"),
        ("VEC2", "arc_length_ab"),
    ):
        stage.smooth(kind, name)
    for name in ("length_pixels", "half_width", "kind"):
        stage.flat("FLOAT", name)
    info = GPUShaderCreateInfo()
    for shape in Symbol:
        info.define(f"SHAPE_{shape.name}", f"{float(shape)}")
    info.define("DRAW_SYMBOL", _symbols())
    info.push_constant("MAT4", "matrix")
    info.push_constant("VEC4", "screen")  # width, height, pixels per point
    info.push_constant("VEC2", "bias")
    info.push_constant("VEC2", "flow")  # phase, metres per pulse (0: no flow)
    info.push_constant("FLOAT", "opacity_factor")
    info.push_constant(
        "BOOL", "srgbTarget"
    )  # set by Blender: whether the target expects linear light
    for slot, (name, length) in enumerate(ATTRIBUTES):
        info.vertex_in(slot, f"VEC{length}", name)
    info.vertex_out(stage)
    info.fragment_out(0, "VEC4", "colour_out")
    info.vertex_source(_source("vert"))
    info.fragment_source(_source("frag"))
    return gpu.shader.create_from_info(info)


def _symbols() -> str:
    """Statements that draw the layers of the symbol ``kind`` over each other."""
    statements = []
    for shape, look in LOOKS.items():
        for inset, own, opacity in look.layers:
            colour = "colour" if own is None else f"vec3{tuple(own.tolist())}"
            cover = f"{opacity} * covered({look.distance}(local, radius - {inset} * pixel))"
            statements.append(
                f"if (kind == SHAPE_{shape.name}) result = over(result, {colour}, {cover});"
            )
    return " ".join(statements)


def _source(stage: str) -> str:
    return Path(__file__).with_name(f"quads.{stage}.glsl").read_text("utf-8")


def upload(quads: Quads) -> GPUBatch | None:
    """Quads on the GPU, None if there are none."""
    return (
        batch_for_shader(shader(), "TRIS", quads.attributes, indices=quads.triangles)
        if quads.count
        else None
    )


def draw(
    batch: GPUBatch,
    matrix: Matrix,
    size: Size,
    *,
    pixels_per_point: float,
    bias: tuple[float, float] = (0.0, 0.0),
    flow: tuple[float, float] = (0.0, 0.0),
    opacity: float = 1.0,
) -> None:
    """One draw call, with premultiplied opacity.

    Args:
        batch: The quads.
        matrix: From their space to clip space.
        size: Of the viewport [pixels].
        pixels_per_point: Scale of widths and sizes.
        bias: Depth towards the viewer: as a part of the distance, and in clip space.
        flow: Phase of the signal flow [pulses], and metres per pulse, 0 for no flow.
        opacity: Factor of all opacities.
    """
    program = shader()
    program.bind()
    program.uniform_float("matrix", matrix)
    program.uniform_float("screen", (*size, pixels_per_point, 0.0))
    program.uniform_float("bias", bias)
    program.uniform_float("flow", flow)
    program.uniform_float("opacity_factor", opacity)
    batch.draw(program)
