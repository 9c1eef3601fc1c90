#version 450 core
// Averages the 4 x 4 pattern of the occlusion pass over pixels of similar depth.
uniform sampler2D u_open;
out vec4 o_open;
void main() {
  ivec2 last = textureSize(u_open, 0) - 1;
  ivec2 at = ivec2(gl_FragCoord.xy);
  float here_m = texelFetch(u_open, at, 0).g;
  float tolerance = 1.0 / (0.02 * here_m + 0.1);
  float sum = 0.0;
  float weights = 0.0;
  for (int y = -2; y < 2; ++y) {
    for (int x = -2; x < 2; ++x) {
      vec2 open_depth = texelFetch(u_open, clamp(at + ivec2(x, y), ivec2(0), last), 0).rg;
      float w = 1.0 / (0.02 + abs(open_depth.y - here_m) * tolerance);
      sum += w * open_depth.x;
      weights += w;
    }
  }
  o_open = vec4(sum / weights, here_m, 0.0, 0.0);
}
