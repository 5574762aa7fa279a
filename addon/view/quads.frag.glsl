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
  else if (kind == SHAPE_PLATE) {
    vec4 colour = mix(colour_a, colour_b, clamp(local.x / (2.0 * plate.x) + 0.5, 0.0, 1.0));
    result = over(result, colour.rgb, colour.a * covered(box(local, plate, half_width)));
  }
  else {
    vec3 colour = colour_a.rgb;
    float radius = half_width;
    DRAW_SYMBOL
    result *= colour_a.a;
  }
  result *= opacity_factor;
  if (result.a < 0.002) {
    discard;
  }
  colour_out = vec4(to_target(result.rgb / result.a), 1.0) * result.a;
}
