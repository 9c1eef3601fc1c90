// SPDX-License-Identifier: BSD-3-Clause
// The picture at one time: layers, overlays, and picking at the pointer.
'use strict';

const kSkies = {
  day: {zenith: [0.46, 0.62, 0.84], horizon: [0.86, 0.90, 0.95], below: [0.80, 0.82, 0.84], dim: 1},
  dark: {zenith: [0.06, 0.07, 0.09], horizon: [0.10, 0.115, 0.14], below: [0.09, 0.10, 0.12], dim: 0.42},
};
// Distinguishable with color blindness (Okabe and Ito 2008), as in the pictures.
const kTrackColors = [[0.90, 0.62, 0], [0.34, 0.71, 0.91], [0, 0.62, 0.45], [0.94, 0.89, 0.26], [0.80, 0.47, 0.65], [0.84, 0.37, 0]];
const kDetectionColor = [0.95, 0.2, 0.2];

const kCuts = ['2', '4', '8', '15'];

/** Overlays that are off at first because they hide much of the picture. */
const kOffAtFirst = /^(voxels|map)\.|^reference$|clusters|samples|sensing|window/;

class Scene {
  constructor(painter, run) {
    this.painter = painter;
    this.run = run;
    this.layers = {};
    for (const [key, , , on] of kLayers) this.layers[key] = on;
    this.groups = new Map();  // overlays by name: on or off
    this.choices = {color: 'height', keep_s: 1, trail_s: 15, scale: 1, sky: 'day', cut: 'none', point: 2};
    this.camera = new Camera();
    this.points = new Points(painter, run, this.choices);
    this.cube = painter.mesh(...cube());
    this.ball = painter.mesh(...ball());
    this.disc = painter.mesh(...disc());
    this.parts = [];
    this.world = [];
    this.legend = [];
  }

  /** Called when header and world are received. */
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

  /** Initial view: the whole team at the first time. */
  look() {
    const places = this.run.vehicles.map((_, i) => this.run.vehicleAt(i, 0)).filter(Boolean).map((v) => v.p);
    if (!places.length) return;
    const low = [0, 1, 2].map((i) => Math.min(...places.map((p) => p[i]))), high = [0, 1, 2].map((i) => Math.max(...places.map((p) => p[i])));
    this.camera.target = low.map((x, i) => (x + high[i]) / 2);
    this.camera.distance = Math.min(Math.max(9, 1.15 * Math.hypot(...sub(high, low))), 120);
    // Crowns would hide vehicles that fly below them.
    if (this.run.world.some((mesh) => mesh.about.kind === 'plant')) this.choices.cut = kCuts.find((cut) => Number(cut) > high[2] + 1) || 'none';
  }

  /** Transform and color of each placement; colors of trees vary. */
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

  /** Bounding sphere of each placement: center and radius. */
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

  /** Collects the possibly visible placements in `seen`. */
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

  /** Eye, axes and projection at t. */
  view(t) {
    const {camera} = this, at = camera.follows ? this.run.vehicleAt(camera.vehicle, t) : null;
    return camera.view(at, this.painter.canvas, this.choices.scale, this.size_m);
  }

  /** Projection to CSS pixels, with depth; null behind the eye. */
  project(p, view) {
    const c = view.clip, w = c[3] * p[0] + c[7] * p[1] + c[11] * p[2] + c[15];
    if (w < 0.02) return null;
    const {clientWidth, clientHeight} = this.painter.canvas;
    return [(0.5 + 0.5 * (c[0] * p[0] + c[4] * p[1] + c[8] * p[2] + c[12]) / w) * clientWidth,
            (0.5 - 0.5 * (c[1] * p[0] + c[5] * p[1] + c[9] * p[2] + c[13]) / w) * clientHeight, w];
  }

  // --- A picture -------------------------------------------------------------------------------------------------------

  draw(t) {
    const {painter, layers} = this, gl = painter.gl, view = this.view(t);
    gl.viewport(0, 0, painter.canvas.width, painter.canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    painter.drawSky(view, kSkies[this.choices.sky]);
    Object.assign(this, {lines: [], areas: [], cubes: [], balls: [], dots: new Map(), legend: [], labels: []});
    const now = this.run.vehicles.map((_, i) => this.run.vehicleAt(i, t));
    this.drawWorld(view, now);
    if (layers.sweeps) this.points.draw(t, view, this.legend);
    if (layers.trails) this.addTrails(t);
    if (layers.detections) this.addDetections(t);
    if (layers.tracks || layers.covariances) this.addTracks(t);
    if (layers.radio) this.addRadio(t, now);
    if (layers.estimates || layers.references) now.forEach((state, i) => { if (state) this.addBeliefs(i, state); });
    if (layers.events) this.addEvents(t);
    this.addOverlays(t);
    this.drawAdded(view);
    if (layers.names) this.addNames(now, view);
    this.last_view = view;
    return view;
  }

  drawWorld(view, now) {
    const {painter, layers, choices} = this, gl = painter.gl, sky = kSkies[choices.sky], at = painter.use('mesh', view);
    gl.uniform3fv(at.u_haze, sky.horizon);
    gl.uniform1f(at.u_reach, 1.6 * this.size_m + 60);
    gl.uniform1f(at.u_dim, sky.dim);
    gl.uniform1f(at.u_cut, choices.cut === 'none' || view.close ? 1e9 : Number(choices.cut));
    for (const {mesh, kind, places, balls, seen} of layers.world ? this.world : []) {
      if (kind === 'plant' && this.hurried) continue;
      painter.place(mesh, Scene.inSight(view, places, balls, seen), true);
      gl.uniform1f(at.u_grid, kind === 'ground' ? 10 : 0);
      painter.drawMesh(mesh);
    }
    gl.uniform1f(at.u_grid, 0);
    gl.uniform1f(at.u_cut, 1e9);
    gl.uniform1f(at.u_dim, 1);
    if (layers.vehicles) now.forEach((state, i) => { if (state && i !== view.hidden) this.drawVehicle(i, state); });
  }

  /** Draws the lines, bodies, dots and areas added by layers. */
  drawAdded(view) {
    const {painter} = this, gl = painter.gl, at = painter.use('mesh', view);
    gl.uniform1f(at.u_dim, 1);
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
  }

  addNames(now, view) {
    now.forEach((state, i) => {
      const {name, color} = this.run.vehicles[i];
      if (state && i !== view.hidden) this.labels.push({text: name, color, p: along(state.p, 0.5 * this.choices.scale + 0.15, [0, 0, 1])});
    });
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
    // Tracks of the latest update of each vehicle, predicted to t. Earlier ones are drawn as dots.
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

  /** The group of an overlay; created if new. */
  addGroup(key) {
    const group = Scene.groupOf(key);
    if (!this.groups.has(group)) this.groups.set(group, !kOffAtFirst.test(group));
    return group;
  }

  addOverlays(t) {
    const explained = new Set();
    for (const key of this.run.overlays.keys()) {
      if (!this.groups.get(this.addGroup(key))) continue;
      const overlay = this.run.overlayAt(key, t);
      if (!overlay) continue;
      this.addOverlay(overlay);
      for (const {meaning, color} of overlay.about.legend || []) {
        if (!explained.has(meaning)) this.legend.push({color, text: meaning});
        explained.add(meaning);
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

  /** The nearest vehicle or point within some pixels of a place: {vehicle} or {scan, point}. */
  pick(x, y, t, within = 5) {
    const view = this.view(t);
    let best = null, depth = Infinity;
    this.run.vehicles.forEach((_, i) => {
      const state = this.run.vehicleAt(i, t), at = state && i !== view.hidden && this.project(state.p, view);
      if (!at) return;
      const reach = Math.max(4 + within, 0.35 * this.choices.scale * view.pixels_at_1m / at[2] * this.painter.canvas.clientHeight / this.painter.canvas.height);
      if (Math.hypot(at[0] - x, at[1] - y) < reach && at[2] < depth) { depth = at[2]; best = {vehicle: i}; }
    });
    if (!this.layers.sweeps || best) return best;
    for (const scan of this.points.at(t)) {
      for (let i = 0; i < scan.count; ++i) {
        const at = this.project([scan.p_world_m[3 * i], scan.p_world_m[3 * i + 1], scan.p_world_m[3 * i + 2]], view);
        if (at && at[2] < depth && Math.abs(at[0] - x) < within && Math.abs(at[1] - y) < within) { depth = at[2]; best = {scan, point: i}; }
      }
    }
    return best;
  }
}
