#version 450 core
// World and vehicles: color and normal; light.frag shades them.
layout(location = 0) in vec3 a_position_m;
layout(location = 1) in vec4 a_normal_open;
layout(location = 2) in vec4 a_leaf_offset_m;
layout(location = 3) in vec4 a_row0;   // T_world_mesh, row by row
layout(location = 4) in vec4 a_row1;
layout(location = 5) in vec4 a_row2;
layout(location = 6) in vec4 a_color;  // linear color, and the surface kind: 0 plain, 1 ground, 2 plant, 3 shiny
uniform mat4 u_clip_world;
uniform float u_leaf_growth;           // relative enlargement of leaves that compensates omitted ones
uniform float u_leaf_unit_m;
uniform float u_cut_m;
uniform vec3 u_eye_m;
uniform vec4 u_watched[16];            // vehicles that leaves must not hide: position and radius
uniform int u_num_watched;
out vec3 v_world_m;
out vec3 v_normal;
out float v_open;
flat out vec4 v_color;
out float gl_ClipDistance[2];

// Distance of a leaf from the nearest line of sight to a watched vehicle; negative: blocks the view.
float out_of_sight_m(vec3 leaf_m) {
  float least = 1e9;
  for (int i = 0; i < u_num_watched; ++i) {
    vec3 axis = u_watched[i].xyz - u_eye_m;
    float reach = length(axis);
    float along = dot(leaf_m - u_eye_m, axis) / reach;
    float aside = distance(leaf_m - u_eye_m, axis * (along / reach));
    float beside = aside - u_watched[i].w * mix(0.7, 1.0, clamp(along / reach, 0.0, 1.0));
    least = min(least, max(beside, max(along - reach + 0.3, -along)));
    least = min(least, distance(leaf_m, u_eye_m) - min(3.5, 0.4 * reach));
  }
  return least;
}

void main() {
  vec4 p = vec4(a_position_m + a_leaf_offset_m.xyz * (u_leaf_unit_m * u_leaf_growth), 1.0);
  v_world_m = vec3(dot(a_row0, p), dot(a_row1, p), dot(a_row2, p));
  // Normals are transformed by the cofactors of the matrix, which is correct for any scaling.
  v_normal = vec3(dot(cross(a_row1.xyz, a_row2.xyz), a_normal_open.xyz),
                  dot(cross(a_row2.xyz, a_row0.xyz), a_normal_open.xyz),
                  dot(cross(a_row0.xyz, a_row1.xyz), a_normal_open.xyz));
  v_open = a_normal_open.w;
  v_color = a_color;
  gl_ClipDistance[0] = u_cut_m - v_world_m.z;
  gl_ClipDistance[1] = 1.0;
  if (u_num_watched > 0 && a_color.w > 1.5 && a_color.w < 2.5) {
    vec4 middle = vec4(a_position_m - a_leaf_offset_m.xyz * u_leaf_unit_m, 1.0);
    gl_ClipDistance[1] = out_of_sight_m(vec3(dot(a_row0, middle), dot(a_row1, middle), dot(a_row2, middle)));
  }
  gl_Position = u_clip_world * vec4(v_world_m, 1.0);
}
