#version 450 core
// Round points of a cloud. Mesa 22 and 26 disagree on gl_PointCoord with several samples per pixel, not on gl_FragCoord.
in vec4 v_color;
flat in vec3 v_disc_px;
out vec4 o_color;
void main() {
  vec2 q = (gl_FragCoord.xy - v_disc_px.xy) / v_disc_px.z;
  float r_sq = dot(q, q);
  if (r_sq > 1.15) discard;
  o_color = vec4(v_color.rgb * (1.0 - 0.22 * r_sq), v_color.a);
}
