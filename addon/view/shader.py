"""The shader of all drawing, made by GPUShaderCreateInfo for OpenGL, Vulkan and Metal, and draw calls of quads with it."""

from __future__ import annotations

from functools import cache

import gpu
from gpu.types import GPUBatch, GPUIndexBuf, GPUShader, GPUShaderCreateInfo, GPUStageInterfaceInfo, GPUTexture, GPUVertBuf, GPUVertFormat
from mathutils import Matrix

from .quads import ATTRIBUTES, Quads
from .render_data import Shape

_VERTEX = """
void main()
{
  float shape = style.y;
  vec2 corner = style.zw;
  vec4 from = matrix * vec4(start, 1.0);
  vec4 to = matrix * vec4(end, 1.0);

  /* What lies behind the viewer is cut off at the near plane. */
  float from_depth = from.z + from.w;
  float to_depth = to.z + to.w;
  if (from_depth <= 0.0 && to_depth <= 0.0) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  float first = from_depth < 0.0 ? from_depth / (from_depth - to_depth) : 0.0;
  float last = to_depth < 0.0 ? from_depth / (from_depth - to_depth) : 1.0;
  vec4 near_end = mix(from, to, first);
  vec4 far_end = mix(from, to, last);
  vec3 a = near_end.xyz / near_end.w;
  vec3 b = far_end.xyz / far_end.w;
  vec2 a_pixels = (a.xy * 0.5 + 0.5) * screen.xy;
  vec2 b_pixels = (b.xy * 0.5 + 0.5) * screen.xy;

  vec2 along = b_pixels - a_pixels;
  length_pixels = length(along);
  along = length_pixels > 1e-4 ? along / length_pixels : vec2(1.0, 0.0);
  half_width = 0.5 * style.x * screen.z;
  kind = shape;
  /* A plate or a text lies between two corners; everything else around a line. One more pixel for smooth edges. */
  vec2 pixels;
  if (shape == SHAPE_TEXT) {
    vec2 place = corner * 0.5 + 0.5;
    plate = mix(colour_end.xy, colour_end.zw, place);
    local = vec2(0.0);
    pixels = mix(a_pixels, b_pixels, place);
  }
  else if (shape == SHAPE_PLATE) {
    along = vec2(1.0, 0.0);
    vec2 extent = 0.5 * abs(b_pixels - a_pixels);
    plate = extent;
    local = corner * (extent + 1.0);
    pixels = 0.5 * (a_pixels + b_pixels) + local;
  }
  else {
    float reach = half_width + 1.0;
    plate = vec2(0.0);
    local = vec2(corner.x < 0.0 ? -reach : length_pixels + reach, corner.y * reach);
    vec2 across = vec2(-along.y, along.x);
    pixels = a_pixels + along * local.x + across * local.y;
  }
  float part = corner.x < 0.0 ? 0.0 : 1.0;
  colour_a = mix(colour_start, colour_end, first);
  colour_b = mix(colour_start, colour_end, last);
  arc_length_ab = mix(vec2(arc_length.x), vec2(arc_length.y), vec2(first, last));
  /* Points and lines on a surface come a little towards the viewer. */
  float depth = part < 0.5 ? a.z : b.z;
  depth -= bias.x * (1.0 - depth) + bias.y;
  gl_Position = vec4(pixels / screen.xy * 2.0 - 1.0, max(depth, -1.0), 1.0);
}
"""

_FRAGMENT = """
float disc(vec2 p, float radius)
{
  return length(p) - radius;
}

/* A square on its corner with rounded corners. */
float diamond(vec2 p, float radius)
{
  float corner = 0.22 * radius;
  vec2 q = abs(p);
  return max((q.x + q.y - radius + corner) * 0.70710678 - 0.29289 * corner, max(q.x, q.y) - radius) ;
}

float box(vec2 p, vec2 extent, float radius)
{
  vec2 q = abs(p) - extent + radius;
  return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - radius;
}

/* Eight rays. */
float burst(vec2 p, float radius)
{
  float angle = atan(p.y, p.x) * 8.0 / 6.2831853;
  float ray = abs(fract(angle) - 0.5) * 2.0;
  return (length(p) - radius * mix(0.55, 1.0, ray)) * 0.8;
}

float covered(float distance)
{
  return clamp(0.5 - distance, 0.0, 1.0);
}

/* Colour over colour, both with premultiplied opacity. */
vec4 over(vec4 below, vec3 colour, float opacity)
{
  return vec4(colour * opacity, opacity) + below * (1.0 - opacity);
}

vec3 to_target(vec3 colour)
{
  if (!srgbTarget) {
    return colour;
  }
  vec3 low = colour / 12.92;
  vec3 high = pow((colour + 0.055) / 1.055, vec3(2.4));
  return mix(high, low, vec3(lessThanEqual(colour, vec3(0.04045))));
}

void main()
{
  float pixel = screen.z;
  vec3 dark = vec3(0.063, 0.063, 0.071);
  vec3 light = vec3(0.97);
  vec4 result = vec4(0.0);
  if (kind == SHAPE_LINE) {
    float along = clamp(local.x, 0.0, length_pixels);
    float t = length_pixels > 0.0 ? along / length_pixels : 0.0;
    vec4 colour = mix(colour_a, colour_b, t);
    float edge = length(local - vec2(along, 0.0)) - half_width;
    /* Thinner than a pixel: one pixel wide, and fainter. */
    float opacity = colour.a * (half_width < 0.5 ? covered(edge + half_width - 0.5) * 2.0 * half_width : covered(edge));
    if (flow.y > 0.0 && arc_length_ab.x >= 0.0) {
      float phase = fract(mix(arc_length_ab.x, arc_length_ab.y, t) / flow.y - flow.x);
      float pulse = exp(-36.0 * (phase - 0.5) * (phase - 0.5)) * covered(edge + 0.22 * half_width);
      colour.rgb = mix(colour.rgb, vec3(1.0), 0.85 * pulse);
    }
    result = over(result, colour.rgb, opacity);
  }
  else if (kind == SHAPE_TEXT) {
    result = over(result, colour_a.rgb, colour_a.a * texture(atlas, plate).a);
  }
  else if (kind == SHAPE_PLATE) {
    vec4 colour = mix(colour_a, colour_b, clamp(local.x / (2.0 * plate.x) + 0.5, 0.0, 1.0));
    result = over(result, colour.rgb, colour.a * covered(box(local, plate, half_width)));
  }
  else {
    vec3 colour = colour_a.rgb;
    float radius = half_width;
    if (kind == SHAPE_CONTACT) {
      result = over(result, dark, 0.9 * covered(disc(local, radius)));
      result = over(result, colour, covered(disc(local, radius - 1.3 * pixel)));
    }
    else if (kind == SHAPE_SOURCE) {
      result = over(result, dark, 0.92 * covered(disc(local, radius)));
      result = over(result, colour, covered(abs(disc(local, radius - 2.6 * pixel)) - 1.1 * pixel));
      result = over(result, light, covered(disc(local, radius - 5.4 * pixel)));
      result = over(result, colour, covered(disc(local, radius - 7.0 * pixel)));
    }
    else if (kind == SHAPE_IMPACT) {
      result = over(result, dark, 0.92 * covered(burst(local, radius)));
      result = over(result, light, covered(burst(local, radius - 1.8 * pixel)));
      result = over(result, colour, covered(burst(local, radius - 4.0 * pixel)));
    }
    else {
      result = over(result, dark, 0.92 * covered(diamond(local, radius)));
      result = over(result, light, covered(diamond(local, radius - 1.9 * pixel)));
      result = over(result, colour, covered(diamond(local, radius - 4.7 * pixel)));
    }
    result *= colour_a.a;
  }
  result *= opacity_factor;
  if (result.a < 0.002) {
    discard;
  }
  colour_out = vec4(to_target(result.rgb / result.a), 1.0) * result.a;
}
"""


@cache
def shader() -> GPUShader:
    """Compiled at first use."""
    stage = GPUStageInterfaceInfo("haptic_quad")
    for kind, name in (("VEC2", "local"), ("VEC2", "plate"), ("VEC4", "colour_a"), ("VEC4", "colour_b"), ("VEC2", "arc_length_ab")):
        stage.smooth(kind, name)
    for name in ("length_pixels", "half_width", "kind"):
        stage.flat("FLOAT", name)
    info = GPUShaderCreateInfo()
    for shape in Shape:
        info.define(f"SHAPE_{shape.name}", f"{float(shape)}")
    info.push_constant("MAT4", "matrix")
    info.push_constant("VEC4", "screen")  # width, height, pixels per point
    info.push_constant("VEC2", "bias")
    info.push_constant("VEC2", "flow")  # phase, metres per pulse (0: no flow)
    info.push_constant("FLOAT", "opacity_factor")
    info.sampler(0, "FLOAT_2D", "atlas")  # coverage of texts
    info.push_constant("BOOL", "srgbTarget")  # set by Blender: whether the target expects linear light
    for slot, (name, length) in enumerate(ATTRIBUTES):
        info.vertex_in(slot, f"VEC{length}", name)
    info.vertex_out(stage)
    info.fragment_out(0, "VEC4", "colour_out")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    return gpu.shader.create_from_info(info)


@cache
def _no_texts() -> GPUTexture:
    return GPUTexture((1, 1), format="RGBA8")


def upload(quads: Quads) -> GPUBatch | None:
    """Quads on the GPU, None where there are none."""
    if not quads.count:
        return None
    layout = GPUVertFormat()
    for name, length in ATTRIBUTES:
        layout.attr_add(id=name, comp_type="F32", len=length, fetch_mode="FLOAT")
    vertices = GPUVertBuf(layout, len(quads.attributes["style"]))
    for name, values in quads.attributes.items():
        vertices.attr_fill(name, values)
    return GPUBatch(type="TRIS", buf=vertices, elem=GPUIndexBuf(type="TRIS", seq=quads.triangles))


def draw(
    batch: GPUBatch,
    matrix: Matrix,
    size: tuple[float, float],
    *,
    pixels_per_point: float,
    bias: tuple[float, float] = (0.0, 0.0),
    flow: tuple[float, float] = (0.0, 0.0),
    opacity: float = 1.0,
    texts: GPUTexture | None = None,
) -> None:
    """One draw call, with premultiplied opacity. ``matrix``: from the batch's space to clip space. ``size`` of the viewport [pixels].
    ``texts``: the texture of a `TextAtlas`, where the batch has texts."""
    program = shader()
    program.bind()
    program.uniform_float("matrix", matrix)
    program.uniform_float("screen", (*size, pixels_per_point, 0.0))
    program.uniform_float("bias", bias)
    program.uniform_float("flow", flow)
    program.uniform_float("opacity_factor", opacity)
    program.uniform_sampler("atlas", texts or _no_texts())
    batch.draw(program)
