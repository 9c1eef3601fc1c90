#version 450 core
// Round points of a cloud.
layout(location = 0) in vec3 a_position_m;
layout(location = 1) in vec4 a_color;
uniform mat4 u_clip_world;
uniform float u_pixels_at_1m;  // pixels per meter, times the clip w
uniform float u_size_m;
uniform float u_min_px;
uniform float u_max_px;
uniform float u_cut_m;
uniform vec2 u_viewport_px;
out vec4 v_color;
flat out vec3 v_disc_px;  // center and radius
out float gl_ClipDistance[1];
void main() {
  v_color = a_color;
  gl_Position = u_clip_world * vec4(a_position_m, 1.0);
  gl_ClipDistance[0] = u_cut_m - a_position_m.z;
  gl_PointSize = clamp(u_size_m * u_pixels_at_1m / max(gl_Position.w, 1e-3), u_min_px, u_max_px);
  v_disc_px = vec3((0.5 * gl_Position.xy / gl_Position.w + 0.5) * u_viewport_px, 0.5 * gl_PointSize);
}
