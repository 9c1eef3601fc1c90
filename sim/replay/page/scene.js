// SPDX-License-Identifier: BSD-3-Clause
// What of a run is seen at an instant: layers, cameras, colors, what lies under the pointer.
'use strict';

const kSkies = {
  day: {zenith: [0.46, 0.62, 0.84], horizon: [0.86, 0.90, 0.95], below: [0.80, 0.82, 0.84], dim: 1},
  dark: {zenith: [0.06, 0.07, 0.09], horizon: [0.10, 0.115, 0.14], below: [0.09, 0.10, 0.12], dim: 0.42},
};
// Distinguishable to most color-blind readers (Okabe and Ito 2008), as in the pictures.
const kTrackColors = [[0.90, 0.62, 0], [0.34, 0.71, 0.91], [0, 0.62, 0.45], [0.94, 0.89, 0.26], [0.80, 0.47, 0.65], [0.84, 0.37, 0]];
const kSensorColors = [[66, 133, 220], [240, 150, 40], [60, 170, 110], [200, 80, 170], [150, 120, 90], [90, 200, 200]];
const kDetectionColor = [0.95, 0.2, 0.2];

const kCuts = ['2', '4', '8', '15'];

/** Choices of the user; the page's controls and its address change them. */
const kLayers = [
  ['world', 'world', true], ['vehicles', 'vehicles', true], ['names', 'names', true], ['trails', 'trails', true],
  ['sweeps', 'LiDAR sweeps', true], ['detections', 'detections', true], ['tracks', 'tracks', true],
  ['covariances', 'covariances of tracks (3σ)', true], ['estimates', 'estimates of own pose', false], ['references', 'references', false],
  ['radio', 'radio links', false], ['events', 'events', true],
];

/** Overlays that hide more than they show. */
const kOffAtFirst = /^(voxels|map)\.|^reference$|clusters|samples|sensing|window/;

class Scene {
  constructor(painter, run) {
    this.painter = painter;
    this.run = run;
    this.layers = {};
    for (const [key, , on] of kLayers) this.layers[key] = on;
    this.groups = new Map();  // overlays by the first part of their name: on or off
    this.choices = {color: 'height', keep_s: 1, trail_s: 15, scale: 1, sky: 'day', cut: 'none', point: 2};
    this.camera = {kind: 'orbit', vehicle: 0, target: [0, 0, 0], yaw: -2.2, pitch: 0.45, distance: 30};
    this.cloud = new Map();  // Scan -> buffer on the card
    this.cube = painter.mesh(...cube());
    this.ball = painter.mesh(...ball());
    this.disc = painter.mesh(...disc());
    this.parts = [];
    this.world = [];
    this.legend = [];
    this.drawn_points = 0;
  }

  /** When head and world are known. */
  begin() {
    const {head, world, vehicles} = this.run, {painter} = this;
    const bounds = head.bounds_m || [[-10, -10, 0], [10, 10, 10]];
    this.size_m = Math.hypot(bounds[1][0] - bounds[0][0], bounds[1][1] - bounds[0][1]);
    for (const mesh of world) {
      const places = this.placesOf(mesh);
      this.world.push({mesh: painter.mesh(mesh.positions, mesh.indices), kind: mesh.about.kind, places, balls: Scene.ballsOf(mesh, places), seen: new Float32Array(places.length)});
    }
    for (const vehicle of vehicles) {
      const meshes = vehicle.meshes.map((m) => ({mesh: painter.mesh(m.positions, m.indices), color: m.about.color.map((c) => c / 255)}));
      const rotors = vehicle.rotors.map((r) => ({...r, mesh: painter.mesh(...blades(r.blades, r.chord_m / r.radius_m))}));
      this.parts.push({meshes, rotors});
    }
  }

  /** At the first instant: a look at the whole team. */
  look() {
    const places = this.run.vehicles.map((_, i) => this.run.vehicleAt(i, 0)).filter(Boolean).map((v) => v.p);
    if (!places.length) return;
    const low = [0, 1, 2].map((i) => Math.min(...places.map((p) => p[i]))), high = [0, 1, 2].map((i) => Math.max(...places.map((p) => p[i])));
    this.camera.target = low.map((x, i) => (x + high[i]) / 2);
    this.camera.distance = Math.min(Math.max(9, 1.15 * Math.hypot(...sub(high, low))), 120);
    // Crowns would hide a team that flies below them.
    if (this.run.world.some((mesh) => mesh.about.kind === 'plant')) this.choices.cut = kCuts.find((cut) => Number(cut) > high[2] + 1) || 'none';
  }

  /** Rows and color of each place; no two trees have quite the same color. */
  placesOf(mesh) {
    const {places, about} = mesh, out = new Float32Array(16 * places.rows);
    const column = (name) => places.columns.get(name);
    for (let i = 0; i < places.rows; ++i) {
      ['x', 'y', 'z'].forEach((r, row) => {
        ['xx', 'xy', 'xz'].forEach((c, k) => { out[16 * i + 4 * row + k] = column(r + 'xyz'[k])[i]; });
        out[16 * i + 4 * row + 3] = column(r + '_m')[i];
      });
      const h = Math.imul(column('instance')[i], 0x9E3779B1) >>> 8;
      const vary = column('instance')[i] && about.kind !== 'ground' ? 1 + 0.14 * ((h & 255) / 127.5 - 1) * (about.kind === 'plant' ? 1 : 0.5) : 1;
      about.color.forEach((c, k) => { out[16 * i + 12 + k] = Math.min(1, c / 255 * vary); });
      out[16 * i + 15] = 1;
    }
    return out;
  }

  /** Around what stands at each place: center and radius. */
  static ballsOf({positions: p}, places) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < p.length; ++i) { low[i % 3] = Math.min(low[i % 3], p[i]); high[i % 3] = Math.max(high[i % 3], p[i]); }
    const middle = low.map((x, c) => (x + high[c]) / 2), radius = Math.hypot(...sub(high, low)) / 2, out = new Float32Array(places.length / 4);
    for (let k = 0; k < places.length / 16; ++k) {
      const T = places.subarray(16 * k, 16 * k + 12);
      for (let row = 0; row < 3; ++row) out[4 * k + row] = T[4 * row] * middle[0] + T[4 * row + 1] * middle[1] + T[4 * row + 2] * middle[2] + T[4 * row + 3];
      out[4 * k + 3] = radius * Math.max(...[0, 1, 2].map((c) => Math.hypot(T[c], T[c + 4], T[c + 8])));
    }
    return out;
  }

  /** The places that the view may see, gathered in `seen`. */
  static inSight(view, places, balls, seen) {
    const {eye, forward: f} = view, sides = [];
    for (const [axis, half] of [[view.right, view.half_width], [view.up, view.half_height]]) for (const s of [-1, 1]) sides.push(unit(along(f.map((x) => half * x), s, axis)));
    sides.push(f);
    let count = 0;
    for (let k = 0; k < places.length / 16; ++k) {
      const x = balls[4 * k] - eye[0], y = balls[4 * k + 1] - eye[1], z = balls[4 * k + 2] - eye[2], r = balls[4 * k + 3];
      if (sides.some((n) => n[0] * x + n[1] * y + n[2] * z < -r)) continue;
      seen.set(places.subarray(16 * k, 16 * k + 16), 16 * count++);
    }
    return seen.subarray(0, 16 * count);
  }

  // --- Cameras ---------------------------------------------------------------------------------------------------------

  /** Eye and axes at t. */
  view(t) {
    const {camera, painter} = this, canvas = painter.canvas;
    const fov = camera.kind === 'onboard' ? 1.35 : 0.9, aspect = canvas.width / Math.max(1, canvas.height);
    let eye, forward, up = [0, 0, 1];
    const at = camera.kind === 'orbit' || camera.kind === 'top' ? null : this.run.vehicleAt(camera.vehicle, t);
    if (camera.kind === 'onboard' && at) {
      const back = -0.02 * this.choices.scale;
      eye = along(along(at.p, back, turn(at.R, [1, 0, 0])), 0.12 * this.choices.scale, turn(at.R, [0, 0, 1]));
      forward = turn(at.R, [1, 0, 0]);
      up = turn(at.R, [0, 0, 1]);
    } else {
      const target = at ? along(at.p, 1, camera.offset || [0, 0, 0]) : camera.target;
      const pitch = camera.kind === 'top' ? Math.PI / 2 : camera.pitch, yaw = camera.kind === 'top' ? -Math.PI / 2 : camera.yaw;
      const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
      eye = along(target, camera.distance, back);
      forward = back.map((x) => -x);
      if (pitch > 1.55) up = [-Math.cos(yaw), -Math.sin(yaw), 0];
    }
    const right = unit(cross(forward, up));
    up = cross(right, forward);
    const near = camera.kind === 'onboard' ? 0.05 : Math.max(0.05, 0.01 * camera.distance), far = 4 * this.size_m + 10 * camera.distance + 500;
    const clip = Mat.multiply(Mat.perspective(fov, aspect, near, far), Mat.view(eye, right, up, forward.map((x) => -x)));
    const half_height = Math.tan(fov / 2);
    return {eye, forward, right, up, clip, half_height, half_width: half_height * aspect, pixels_at_1m: canvas.height / (2 * half_height),
            hidden: camera.kind === 'onboard' ? camera.vehicle : -1, close: camera.kind === 'follow' || camera.kind === 'onboard'};
  }

  /** Pixels of CSS, and the depth; null behind the eye. */
  project(p, view) {
    const c = view.clip, w = c[3] * p[0] + c[7] * p[1] + c[11] * p[2] + c[15];
    if (w < 0.02) return null;
    const {clientWidth, clientHeight} = this.painter.canvas;
    return [(0.5 + 0.5 * (c[0] * p[0] + c[4] * p[1] + c[8] * p[2] + c[12]) / w) * clientWidth,
            (0.5 - 0.5 * (c[1] * p[0] + c[5] * p[1] + c[9] * p[2] + c[13]) / w) * clientHeight, w];
  }

  // --- A picture -------------------------------------------------------------------------------------------------------

  draw(t) {
    const {painter, layers, choices} = this, gl = painter.gl;
    const view = this.view(t), sky = kSkies[choices.sky];
    gl.viewport(0, 0, painter.canvas.width, painter.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    painter.drawSky(view, sky);
    this.lines = [];
    this.areas = [];
    this.cubes = [];
    this.balls = [];
    this.dots = new Map();
    this.legend = [];
    this.labels = [];

    const now = this.run.vehicles.map((_, i) => this.run.vehicleAt(i, t));
    const at = painter.use('mesh', view);
    gl.uniform3fv(at.u_haze, sky.horizon);
    gl.uniform1f(at.u_reach, 1.6 * this.size_m + 60);
    gl.uniform1f(at.u_dim, sky.dim);
    gl.uniform1f(at.u_cut, choices.cut === 'none' || view.close ? 1e9 : Number(choices.cut));
    if (layers.world) {
      for (const {mesh, kind, places, balls, seen} of this.world) {
        if (kind === 'plant' && this.hurried) continue;
        painter.place(mesh, Scene.inSight(view, places, balls, seen), true);
        gl.uniform1f(at.u_grid, kind === 'ground' ? 10 : 0);
        painter.drawMesh(mesh);
      }
    }
    gl.uniform1f(at.u_grid, 0);
    gl.uniform1f(at.u_cut, 1e9);
    gl.uniform1f(at.u_dim, 1);
    if (layers.vehicles) now.forEach((state, i) => { if (state && i !== view.hidden) this.drawVehicle(i, state); });

    this.drawn_points = 0;
    if (layers.sweeps) this.drawScans(t, view);
    if (layers.trails) this.addTrails(t);
    if (layers.detections) this.addDetections(t);
    if (layers.tracks || layers.covariances) this.addTracks(t);
    if (layers.radio) this.addRadio(t, now);
    if (layers.estimates || layers.references) now.forEach((state, i) => { if (state) this.addBeliefs(i, state); });
    if (layers.events) this.addEvents(t);
    this.addOverlays(t);

    const solid = painter.use('mesh', view);
    gl.uniform1f(solid.u_dim, 1);
    for (const [mesh, list] of [[this.cube, this.cubes], [this.ball, this.balls]]) {
      if (!list.length) continue;
      painter.place(mesh, new Float32Array(list), true);
      gl.enable(gl.BLEND);
      painter.drawMesh(mesh);
      gl.disable(gl.BLEND);
    }
    for (const [size, numbers] of this.dots) painter.drawDots(numbers, size, view);
    painter.drawLines(this.lines, view);
    painter.drawAreas(this.areas, view);
    if (layers.names) now.forEach((state, i) => {
      if (state && i !== view.hidden) this.labels.push({text: this.run.vehicles[i].name, color: this.run.vehicles[i].color, p: along(state.p, 0.5 * choices.scale + 0.15, [0, 0, 1])});
    });
    this.last_view = view;
    return view;
  }

  static placed(R, p, scale, color, alpha = 1) {
    const s = Array.isArray(scale) ? scale : [scale, scale, scale];
    return [R[0] * s[0], R[1] * s[1], R[2] * s[2], p[0], R[3] * s[0], R[4] * s[1], R[5] * s[2], p[1],
            R[6] * s[0], R[7] * s[1], R[8] * s[2], p[2], color[0], color[1], color[2], alpha];
  }

  drawVehicle(index, state) {
    const {painter, choices} = this, gl = painter.gl, parts = this.parts[index], scale = choices.scale;
    for (const {mesh, color} of parts.meshes) {
      painter.place(mesh, new Float32Array(Scene.placed(state.R, state.p, scale, state.crashed ? color.map((c) => 0.35 * c) : color)), true);
      painter.drawMesh(mesh);
    }
    const spinning = state.mix('rotor0_radps') > 30;
    for (const rotor of parts.rotors) {
      const a = rotor.direction * state.turned, c = Math.cos(a), s = Math.sin(a), R = state.R;
      const spun = [0, 3, 6].flatMap((r) => [R[r] * c + R[r + 1] * s, R[r + 1] * c - R[r] * s, R[r + 2]]);
      const hub = along(state.p, scale, turn(R, rotor.hub));
      painter.place(rotor.mesh, new Float32Array(Scene.placed(spun, hub, scale * rotor.radius_m, [0.1, 0.1, 0.11])), true);
      painter.drawMesh(rotor.mesh);
      if (!spinning) continue;
      const tint = this.run.vehicles[index].color.map((x) => 0.35 * x / 255 + 0.42);
      painter.place(this.disc, new Float32Array(Scene.placed(R, along(hub, 0.004, turn(R, [0, 0, 1])), scale * rotor.radius_m, tint, 0.32)), true);
      gl.enable(gl.BLEND); gl.depthMask(false);
      painter.drawMesh(this.disc);
      gl.depthMask(true); gl.disable(gl.BLEND);
    }
  }

  line(a, b, color, width, alpha = 1) {
    this.lines.push(a[0], a[1], a[2], b[0], b[1], b[2], color[0], color[1], color[2], alpha, width);
  }

  addTrails(t) {
    for (const vehicle of this.run.vehicles) {
      const {state} = vehicle, color = vehicle.color.map((c) => c / 255), last = state.rowAt(t);
      if (last < 1) continue;
      const x = state.get('x_m'), y = state.get('y_m'), z = state.get('z_m'), times = state.get('t_s');
      const first = this.choices.trail_s > 1e5 ? 0 : Math.max(0, state.rowAt(t - this.choices.trail_s));
      const step = Math.max(2, Math.ceil((last - first) / 600));
      const now = this.run.vehicleAt(vehicle.index, t).p;
      let from = now;
      for (let i = last; i >= first; i -= step) {
        const to = [x[i], y[i], z[i]];
        this.line(from, to, color, 2.2, this.choices.trail_s > 1e5 ? 0.85 : 0.15 + 0.75 * Math.max(0, 1 - (t - times[i]) / this.choices.trail_s));
        from = to;
      }
    }
  }

  /** The scans that count at t: of each LiDAR the latest, and those that are kept. */
  scansAt(t) {
    const {scans} = this.run, keep = this.choices.keep_s, found = [], seen = new Set();
    let low = 0, high = scans.length;
    while (low < high) { const middle = low + high >> 1; if (scans[middle].end_s <= t + 1e-6) low = middle + 1; else high = middle; }
    for (let i = low - 1; i >= 0; --i) {
      const scan = scans[i], key = scan.vehicle + '/' + scan.sensor;
      if (scan.end_s < t - Math.max(keep, 2.5)) break;
      if (seen.has(key) && scan.end_s < t - keep) continue;
      seen.add(key);
      if (this.hidden_sensors && this.hidden_sensors.has(key)) continue;
      found.push(scan);
    }
    return found;
  }

  colorize(scan, bytes) {
    const {palette} = this.run.head, mode = this.choices.color, vehicle = this.run.vehicles[scan.vehicle];
    const ramp = (colors, s) => colors[Math.max(0, Math.min(colors.length - 1, Math.round(s * (colors.length - 1)) || 0))];
    const classes = this.classes || (this.classes = new Map(palette.classes.map((c) => [c.number, c])));
    const sensors = this.sensors();
    const fixed = mode === 'vehicle' ? vehicle.color : kSensorColors[sensors.indexOf(scan.vehicle + '/' + scan.sensor) % kSensorColors.length];
    for (let i = 0; i < scan.count; ++i) {
      const color = mode === 'height' ? ramp(palette.height, (scan.p_world_m[3 * i + 2] - this.scale.low) / (this.scale.high - this.scale.low))
        : mode === 'range' ? ramp(palette.height, scan.range_m[i] / this.scale.range)
        : mode === 'intensity' ? ramp(palette.intensity, (scan.intensity_dB[i] + 25) / 45)
        : mode === 'label' ? (classes.get(scan.class[i]) || {color: [160, 160, 160]}).color : fixed;
      bytes[16 * i + 12] = color[0]; bytes[16 * i + 13] = color[1]; bytes[16 * i + 14] = color[2]; bytes[16 * i + 15] = 255;
    }
  }

  sensors() { return [...new Set(this.run.scans.map((s) => s.vehicle + '/' + s.sensor))].sort(); }

  /** Ends of the color scales, from the first scans, so that they stay the same. */
  measure() {
    const heights = [], ranges = [];
    for (const scan of this.run.scans.slice(0, 40)) {
      for (let i = 0; i < scan.count; i += 7) { heights.push(scan.p_world_m[3 * i + 2]); ranges.push(scan.range_m[i]); }
    }
    const share = (list, s) => list.sort((a, b) => a - b)[Math.min(list.length - 1, Math.floor(s * list.length))] || 0;
    const low = share(heights, 0.01), high = share(heights, 0.98);
    this.scale = {low, high: Math.max(high, low + 1), range: Math.max(5, share(ranges, 0.95))};
  }

  drawScans(t, view) {
    const {painter, choices} = this, gl = painter.gl;
    if (!this.scale || this.measured !== this.run.scans.length) {
      if (!this.scale || this.run.scans.length < 41) this.measure();
      this.measured = this.run.scans.length;
    }
    const scans = this.scansAt(t), mode = choices.color;
    if (this.cloud_mode !== mode || this.cloud.size > 600) {
      for (const made of this.cloud.values()) painter.free(made);
      this.cloud.clear();
      this.cloud_mode = mode;
    }
    const at = painter.use('point', view);
    gl.uniform1f(at.u_size, 0.02 * choices.point * view.pixels_at_1m);
    gl.uniform1f(at.u_least, choices.point);
    for (const scan of scans) {
      if (!scan.count) continue;
      let made = this.cloud.get(scan);
      if (!made) {
        const bytes = new Uint8Array(16 * scan.count), floats = new Float32Array(bytes.buffer);
        for (let i = 0; i < scan.count; ++i) for (let c = 0; c < 3; ++c) floats[4 * i + c] = scan.p_world_m[3 * i + c];
        this.colorize(scan, bytes);
        made = painter.points(bytes);
        this.cloud.set(scan, made);
      }
      gl.bindVertexArray(made.array);
      gl.drawArrays(gl.POINTS, 0, made.count);
      this.drawn_points += made.count;
    }
    const {palette} = this.run.head;
    if (!scans.length) return;
    if (mode === 'height') this.legend.push({scale: palette.height, low: this.scale.low.toFixed(1), high: this.scale.high.toFixed(1) + ' m', text: 'height of points'});
    if (mode === 'range') this.legend.push({scale: palette.height, low: '0', high: this.scale.range.toFixed(0) + ' m', text: 'range of points'});
    if (mode === 'intensity') this.legend.push({scale: palette.intensity, low: '-25', high: '20 dB', text: 'intensity of points'});
    if (mode === 'label') {
      const present = new Set(scans.flatMap((s) => [...new Set(s.class)]));
      for (const c of palette.classes) if (present.has(c.number)) this.legend.push({color: c.color, text: c.name});
    }
    if (mode === 'sensor') this.sensors().forEach((key, i) => this.legend.push({color: kSensorColors[i % kSensorColors.length], text: this.run.vehicles[parseInt(key, 10)].name + '/' + key.slice(key.indexOf('/') + 1)}));
  }

  addDetections(t) {
    const table = this.run.tables.detections, times = table.rows && table.get('t_s');
    const fresh_s = 0.4;
    let any = false;
    for (let i = table.rowAt(t); i >= 0 && times[i] > t - fresh_s; --i) {
      const p = ['x_m', 'y_m', 'z_m'].map((c) => table.get(c)[i]);
      const half = ['extent_x_m', 'extent_y_m', 'extent_z_m'].map((c) => Math.max(0.15, table.get(c)[i] / 2 + 0.08));
      this.box(p, half, kDetectionColor, 1 - 0.7 * (t - times[i]) / fresh_s);
      any = true;
    }
    if (any) this.legend.push({color: kDetectionColor.map((c) => 255 * c), text: 'detection'});
  }

  box(p, h, color, alpha) {
    for (let axis = 0; axis < 3; ++axis) for (const u of [-1, 1]) for (const v of [-1, 1]) {
      const a = [...p], b = [...p], j = (axis + 1) % 3, k = (axis + 2) % 3;
      a[axis] -= h[axis]; b[axis] += h[axis];
      a[j] = b[j] = p[j] + u * h[j];
      a[k] = b[k] = p[k] + v * h[k];
      this.line(a, b, color, 2, alpha);
    }
  }

  addTracks(t) {
    const {tracks, track_updates} = this.run.tables;
    if (!tracks.rows) return;
    // What each vehicle followed when its tracker last took a cloud, and where that has gone since.
    const newest = new Map(), update_t = track_updates.get('t_s'), update_v = track_updates.get('vehicle');
    for (let i = track_updates.rowAt(t); i >= 0 && update_t[i] > t - 1; --i) if (!newest.has(update_v[i])) newest.set(update_v[i], update_t[i]);
    const times = tracks.get('t_s'), get = (name, i) => tracks.get(name)[i];
    let any = false;
    for (let i = tracks.rowAt(t); i >= 0 && times[i] > t - 6; --i) {
      const color = kTrackColors[get('id', i) % kTrackColors.length], p = [get('x_m', i), get('y_m', i), get('z_m', i)];
      const current = Math.abs(times[i] - (newest.get(get('vehicle', i)) ?? -9)) < 1e-6;
      if (!current) {
        if (this.layers.tracks) this.dot(p, color, 0.05, 0.6);
        continue;
      }
      any = true;
      const v = [get('vx_mps', i), get('vy_mps', i), get('vz_mps', i)], now = along(p, t - times[i], v);
      if (this.layers.tracks) {
        this.balls.push(...Scene.placed([1, 0, 0, 0, 1, 0, 0, 0, 1], now, 0.12 * this.choices.scale, color));
        this.line(now, along(now, 1, v), color, 2.5, 0.9);
        this.labels.push({text: '#' + get('id', i), color: color.map((c) => 255 * c), p: along(now, -0.45, [0, 0, 1])});
      }
      if (this.layers.covariances) this.ellipsoid(now, ['xx', 'xy', 'xz', 'yy', 'yz', 'zz'].map((c) => get(c, i)), color);
    }
    if (any) this.legend.push({color: kTrackColors[0].map((c) => 255 * c), text: 'track and its velocity; colors by identity'});
  }

  /** Three standard deviations: the images of three circles under a root of the covariance (Cholesky). */
  ellipsoid(p, [xx, xy, xz, yy, yz, zz], color) {
    const a = Math.sqrt(Math.max(xx, 0)), b = a && xy / a, c = a && xz / a, d = Math.sqrt(Math.max(yy - b * b, 0));
    const e = d && (yz - b * c) / d, f = Math.sqrt(Math.max(zz - c * c - e * e, 0));
    const at = (u) => [p[0] + 3 * a * u[0], p[1] + 3 * (b * u[0] + d * u[1]), p[2] + 3 * (c * u[0] + e * u[1] + f * u[2])];
    for (let plane = 0; plane < 3; ++plane) {
      let last = null;
      for (let k = 0; k <= 24; ++k) {
        const u = [0, 0, 0];
        u[plane] = Math.cos(k * Math.PI / 12); u[(plane + 1) % 3] = Math.sin(k * Math.PI / 12);
        const next = at(u);
        if (last) this.line(last, next, color, 1.2, 0.75);
        last = next;
      }
    }
  }

  dot(p, color, size_m, alpha = 1) {
    if (!this.dots.has(size_m)) this.dots.set(size_m, []);
    this.dots.get(size_m).push(p[0], p[1], p[2], color[0], color[1], color[2], alpha);
  }

  addRadio(t, now) {
    const table = this.run.tables.radio, times = table.rows && table.get('t_s');
    for (let i = table.rowAt(t); i >= 0 && times[i] > t - 0.2001; --i) {
      const from = table.get('from')[i], to = table.get('to')[i];
      if (!now[from] || !now[to]) continue;
      const a = now[from].p, b = now[to].p, side = from < to ? 0.06 : -0.06;
      const color = this.run.vehicles[from].color.map((c) => c / 255);
      this.line(along(a, side, [0, 0, 1]), along(b, side, [0, 0, 1]), color, 1 + Math.min(3, Math.log2(1 + table.get('messages')[i]) / 2), 0.55);
    }
  }

  addBeliefs(index, state) {
    const color = this.run.vehicles[index].color.map((c) => c / 255);
    const place = (prefix) => ['x_m', 'y_m', 'z_m'].map((c) => state.mix(prefix + c));
    if (this.layers.estimates) {
      const p = place('est_');
      if (p.every(Number.isFinite)) {
        this.box(p, [0.2, 0.2, 0.08].map((x) => x * this.choices.scale), [1, 1, 1], 0.9);
        this.line(state.p, p, [1, 1, 1], 1.5, 0.9);
      }
    }
    if (!this.layers.references) return;
    const p = place('ref_');
    this.line(state.p, p, color, 1.2, 0.7);
    this.balls.push(...Scene.placed([1, 0, 0, 0, 1, 0, 0, 0, 1], p, 0.07 * this.choices.scale, color));
  }

  addEvents(t) {
    for (const event of this.run.events) {
      if (event.kind !== 'crash' || event.t_s > t) continue;
      const p = event.position_m;
      for (const d of [[1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]]) this.line(along(p, -0.5, d), along(p, 0.5, d), [0.9, 0.1, 0.1], 3);
      this.labels.push({text: '✕ ' + event.partner, color: [255, 110, 100], p: along(p, 0.8, [0, 0, 1])});
    }
  }

  /** The name of an overlay without the number of its part. */
  static groupOf(key) { return key.slice(key.indexOf('/') + 1).replace(/#\d+$/, ''); }

  addOverlays(t) {
    const told = new Set();
    for (const key of this.run.overlays.keys()) {
      const group = Scene.groupOf(key);
      if (!this.groups.has(group)) this.groups.set(group, !kOffAtFirst.test(group));
      if (!this.groups.get(group)) continue;
      const overlay = this.run.overlayAt(key, t);
      if (!overlay) continue;
      this.addOverlay(overlay);
      for (const {meaning, color} of overlay.about.legend || []) {
        if (!told.has(meaning)) this.legend.push({color, text: meaning});
        told.add(meaning);
      }
    }
  }

  addOverlay({about, p_world_m: p, colors, count}) {
    const own = [...this.run.vehicles[about.vehicle].color, about.kind === 'triangles' ? 77 : 255];
    const palette = (about.palette.length ? about.palette : [own]).map((c) => c.map((x) => x / 255));
    const color = (i) => palette[colors ? colors[i] : 0], at = (i) => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
    const line = (i, j) => { const c = color(i); this.line(at(i), at(j), c, Math.max(1, about.size), c[3]); };
    const same = [1, 0, 0, 0, 1, 0, 0, 0, 1];
    if (about.kind === 'lines') for (let i = 0; i + 1 < count; i += 2) line(i, i + 1);
    if (about.kind === 'polyline') for (let i = 0; i + 1 < count; ++i) line(i, i + 1);
    if (about.kind === 'cubes') for (let i = 0; i < count; ++i) this.cubes.push(...Scene.placed(same, at(i), about.size, color(i), Math.max(0.55, color(i)[3])));
    if (about.kind === 'spheres') for (let i = 0; i < count; ++i) this.balls.push(...Scene.placed(same, at(i), about.size, color(i), color(i)[3]));
    if (about.kind === 'points') for (let i = 0; i < count; ++i) this.dot(at(i), color(i), about.size, color(i)[3]);
    if (about.kind === 'triangles') for (let i = 0; i < count; ++i) this.areas.push(...at(i), ...color(i));
  }

  /** What lies under a pixel: {vehicle} or {scan, point}, the nearest to the eye. */
  pick(x, y, t) {
    const view = this.view(t);
    let best = null, depth = Infinity;
    this.run.vehicles.forEach((_, i) => {
      const state = this.run.vehicleAt(i, t), at = state && i !== view.hidden && this.project(state.p, view);
      if (!at) return;
      const reach = Math.max(9, 0.35 * this.choices.scale * view.pixels_at_1m / at[2] * this.painter.canvas.clientHeight / this.painter.canvas.height);
      if (Math.hypot(at[0] - x, at[1] - y) < reach && at[2] < depth) { depth = at[2]; best = {vehicle: i}; }
    });
    if (!this.layers.sweeps || best) return best;
    for (const scan of this.scansAt(t)) {
      for (let i = 0; i < scan.count; ++i) {
        const at = this.project([scan.p_world_m[3 * i], scan.p_world_m[3 * i + 1], scan.p_world_m[3 * i + 2]], view);
        if (at && at[2] < depth && Math.abs(at[0] - x) < 5 && Math.abs(at[1] - y) < 5) { depth = at[2]; best = {scan, point: i}; }
      }
    }
    return best;
  }
}
