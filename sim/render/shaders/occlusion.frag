#version 450 core
// Ambient occlusion from the depth: the share of the hemisphere over a pixel that is covered by near surfaces.
uniform sampler2D u_depth;
uniform sampler2D u_base;
uniform sampler2D u_normal;
uniform vec4 u_depth_m;         // depth in meters of a depth z of the buffer: (x z + y) / (z z + w)
uniform vec2 u_spread;          // half width and height of the view at 1 m
uniform mat4 u_camera_world;
uniform float u_radius_m;
uniform float u_pixels_at_1m;   // pixels per meter at 1 m, in the full picture
uniform float u_parallel;
out vec4 o_open;
vec3 camera_at(ivec2 pixel, ivec2 size, vec2 spread_per_px) {
  float z = texelFetch(u_depth, clamp(pixel, ivec2(0), size - 1), 0).r;
  float depth_m = (u_depth_m.x * z + u_depth_m.y) / (u_depth_m.z * z + u_depth_m.w);
  vec2 beside = (vec2(pixel) + 0.5) * spread_per_px - u_spread;
  return vec3(beside * mix(depth_m, 1.0, u_parallel), -depth_m);
}
void main() {
  ivec2 size = textureSize(u_depth, 0);
  vec2 spread_per_px = 2.0 * u_spread / vec2(size);
  ivec2 at = ivec2(gl_FragCoord.xy) * 2;
  if (texelFetch(u_depth, at, 0).r <= 0.0) { o_open = vec4(1.0, 1e6, 0.0, 0.0); return; }
  vec3 p = camera_at(at, size, spread_per_px);
  vec4 covered = texelFetch(u_normal, at, 0);
  vec3 N = normalize(mat3(u_camera_world) * (2.0 * covered.xyz / max(texelFetch(u_base, at, 0).a, 0.25) - 1.0));
  if (dot(N, p) > 0.0 && u_parallel < 0.5) N = -N;
  float depth_m = mix(-p.z, 1.0, u_parallel);
  float radius_px = clamp(u_radius_m * u_pixels_at_1m / depth_m, 3.0, 90.0);
  float radius_m = radius_px * depth_m / u_pixels_at_1m;
  float per_radius_sq = 1.0 / (radius_m * radius_m);
  ivec2 cell = ivec2(gl_FragCoord.xy) & 3;
  float turn = float((cell.x * 5 + cell.y * 3 + (cell.x ^ cell.y) * 7) & 15) * (6.2831853 / 16.0);
  vec2 towards = vec2(cos(turn), sin(turn));
  const mat2 kGoldenTurn = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688);
  float sum = 0.0;
  const int kTaps = 9;
  for (int i = 0; i < kTaps; ++i) {
    float s = (float(i) + 0.5) / float(kTaps);
    vec3 v = camera_at(at + ivec2(radius_px * s * towards), size, spread_per_px) - p;
    float d_sq = dot(v, v);
    float height = dot(v, N) - 0.02 * radius_m;
    sum += max(0.0, height) * inversesqrt(d_sq + 1e-8) * clamp(1.4 - d_sq * per_radius_sq, 0.0, 1.0);
    towards = kGoldenTurn * towards;
  }
  float fade = clamp((radius_px - 3.0) / 5.0, 0.0, 1.0);
  o_open = vec4(clamp(1.0 - 1.25 * fade * sum / float(kTaps), 0.25, 1.0), -p.z, 0.0, 0.0);
}
