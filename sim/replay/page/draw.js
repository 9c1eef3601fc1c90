// SPDX-License-Identifier: BSD-3-Clause
// WebGL2 drawing, independent of the run: instanced meshes, points, wide lines, translucent triangles.
'use strict';

const Mat = {
  multiply(a, b) {  // 4 x 4, column by column
    const m = new Float32Array(16);
    for (let c = 0; c < 4; ++c) for (let r = 0; r < 4; ++r)
      for (let k = 0; k < 4; ++k) m[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    return m;
  },
  perspective(half_height, aspect, near, far) {
    const f = 1 / half_height, d = near - far;
    return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, 2 * far * near / d, 0]);
  },
  view(eye, right, up, back) {
    const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    return new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, dot(right), dot(up), dot(back), 1]);
  },
};
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const along = (a, s, b) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const n = Math.hypot(...a) || 1; return a.map((x) => x / n); };
const turn = (R, v) => [0, 3, 6].map((r) => R[r] * v[0] + R[r + 1] * v[1] + R[r + 2] * v[2]);

const kHaze = `
uniform vec3 u_eye; uniform vec3 u_haze; uniform float u_reach;
vec3 hazed(vec3 color, vec3 p) { float d = length(p - u_eye) / u_reach; return mix(color, u_haze, 0.75 * (1.0 - exp(-d * d))); }`;

const kShaders = {
  mesh: [`
layout(location=0) in vec3 position; layout(location=1) in vec4 row0; layout(location=2) in vec4 row1;
layout(location=3) in vec4 row2; layout(location=4) in vec4 color;
uniform mat4 u_clip; out vec3 v_p; out vec4 v_color;
void main() {
  vec4 p = vec4(position, 1.0);
  v_p = vec3(dot(row0, p), dot(row1, p), dot(row2, p));
  v_color = color;
  gl_Position = u_clip * vec4(v_p, 1.0);
}`, `
in vec3 v_p; in vec4 v_color; uniform float u_grid; uniform float u_cut; uniform float u_dim; out vec4 o;
${kHaze}
void main() {
  if (v_p.z > u_cut) discard;
  vec3 n = normalize(cross(dFdx(v_p), dFdy(v_p)));
  if (dot(n, u_eye - v_p) < 0.0) n = -n;
  vec3 sun = normalize(vec3(-0.45, -0.6, 0.85));
  float light = 0.50 + 0.14 * n.z + 0.42 * max(dot(n, sun), 0.0);
  vec3 color = v_color.rgb * light;
  if (u_grid > 0.0) {
    vec2 cell = abs(fract(v_p.xy / u_grid - 0.5) - 0.5) / max(fwidth(v_p.xy / u_grid), vec2(1e-5));
    color *= 1.0 - 0.16 * (1.0 - min(min(cell.x, cell.y), 1.0));
  }
  o = vec4(hazed(color, v_p) * u_dim, v_color.a);
}`],
  point: [`
layout(location=0) in vec3 position; layout(location=1) in vec4 color;
uniform mat4 u_clip; uniform float u_size; uniform float u_least; out vec4 v_color;
void main() {
  gl_Position = u_clip * vec4(position, 1.0);
  gl_PointSize = clamp(u_size / gl_Position.w, u_least, u_least + 5.0);
  v_color = color;
}`, `
in vec4 v_color; out vec4 o;
void main() { o = v_color; }`],
  line: [`
layout(location=0) in vec3 from; layout(location=1) in vec3 to; layout(location=2) in vec4 color; layout(location=3) in float width;
uniform mat4 u_clip; uniform vec2 u_screen; out vec4 v_color;
void main() {
  vec4 a = u_clip * vec4(from, 1.0), b = u_clip * vec4(to, 1.0);
  const float near = 0.02;
  if (a.w < near && b.w < near) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  if (a.w < near) a = mix(a, b, (near - a.w) / (b.w - a.w));
  if (b.w < near) b = mix(b, a, (near - b.w) / (a.w - b.w));
  vec2 pa = a.xy / a.w * u_screen, pb = b.xy / b.w * u_screen;
  vec2 d = pb - pa; float l = length(d); d = l > 1e-4 ? d / l : vec2(1.0, 0.0);
  vec2 side = vec2(-d.y, d.x) * (float(gl_VertexID & 1) - 0.5) * width;
  bool second = gl_VertexID > 1;
  vec4 p = second ? b : a;
  p.xy = ((second ? pb : pa) + side + d * (second ? 0.3 : -0.3) * width) / u_screen * p.w;
  p.z -= 2e-4 * p.w;
  gl_Position = p; v_color = color;
}`, `
in vec4 v_color; out vec4 o;
void main() { o = v_color; }`],
  sky: [`
uniform vec3 u_corner[3]; out vec3 v_d;
void main() {
  vec2 p = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  v_d = u_corner[gl_VertexID]; gl_Position = vec4(p, 1.0, 1.0);
}`, `
in vec3 v_d; uniform vec3 u_zenith, u_horizon, u_below; out vec4 o;
void main() {
  float z = normalize(v_d).z;
  o = vec4(z > 0.0 ? mix(u_horizon, u_zenith, min(1.0, 1.6 * sqrt(z))) : mix(u_horizon, u_below, min(1.0, -5.0 * z)), 1.0);
}`],
};

/** Antialiasing takes four times as long without a graphics card. */
function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return false;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  const lose = gl.getExtension('WEBGL_lose_context');
  if (lose) lose.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

/** One canvas with its programs. */
class Painter {
  constructor(canvas) {
    const gl = canvas.getContext('webgl2', {antialias: !drawsInSoftware(), alpha: false, preserveDrawingBuffer: true});
    if (!gl) throw new Error('This browser has no WebGL2, which the replay needs.');
    this.gl = gl;
    this.canvas = canvas;
    this.programs = {};
    for (const [name, [vertex, fragment]] of Object.entries(kShaders)) this.programs[name] = this.program(name, vertex, fragment);
    this.empty = gl.createVertexArray();
    this.scratch = {};
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  program(name, vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, '#version 300 es\nprecision highp float;\n' + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(name + ': ' + gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(name + ': ' + gl.getProgramInfoLog(program));
    const at = {};
    for (let i = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) - 1; i >= 0; --i) {
      const uniform = gl.getActiveUniform(program, i).name;
      at[uniform] = gl.getUniformLocation(program, uniform);
    }
    return {program, at};
  }

  use(name, camera) {
    const gl = this.gl, {program, at} = this.programs[name];
    gl.useProgram(program);
    if (at.u_clip) gl.uniformMatrix4fv(at.u_clip, false, camera.clip);
    if (at.u_eye) gl.uniform3fv(at.u_eye, camera.eye);
    if (at.u_screen) gl.uniform2f(at.u_screen, this.canvas.width / 2, this.canvas.height / 2);
    return at;
  }

  buffer(data, target) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(target || gl.ARRAY_BUFFER, buffer);
    gl.bufferData(target || gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  attribute(location, size, stride, offset, divisor, type) {
    const gl = this.gl;
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, size, type || gl.FLOAT, Boolean(type), stride, offset);
    gl.vertexAttribDivisor(location, divisor || 0);
  }

  /** A mesh, and buffers for its placements: 12 numbers (rows of the transform) and 4 of color each. */
  mesh(positions, indices) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.buffer(positions);
    this.attribute(0, 3, 12, 0);
    const places = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, places);
    for (let row = 0; row < 4; ++row) this.attribute(1 + row, 4, 64, 16 * row, 1);
    this.buffer(indices, gl.ELEMENT_ARRAY_BUFFER);
    gl.bindVertexArray(null);
    return {array, places, count: indices.length, number: 0};
  }

  place(mesh, places, dynamic) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, mesh.places);
    gl.bufferData(gl.ARRAY_BUFFER, places, dynamic ? gl.STREAM_DRAW : gl.STATIC_DRAW);
    mesh.number = places.length / 16;
  }

  drawMesh(mesh) {
    if (!mesh.number) return;
    this.gl.bindVertexArray(mesh.array);
    this.gl.drawElementsInstanced(this.gl.TRIANGLES, mesh.count, this.gl.UNSIGNED_INT, 0, mesh.number);
  }

  /** 16 bytes per point: three floats and a color. */
  points(bytes) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffer = this.buffer(bytes);
    this.attribute(0, 3, 16, 0);
    this.attribute(1, 4, 16, 12, 0, gl.UNSIGNED_BYTE);
    return {array, buffer, count: bytes.byteLength / 16};
  }

  free(points) {
    this.gl.deleteVertexArray(points.array);
    this.gl.deleteBuffer(points.buffer);
  }

  stream(key, make) {
    const gl = this.gl;
    if (!this.scratch[key]) {
      const array = gl.createVertexArray(), buffer = gl.createBuffer();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      make();
      this.scratch[key] = {array, buffer};
    }
    gl.bindVertexArray(this.scratch[key].array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.scratch[key].buffer);
  }

  /** 11 numbers per line: from, to, color, width in pixels. */
  drawLines(numbers, camera) {
    if (!numbers.length) return;
    const gl = this.gl;
    this.use('line', camera);
    this.stream('line', () => {
      this.attribute(0, 3, 44, 0, 1); this.attribute(1, 3, 44, 12, 1); this.attribute(2, 4, 44, 24, 1); this.attribute(3, 1, 44, 40, 1);
    });
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STREAM_DRAW);
    gl.enable(gl.BLEND);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, numbers.length / 11);
    gl.disable(gl.BLEND);
  }

  /** Translucent triangles with 7 numbers per corner: position and color. */
  drawAreas(numbers, camera) {
    if (!numbers.length) return;
    const gl = this.gl, at = this.use('point', camera);
    gl.uniform1f(at.u_size, 1); gl.uniform1f(at.u_least, 1);
    this.stream('area', () => { this.attribute(0, 3, 28, 0); this.attribute(1, 4, 28, 12); });
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STREAM_DRAW);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.drawArrays(gl.TRIANGLES, 0, numbers.length / 7);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  /** Points with a size in meters. */
  drawDots(numbers, size_m, camera, least_px = 2) {
    if (!numbers.length) return;
    const gl = this.gl, at = this.use('point', camera);
    gl.uniform1f(at.u_size, size_m * camera.pixels_at_1m); gl.uniform1f(at.u_least, least_px);
    this.stream('area', () => { this.attribute(0, 3, 28, 0); this.attribute(1, 4, 28, 12); });
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STREAM_DRAW);
    gl.drawArrays(gl.POINTS, 0, numbers.length / 7);
  }

  drawSky(camera, sky) {
    const gl = this.gl, at = this.use('sky', camera);
    const corners = [];
    for (const [x, y] of [[-1, -1], [3, -1], [-1, 3]]) {
      corners.push(...[0, 1, 2].map((i) => camera.forward[i] + x * camera.half_width * camera.right[i] + y * camera.half_height * camera.up[i]));
    }
    gl.uniform3fv(at['u_corner[0]'], corners);
    gl.uniform3fv(at.u_zenith, sky.zenith); gl.uniform3fv(at.u_horizon, sky.horizon); gl.uniform3fv(at.u_below, sky.below);
    gl.bindVertexArray(this.empty);
    gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
  }
}

/** Cube with edge 1. */
function cube() {
  const p = [], i = [];
  for (let k = 0; k < 8; ++k) p.push((k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5);
  for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) i.push(a, b, c, a, c, d);
  return [new Float32Array(p), new Uint32Array(i)];
}

/** Sphere with radius 1. */
function ball(slices = 14, stacks = 9) {
  const p = [], i = [];
  for (let s = 0; s <= stacks; ++s) for (let k = 0; k <= slices; ++k) {
    const a = 2 * Math.PI * k / slices, b = Math.PI * s / stacks;
    p.push(Math.sin(b) * Math.cos(a), Math.sin(b) * Math.sin(a), Math.cos(b));
  }
  for (let s = 0; s < stacks; ++s) for (let k = 0; k < slices; ++k) {
    const a = s * (slices + 1) + k, b = a + slices + 1;
    i.push(a, b, b + 1, a, b + 1, a + 1);
  }
  return [new Float32Array(p), new Uint32Array(i)];
}

/** Blades of radius 1 around z. */
function blades(number, chord) {
  const p = [], i = [];
  for (let k = 0; k < number; ++k) {
    const a = 2 * Math.PI * k / number, c = Math.cos(a), s = Math.sin(a), first = p.length / 3;
    for (const [r, w] of [[0.04, 0.45], [0.3, 1], [0.7, 0.8], [1, 0.35]]) for (const side of [-0.5, 0.5]) {
      const y = side * w * chord;
      p.push(r * c - y * s, r * s + y * c, 0.1 * y);
    }
    for (let q = 0; q < 3; ++q) { const v = first + 2 * q; i.push(v, v + 2, v + 3, v, v + 3, v + 1); }
  }
  return [new Float32Array(p), new Uint32Array(i)];
}

/** Flat disc with radius 1. */
function disc(corners = 28) {
  const p = [0, 0, 0], i = [];
  for (let k = 0; k < corners; ++k) p.push(Math.cos(2 * Math.PI * k / corners), Math.sin(2 * Math.PI * k / corners), 0);
  for (let k = 0; k < corners; ++k) i.push(0, 1 + k, 1 + (k + 1) % corners);
  return [new Float32Array(p), new Uint32Array(i)];
}
