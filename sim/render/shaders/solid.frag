#version 450 core
// Cubes and spheres of overlays, instanced; triangles of overlays.
in vec3 v_world_m;
in vec3 v_normal;
in vec4 v_color;
uniform vec3 u_eye_m;
uniform vec3 u_sun;
out vec4 o_color;
void main() {
  // A zero normal is replaced by the normal of the flat triangle.
  vec3 N = dot(v_normal, v_normal) > 0.0 ? normalize(v_normal) : normalize(cross(dFdx(v_world_m), dFdy(v_world_m)));
  if (dot(N, u_eye_m - v_world_m) < 0.0) N = -N;
  float light = 0.62 + 0.18 * N.z + 0.28 * max(0.0, dot(N, u_sun));
  o_color = vec4(min(v_color.rgb * light, vec3(1.0)), v_color.a);
}
