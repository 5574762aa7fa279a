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
  /* A plate lies between two corners; everything else around a line. One more pixel for smooth edges. */
  vec2 pixels;
  if (shape == SHAPE_PLATE) {
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
