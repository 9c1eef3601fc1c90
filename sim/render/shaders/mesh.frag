#version 450 core
// World and vehicles: writes color and normal; light.frag shades them.
in vec3 v_world_m;
in vec3 v_normal;
in float v_open;
flat in vec4 v_color;
uniform vec3 u_eye_m;
uniform vec3 u_forward;               // viewing direction of parallel projections
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

// Anti-aliased grid: 1 on its lines; fades where they are only a few pixels apart.
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
    float line = max(0.5 * grid(v_world_m.xy, 1.0, 0.25), grid(v_world_m.xy, 10.0, 0.4));
    base *= 1.0 - 0.65 * u_grid * line * clamp(abs(N.z) * 2.0 - 1.0, 0.0, 1.0);
  }
  o_base = vec4(sqrt(base), 1.0);
  o_normal = vec4(0.5 + 0.5 * N, plant ? 1.0 : v_color.w > 2.5 ? 0.5 : 0.0);
}
