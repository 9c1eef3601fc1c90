// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/shaders.hpp"

namespace swiftlet::sim::shaders {

const char* const kMeshVertex = R"(#version 450 core
layout(location = 0) in vec3 a_position_m;
layout(location = 1) in vec4 a_normal_open;
layout(location = 2) in vec4 a_leaf_offset_m;
layout(location = 3) in vec4 a_row0;   // T_world_mesh, row by row
layout(location = 4) in vec4 a_row1;
layout(location = 5) in vec4 a_row2;
layout(location = 6) in vec4 a_color;  // linear, and the kind of surface: 0 plain, 1 ground, 2 plant, 3 shiny
uniform mat4 u_clip_world;
uniform float u_leaf_growth;           // leaves drawn larger by this share, because others are left out
uniform float u_leaf_unit_m;
uniform float u_cut_m;
uniform vec3 u_eye_m;
uniform vec4 u_watched[16];            // what leaves must not hide: position and radius of free sight
uniform int u_num_watched;
out vec3 v_world_m;
out vec3 v_normal;
out float v_open;
flat out vec4 v_color;
out float gl_ClipDistance[2];

// How far a leaf is out of the lines of sight; negative: in the way.
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
  // Normals turn with the cofactors of the matrix, right for any scaling.
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
)";

const char* const kMeshFragment = R"(#version 450 core
in vec3 v_world_m;
in vec3 v_normal;
in float v_open;
flat in vec4 v_color;
uniform vec3 u_eye_m;
uniform vec3 u_forward;               // used instead of the eye in parallel projections
uniform float u_parallel;
uniform vec3 u_sun;                   // unit vector towards the sun
uniform float u_haze_per_m;
uniform vec3 u_haze_color;            // sRGB
uniform float u_grid;                 // strength of the grid on the ground
uniform mat4 u_shadow_world;
uniform mat4 u_vehicle_shadow_world;
uniform float u_shadow_texel_m;
uniform sampler2DShadow u_shadow;
uniform sampler2DShadow u_vehicle_shadow;
out vec4 o_color;

float lit(sampler2DShadow map, vec3 at) {
  // Four bilinear taps on a small cross: a penumbra of about two texels.
  vec2 texel = 1.0 / vec2(textureSize(map, 0));
  at.z = min(at.z, 1.0);  // behind the map's last caster
  float sum = 0.0;
  sum += texture(map, vec3(at.xy + texel * vec2(-0.4, -1.1), at.z));
  sum += texture(map, vec3(at.xy + texel * vec2(1.1, -0.4), at.z));
  sum += texture(map, vec3(at.xy + texel * vec2(0.4, 1.1), at.z));
  sum += texture(map, vec3(at.xy + texel * vec2(-1.1, 0.4), at.z));
  return 0.25 * sum;
}

float hash(vec2 p) {
  uint h = uint(int(p.x)) * 0x9E3779B9u + uint(int(p.y)) * 0x85EBCA77u;
  h = (h ^ (h >> 15)) * 0xC2B2AE3Du;
  h ^= h >> 13;
  return float(h & 0xFFFFu) / 65535.0;
}
float noise(vec2 p) {
  vec2 i = floor(p);
  vec2 f = p - i;
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(hash(i), hash(i + vec2(1, 0)), f.x), mix(hash(i + vec2(0, 1)), hash(i + vec2(1, 1)), f.x), f.y);
}

// 1 on the lines of a grid, anti-aliased; fades where lines come closer than a few pixels.
float grid(vec2 p, float spacing, float half_width_px) {
  vec2 q = p / spacing;
  vec2 per_px = fwidth(q);
  vec2 d = abs(fract(q - 0.5) - 0.5) / max(per_px, 1e-6);
  vec2 line = clamp(half_width_px + 0.5 - d, 0.0, 1.0) * clamp(1.6 - 12.0 * per_px, 0.0, 1.0);
  return max(line.x, line.y);
}

void main() {
  vec3 to_eye = u_eye_m - v_world_m;
  float distance_m = length(to_eye);
  vec3 V = mix(to_eye / distance_m, -u_forward, u_parallel);
  vec3 N = normalize(v_normal);
  bool plant = v_color.w > 1.5 && v_color.w < 2.5;
  bool ground = v_color.w > 0.5 && v_color.w < 1.5;
  if (!plant && dot(N, V) < 0.0) N = -N;

  vec3 base = v_color.rgb;
  if (ground) {
    float patches = 0.6 * noise(v_world_m.xy * 0.35) + 0.4 * noise(v_world_m.xy * 2.7);
    base *= 0.82 + 0.36 * patches;
  }

  // The sun, with the shadows of the world and of the vehicles; looked up a little above the surface.
  float facing = dot(N, u_sun);
  float sun = plant ? max(0.0, 0.65 * facing + 0.35) : max(0.0, facing);
  if (sun > 0.0) {
    vec3 above = v_world_m + N * (1.5 * u_shadow_texel_m) + u_sun * (plant ? 0.25 : 0.0);
    sun *= lit(u_shadow, (u_shadow_world * vec4(above, 1.0)).xyz);
    sun *= lit(u_vehicle_shadow, (u_vehicle_shadow_world * vec4(v_world_m + N * 0.01, 1.0)).xyz);
  }

  // Ambient light: blue from above, warm from below, and a little from the camera so that no side is flat.
  vec3 ambient = mix(vec3(0.25, 0.225, 0.19), vec3(0.50, 0.565, 0.66), 0.5 + 0.5 * N.z);
  ambient += 0.10 * max(0.0, dot(N, V));
  vec3 color = base * (vec3(1.32, 1.22, 1.04) * sun + ambient * v_open);
  if (v_color.w > 2.5) {  // a soft highlight
    vec3 H = normalize(V + u_sun);
    color += 0.25 * pow(max(0.0, dot(N, H)), 40.0) * step(0.001, sun);
  }

  color = color * (1.0 + color * 0.12) / (1.0 + 0.45 * color);  // highlights saturate softly
  color = pow(color, vec3(1.0 / 2.2));
  if (ground) {
    float line = max(0.5 * grid(v_world_m.xy, 1.0, 0.0), grid(v_world_m.xy, 10.0, 0.4));
    color = mix(color, color * 0.62, u_grid * line * clamp(abs(N.z) * 2.0 - 1.0, 0.0, 1.0));
  }
  float haze = (1.0 - exp(-pow(distance_m * u_haze_per_m, 1.5))) * (1.0 - u_parallel);
  o_color = vec4(mix(color, u_haze_color, haze), 1.0);
}
)";

const char* const kDepthFragment = R"(#version 450 core
void main() {}
)";

const char* const kGhostFragment = R"(#version 450 core
uniform vec4 u_color;
out vec4 o_color;
void main() { o_color = u_color; }
)";

const char* const kClipVertex = R"(#version 450 core
layout(location = 0) in vec4 a_clip;
layout(location = 1) in vec4 a_color;
out vec4 v_color;
void main() {
  v_color = a_color;
  gl_Position = a_clip;
}
)";

const char* const kClipFragment = R"(#version 450 core
in vec4 v_color;
uniform float u_opacity;
out vec4 o_color;
void main() { o_color = vec4(v_color.rgb, v_color.a * u_opacity); }
)";

const char* const kPointVertex = R"(#version 450 core
layout(location = 0) in vec3 a_position_m;
layout(location = 1) in vec4 a_color;
uniform mat4 u_clip_world;
uniform float u_pixels_at_1m;  // pixels per metre, times the clip w
uniform float u_size_m;
uniform float u_min_px;
uniform float u_cut_m;
out vec4 v_color;
out float gl_ClipDistance[1];
void main() {
  v_color = a_color;
  gl_Position = u_clip_world * vec4(a_position_m, 1.0);
  gl_ClipDistance[0] = u_cut_m - a_position_m.z;
  gl_PointSize = clamp(u_size_m * u_pixels_at_1m / max(gl_Position.w, 1e-3), u_min_px, 40.0);
}
)";

const char* const kPointFragment = R"(#version 450 core
in vec4 v_color;
out vec4 o_color;
void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float r_sq = dot(q, q);
  if (r_sq > 1.15) discard;
  o_color = vec4(v_color.rgb * (1.0 - 0.22 * r_sq), v_color.a);
}
)";

const char* const kSolidVertex = R"(#version 450 core
layout(location = 0) in vec3 a_position;       // of the unit solid
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_centre_size_m;
layout(location = 3) in vec4 a_color;
uniform mat4 u_clip_world;
uniform float u_cut_m;
out vec3 v_world_m;
out vec3 v_normal;
out vec4 v_color;
out float gl_ClipDistance[1];
void main() {
  v_world_m = a_centre_size_m.xyz + a_centre_size_m.w * a_position;
  v_normal = a_normal;
  v_color = a_color;
  gl_ClipDistance[0] = u_cut_m - v_world_m.z;
  gl_Position = u_clip_world * vec4(v_world_m, 1.0);
}
)";

const char* const kSolidFragment = R"(#version 450 core
in vec3 v_world_m;
in vec3 v_normal;
in vec4 v_color;
uniform vec3 u_eye_m;
uniform vec3 u_sun;
out vec4 o_color;
void main() {
  // A zero normal asks for the one of the flat triangle.
  vec3 N = dot(v_normal, v_normal) > 0.0 ? normalize(v_normal) : normalize(cross(dFdx(v_world_m), dFdy(v_world_m)));
  if (dot(N, u_eye_m - v_world_m) < 0.0) N = -N;
  float light = 0.62 + 0.18 * N.z + 0.28 * max(0.0, dot(N, u_sun));
  o_color = vec4(min(v_color.rgb * light, vec3(1.0)), v_color.a);
}
)";

const char* const kScreenVertex = R"(#version 450 core
out vec2 v_clip;
void main() {
  v_clip = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(v_clip, 0.0, 1.0);  // depth 0 is farthest
}
)";

const char* const kSkyFragment = R"(#version 450 core
in vec2 v_clip;
uniform mat4 u_world_clip;
uniform float u_parallel;
uniform vec3 u_haze_color;
uniform vec3 u_sun;
out vec4 o_color;
void main() {
  vec4 near = u_world_clip * vec4(v_clip, 1.0, 1.0);
  vec4 far = u_world_clip * vec4(v_clip, 0.01, 1.0);
  vec3 d = normalize(far.xyz / far.w - near.xyz / near.w);
  vec3 zenith = vec3(0.36, 0.56, 0.82);
  float height = clamp(d.z, 0.0, 1.0);
  vec3 sky = mix(u_haze_color, zenith, 1.0 - pow(1.0 - height, 2.6));
  sky += vec3(0.14, 0.10, 0.04) * pow(max(0.0, dot(d, u_sun)), 10.0);
  vec3 below = u_haze_color * vec3(0.955, 0.955, 0.94);
  vec3 color = mix(sky, below, smoothstep(0.0, -0.25, d.z));
  o_color = vec4(mix(color, vec3(0.945, 0.95, 0.955), u_parallel), 1.0);
}
)";

// Ambient occlusion from the depth: how much of the hemisphere over a pixel is filled by near surfaces.
const char* const kOcclusionFragment = R"(#version 450 core
uniform sampler2D u_depth;
uniform mat4 u_camera_clip;
uniform float u_radius_m;
uniform float u_pixels_at_1m;   // of the full picture
uniform float u_parallel;
out vec4 o_open;
vec3 camera_at(ivec2 pixel, vec2 size) {
  float depth = texelFetch(u_depth, clamp(pixel, ivec2(0), ivec2(size) - 1), 0).r;
  vec4 p = u_camera_clip * vec4((vec2(pixel) + 0.5) / size * 2.0 - 1.0, depth, 1.0);
  return p.xyz / p.w;
}
void main() {
  vec2 size = vec2(textureSize(u_depth, 0));
  ivec2 at = ivec2(gl_FragCoord.xy) * 2;
  if (texelFetch(u_depth, at, 0).r <= 0.0) { o_open = vec4(1.0, 1e6, 0.0, 0.0); return; }
  vec3 p = camera_at(at, size);
  // The normal from the flatter of the two differences on each axis, so that edges do not smear it.
  vec3 left = p - camera_at(at - ivec2(1, 0), size);
  vec3 right = camera_at(at + ivec2(1, 0), size) - p;
  vec3 down = p - camera_at(at - ivec2(0, 1), size);
  vec3 up = camera_at(at + ivec2(0, 1), size) - p;
  vec3 N = normalize(cross(abs(left.z) < abs(right.z) ? left : right, abs(down.z) < abs(up.z) ? down : up));
  float depth_m = mix(-p.z, 1.0, u_parallel);
  float radius_px = clamp(u_radius_m * u_pixels_at_1m / depth_m, 3.0, 90.0);
  float radius_m = radius_px * depth_m / u_pixels_at_1m;
  ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
  float turn = float((cell.x * 5 + cell.y * 3 + (cell.x ^ cell.y) * 7) & 15) * (6.2831853 / 16.0);
  float sum = 0.0;
  const int kTaps = 9;
  for (int i = 0; i < kTaps; ++i) {
    float s = (float(i) + 0.5) / float(kTaps);
    float angle = turn + 2.399963 * float(i);
    vec3 v = camera_at(at + ivec2(radius_px * s * vec2(cos(angle), sin(angle))), size) - p;
    float d_sq = dot(v, v);
    float height = dot(v, N) - 0.02 * radius_m;
    sum += max(0.0, height) / (sqrt(d_sq) + 1e-4) * clamp(1.4 - d_sq / (radius_m * radius_m) * 1.0, 0.0, 1.0);
  }
  float fade = clamp((radius_px - 3.0) / 5.0, 0.0, 1.0);
  o_open = vec4(clamp(1.0 - 1.25 * fade * sum / float(kTaps), 0.25, 1.0), -p.z, 0.0, 0.0);
}
)";

// Averages the 4 x 4 pattern of the pass above over pixels of like depth, and darkens the picture (by blending).
const char* const kApplyOcclusionFragment = R"(#version 450 core
uniform sampler2D u_depth;
uniform sampler2D u_open;
uniform mat4 u_camera_clip;
out vec4 o_color;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  if (texelFetch(u_depth, at, 0).r <= 0.0) discard;
  ivec2 half_size = textureSize(u_open, 0);
  float depth = texelFetch(u_depth, at, 0).r;
  vec2 zw = mat2(u_camera_clip[2].zw, u_camera_clip[3].zw) * vec2(depth, 1.0);
  float here = -zw.x / zw.y;
  ivec2 corner = at / 2 - 2 + (at & 1);
  float sum = 0.0;
  float weights = 0.0;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      ivec2 q = clamp(corner + ivec2(x, y), ivec2(0), half_size - 1);
      vec2 open_depth = texelFetch(u_open, q, 0).rg;
      float w = 1.0 / (0.02 + abs(open_depth.y - here) / (0.02 * here + 0.1));
      sum += w * open_depth.x;
      weights += w;
    }
  }
  o_color = vec4(vec3(sum / weights), 1.0);
}
)";

}  // namespace swiftlet::sim::shaders
