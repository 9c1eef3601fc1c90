#version 450 core
// Light, once for each pixel whatever lies behind it: sun with shadow, hemisphere and occlusion, haze; the sky.
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
uniform float u_white;                // 1: on paper, nothing behind the world
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
  return mix(mix(color, vec3(0.945, 0.95, 0.955), u_parallel), vec3(1.0), u_white);
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
