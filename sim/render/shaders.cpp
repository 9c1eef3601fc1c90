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
uniform float u_grid;                 // strength of the grid on the ground
layout(location = 0) out vec4 o_base;    // square root of the linear color; covered
layout(location = 1) out vec4 o_normal;  // to [0, 1]; 0 plain, 0.5 shiny, 1 plant

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
  vec3 base = v_color.rgb * mix(1.0, v_open, 0.75);
  vec3 N = normalize(v_normal);
  bool plant = v_color.w > 1.5 && v_color.w < 2.5;
  if (!plant && dot(N, mix(u_eye_m - v_world_m, -u_forward, u_parallel)) < 0.0) N = -N;
  if (v_color.w > 0.5 && v_color.w < 1.5) {  // ground
    base *= 0.82 + 0.36 * (0.6 * noise(v_world_m.xy * 0.35) + 0.4 * noise(v_world_m.xy * 2.7));
    float line = max(0.5 * grid(v_world_m.xy, 1.0, 0.0), grid(v_world_m.xy, 10.0, 0.4));
    base *= 1.0 - 0.65 * u_grid * line * clamp(abs(N.z) * 2.0 - 1.0, 0.0, 1.0);
  }
  o_base = vec4(sqrt(base), 1.0);
  o_normal = vec4(0.5 + 0.5 * N, plant ? 1.0 : v_color.w > 2.5 ? 0.5 : 0.0);
}
)";

// Light, once for each pixel whatever lies behind it: sun with shadow, hemisphere and occlusion, haze; the sky.
const char* const kLightFragment = R"(#version 450 core
in vec2 v_clip;
uniform sampler2D u_base;
uniform sampler2D u_normal;
uniform sampler2D u_depth;
uniform sampler2D u_open;
uniform mat4 u_world_clip;
uniform mat4 u_camera_clip;
uniform vec3 u_eye_m;
uniform vec3 u_forward;
uniform float u_parallel;
uniform vec3 u_sun;                   // unit vector towards the sun
uniform float u_haze_per_m;
uniform vec3 u_haze_color;            // sRGB
uniform mat4 u_shadow_world;
uniform mat4 u_vehicle_shadow_world;
uniform float u_shadow_texel_m;
uniform sampler2DShadow u_shadow;
uniform sampler2DShadow u_vehicle_shadow;
out vec4 o_color;

vec3 sky() {
  vec4 near = u_world_clip * vec4(v_clip, 1.0, 1.0);
  vec4 far = u_world_clip * vec4(v_clip, 0.01, 1.0);
  vec3 d = normalize(far.xyz / far.w - near.xyz / near.w);
  vec3 color = mix(u_haze_color, vec3(0.36, 0.56, 0.82), 1.0 - pow(1.0 - clamp(d.z, 0.0, 1.0), 2.6));
  color += vec3(0.14, 0.10, 0.04) * pow(max(0.0, dot(d, u_sun)), 10.0);
  color = mix(color, u_haze_color * vec3(0.955, 0.955, 0.94), smoothstep(0.0, -0.25, d.z));
  return mix(color, vec3(0.945, 0.95, 0.955), u_parallel);
}

float lit(vec3 world_m) {
  // Four bilinear taps on a small cross: a penumbra of about two texels. Behind the map's last caster all is lit.
  vec3 at = (u_shadow_world * vec4(world_m, 1.0)).xyz;
  at.z = min(at.z, 1.0);
  vec2 texel = 1.0 / vec2(textureSize(u_shadow, 0));
  float sum = texture(u_shadow, vec3(at.xy + texel * vec2(-0.4, -1.1), at.z));
  sum += texture(u_shadow, vec3(at.xy + texel * vec2(1.1, -0.4), at.z));
  sum += texture(u_shadow, vec3(at.xy + texel * vec2(0.4, 1.1), at.z));
  sum += texture(u_shadow, vec3(at.xy + texel * vec2(-1.1, 0.4), at.z));
  return 0.25 * sum;
}

// Averages the 4 x 4 pattern of the occlusion pass over pixels of like depth.
float openness(ivec2 at, float here_m) {
  ivec2 last = textureSize(u_open, 0) - 1;
  ivec2 corner = at / 2 - 2 + (at & 1);
  float tolerance = 1.0 / (0.02 * here_m + 0.1);
  float sum = 0.0;
  float weights = 0.0;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      vec2 open_depth = texelFetch(u_open, clamp(corner + ivec2(x, y), ivec2(0), last), 0).rg;
      float w = 1.0 / (0.02 + abs(open_depth.y - here_m) * tolerance);
      sum += w * open_depth.x;
      weights += w;
    }
  }
  return sum / weights;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 covered = texelFetch(u_base, at, 0);
  if (covered.a <= 0.0) { o_color = vec4(sky(), 1.0); return; }
  vec4 normal_kind = texelFetch(u_normal, at, 0) / covered.a;
  vec3 base = covered.rgb / covered.a;
  base *= base;
  vec3 N = normalize(2.0 * normal_kind.xyz - 1.0);
  float plant = smoothstep(0.6, 0.9, normal_kind.w);
  float shiny = 1.0 - abs(2.0 * normal_kind.w - 1.0);

  // The resolved depth is that of one sample; at an edge it may have missed the surface.
  float depth = texelFetch(u_depth, at, 0).r;
  if (depth <= 0.0) {
    depth = max(max(texelFetch(u_depth, at + ivec2(1, 0), 0).r, texelFetch(u_depth, at - ivec2(1, 0), 0).r),
                max(texelFetch(u_depth, at + ivec2(0, 1), 0).r, texelFetch(u_depth, at - ivec2(0, 1), 0).r));
    depth = max(depth, 1e-5);
  }
  vec4 p = u_world_clip * vec4(v_clip, depth, 1.0);
  vec3 world_m = p.xyz / p.w;
  vec4 c = u_camera_clip * vec4(v_clip, depth, 1.0);
  float depth_m = -c.z / c.w;
  vec3 to_eye = u_eye_m - world_m;
  float distance_m = length(to_eye);
  vec3 V = mix(to_eye / distance_m, -u_forward, u_parallel);

  // The sun, with the shadows of the world and of the vehicles; looked up a little above the surface.
  float facing = dot(N, u_sun);
  float sun = max(0.0, mix(facing, 0.65 * facing + 0.35, plant));
  sun *= lit(world_m + N * (1.5 * u_shadow_texel_m) + u_sun * (0.25 * plant));
  vec3 of_vehicles = (u_vehicle_shadow_world * vec4(world_m + N * 0.01, 1.0)).xyz;
  sun *= texture(u_vehicle_shadow, vec3(of_vehicles.xy, min(of_vehicles.z, 1.0)));

  // Ambient light: blue from above, warm from below, and a little from the camera so that no side is flat.
  vec3 ambient = mix(vec3(0.29, 0.26, 0.22), vec3(0.56, 0.63, 0.73), 0.5 + 0.5 * N.z);
  ambient += 0.12 * max(0.0, dot(N, V));
  float open = openness(at, depth_m);
  vec3 color = base * (vec3(1.36, 1.26, 1.07) * sun * mix(1.0, open, 0.35) + ambient * open);
  color += shiny * 0.14 * pow(max(0.0, dot(N, normalize(V + u_sun))), 40.0) * step(0.001, sun);

  color = color * (1.0 + color * 0.12) / (1.0 + 0.45 * color);  // highlights saturate softly
  color = pow(color, vec3(1.0 / 2.2));
  float haze = (1.0 - exp(-pow(distance_m * u_haze_per_m, 1.5))) * (1.0 - u_parallel);
  color = mix(color, u_haze_color, haze);
  if (covered.a < 1.0) color = mix(sky(), color, covered.a);
  o_color = vec4(color, 1.0);
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
uniform float u_pixels_at_1m;  // pixels per meter, times the clip w
uniform float u_size_m;
uniform float u_min_px;
uniform float u_cut_m;
out vec4 v_color;
out float gl_ClipDistance[1];
void main() {
  v_color = a_color;
  gl_Position = u_clip_world * vec4(a_position_m, 1.0);
  gl_ClipDistance[0] = u_cut_m - a_position_m.z;
  gl_PointSize = clamp(u_size_m * u_pixels_at_1m / max(gl_Position.w, 1e-3), u_min_px, 14.0);
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

// Ambient occlusion from the depth: how much of the hemisphere over a pixel is filled by near surfaces.
const char* const kOcclusionFragment = R"(#version 450 core
uniform sampler2D u_depth;
uniform sampler2D u_base;
uniform sampler2D u_normal;
uniform mat4 u_camera_clip;
uniform mat4 u_camera_world;
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
  vec4 covered = texelFetch(u_normal, at, 0);
  vec3 N = normalize(mat3(u_camera_world) * (2.0 * covered.xyz / max(texelFetch(u_base, at, 0).a, 0.25) - 1.0));
  if (dot(N, p) > 0.0 && u_parallel < 0.5) N = -N;
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

}  // namespace swiftlet::sim::shaders
