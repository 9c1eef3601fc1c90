#version 450 core
// Deferred shading, once per pixel: sun with shadow, ambient light with occlusion, haze; the sky.
in vec2 v_clip;
uniform sampler2D u_base;
uniform sampler2D u_normal;
uniform sampler2D u_depth;
uniform sampler2D u_open;
uniform vec4 u_depth_m;               // depth in meters of a depth z of the buffer: (x z + y) / (z z + w)
uniform vec2 u_spread;                // half width and height of the view at 1 m
uniform vec3 u_right;                 // right axis of the camera, world frame
uniform vec3 u_up;
uniform vec3 u_eye_m;
uniform vec3 u_forward;
uniform float u_parallel;
uniform vec3 u_sun;                   // unit vector towards the sun
uniform float u_haze_per_m;
uniform vec3 u_haze_color;            // sRGB
uniform float u_white;                // 1: white background, for paper
uniform mat4 u_shadow_world;
uniform mat4 u_vehicle_shadow_world;
uniform float u_shadow_texel_m;
uniform sampler2DShadow u_shadow;
uniform sampler2DShadow u_vehicle_shadow;
out vec4 o_color;

vec3 sky(vec3 d) {
  float low = 1.0 - clamp(d.z, 0.0, 1.0);
  vec3 color = mix(u_haze_color, vec3(0.36, 0.56, 0.82), 1.0 - low * low * sqrt(low));
  float towards_sun = max(0.0, dot(d, u_sun));
  towards_sun *= towards_sun;
  float fourth = towards_sun * towards_sun;
  color += vec3(0.14, 0.10, 0.04) * (fourth * fourth * towards_sun);
  color = mix(color, u_haze_color * vec3(0.955, 0.955, 0.94), smoothstep(0.0, -0.25, d.z));
  return mix(mix(color, vec3(0.945, 0.95, 0.955), u_parallel), vec3(1.0), u_white);
}

float lit(vec3 world_m) {
  // Two bilinear taps: a penumbra of about two texels. Points beyond the last shadow caster are lit.
  vec3 at = mat4x3(u_shadow_world) * vec4(world_m, 1.0);
  at.z = min(at.z, 1.0);
  vec2 texel = 1.0 / vec2(textureSize(u_shadow, 0));
  return 0.5 * (texture(u_shadow, vec3(at.xy + texel * vec2(-0.7, -0.4), at.z)) +
                texture(u_shadow, vec3(at.xy + texel * vec2(0.7, 0.4), at.z)));
}

// Upsamples from half resolution: averages neighbors of similar depth.
float openness(ivec2 at, float here_m) {
  ivec2 last = textureSize(u_open, 0) - 1;
  ivec2 corner = at / 2;
  float tolerance = 1.0 / (0.02 * here_m + 0.1);
  float sum = 0.0;
  float weights = 0.0;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      vec2 open_depth = texelFetch(u_open, min(corner + ivec2(x, y), last), 0).rg;
      float w = 1.0 / (0.02 + abs(open_depth.y - here_m) * tolerance);
      sum += w * open_depth.x;
      weights += w;
    }
  }
  return sum / weights;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 beside = v_clip.x * u_spread.x * u_right + v_clip.y * u_spread.y * u_up;
  vec3 ray = mix(normalize(u_forward + beside), u_forward, u_parallel);
  vec4 covered = texelFetch(u_base, at, 0);
  if (covered.a <= 0.0) { o_color = vec4(sky(ray), 1.0); return; }
  vec4 normal_kind = texelFetch(u_normal, at, 0) / covered.a;
  vec3 base = covered.rgb / covered.a;
  base *= base;
  vec3 N = normalize(2.0 * normal_kind.xyz - 1.0);
  float plant = smoothstep(0.6, 0.9, normal_kind.w);
  float shiny = 1.0 - abs(2.0 * normal_kind.w - 1.0);

  // The resolved depth is that of one sample, which at an edge may miss the surface. A loop instead of a branch, because
  // software rasterizers leave loops early but execute both sides of branches.
  float z = texelFetch(u_depth, at, 0).r;
  int around = z <= 0.0 ? 4 : 0;
  for (int i = 0; i < around; ++i) {
    ivec2 step = i < 2 ? ivec2(2 * i - 1, 0) : ivec2(0, 2 * i - 5);
    z = max(z, max(texelFetch(u_depth, at + step, 0).r, 1e-5));
  }
  float depth_m = (u_depth_m.x * z + u_depth_m.y) / (u_depth_m.z * z + u_depth_m.w);
  vec3 world_m = u_eye_m + depth_m * u_forward + beside * mix(depth_m, 1.0, u_parallel);
  float distance_m = length(world_m - u_eye_m);
  vec3 V = -ray;

  // Sunlight, with the shadows of world and vehicles; sampled slightly above the surface.
  float facing = dot(N, u_sun);
  float sun = max(0.0, mix(facing, 0.65 * facing + 0.35, plant));
  sun *= lit(world_m + N * (1.5 * u_shadow_texel_m) + u_sun * (0.25 * plant));
  vec3 of_vehicles = mat4x3(u_vehicle_shadow_world) * vec4(world_m + N * 0.01, 1.0);
  sun *= texture(u_vehicle_shadow, vec3(of_vehicles.xy, min(of_vehicles.z, 1.0)));

  // Ambient light: blue from above, warm from below, and a little from the camera so that all sides are shaded.
  vec3 ambient = mix(vec3(0.29, 0.26, 0.22), vec3(0.56, 0.63, 0.73), 0.5 + 0.5 * N.z);
  ambient += 0.12 * max(0.0, dot(N, V));
  float open = openness(at, depth_m);
  vec3 color = base * (vec3(1.36, 1.26, 1.07) * sun * mix(1.0, open, 0.35) + ambient * open);
  float mirrored = max(0.0, dot(N, normalize(V + u_sun)));
  mirrored *= mirrored;
  mirrored *= mirrored;
  mirrored *= mirrored;  // power of 8
  float gloss = mirrored * mirrored;
  color += shiny * 0.14 * gloss * gloss * mirrored * step(0.001, sun);

  color = color * (1.0 + color * 0.12) / (1.0 + 0.45 * color);  // highlights saturate softly
  vec3 root = sqrt(color);
  color = 0.85 * root + 0.15 * sqrt(root);  // approximates the power of 1 / 2.2 within 0.01
  float thick = distance_m * u_haze_per_m;
  float haze = (1.0 - exp(-thick * sqrt(thick))) * (1.0 - u_parallel);
  color = mix(color, u_haze_color, haze);
  color = mix(sky(ray), color, min(covered.a, 1.0));
  o_color = vec4(color, 1.0);
}
