#version 450 core
// Smooths edges of a finished picture by averaging along them, with a weight that grows with their contrast. For pictures with one
// sample per pixel.
uniform sampler2D u_picture;
out vec4 o_color;

float luma_at(ivec2 at) {
  vec3 color = texelFetch(u_picture, clamp(at, ivec2(0), textureSize(u_picture, 0) - 1), 0).rgb;
  return dot(color, vec3(0.30, 0.59, 0.11));
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec2 texel = 1.0 / vec2(textureSize(u_picture, 0));
  vec3 here = texelFetch(u_picture, at, 0).rgb;
  vec2 slope = vec2(luma_at(at + ivec2(1, 0)) - luma_at(at - ivec2(1, 0)),
                    luma_at(at + ivec2(0, 1)) - luma_at(at - ivec2(0, 1)));
  float steepness = length(slope);
  vec2 along = vec2(-slope.y, slope.x) / max(steepness, 1e-4);
  vec2 uv = gl_FragCoord.xy * texel;
  vec3 beside = 0.5 * (texture(u_picture, uv + 1.2 * along * texel).rgb + texture(u_picture, uv - 1.2 * along * texel).rgb);
  o_color = vec4(mix(here, beside, 0.66 * smoothstep(0.06, 0.30, steepness)), 1.0);
}
