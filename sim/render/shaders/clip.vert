#version 450 core
// Triangles in clip coordinates (lines, rotor discs).
layout(location = 0) in vec4 a_clip;
layout(location = 1) in vec4 a_color;
out vec4 v_color;
void main() {
  v_color = a_color;
  gl_Position = a_clip;
}
