#version 450 core
// Cubes and spheres of overlays, instanced; triangles of overlays.
layout(location = 0) in vec3 a_position;       // vertex of the unit solid
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_center_size_m;
layout(location = 3) in vec4 a_color;
uniform mat4 u_clip_world;
uniform float u_cut_m;
out vec3 v_world_m;
out vec3 v_normal;
out vec4 v_color;
out float gl_ClipDistance[1];
void main() {
  v_world_m = a_center_size_m.xyz + a_center_size_m.w * a_position;
  v_normal = a_normal;
  v_color = a_color;
  gl_ClipDistance[0] = u_cut_m - v_world_m.z;
  gl_Position = u_clip_world * vec4(v_world_m, 1.0);
}
