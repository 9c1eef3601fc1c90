#version 450 core
// Round points of a cloud.
in vec4 v_color;
out vec4 o_color;
void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float r_sq = dot(q, q);
  if (r_sq > 1.15) discard;
  o_color = vec4(v_color.rgb * (1.0 - 0.22 * r_sq), v_color.a);
}
