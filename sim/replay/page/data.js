// SPDX-License-Identifier: BSD-3-Clause
// Recorded data: decodes the blocks of the page into tables and looks up their values by time.
'use strict';

/** A growing list of numbers. */
class Numbers {
  constructor(type = Float32Array) { this.array = new type(256); this.length = 0; }
  push(values) {
    if (this.length + values.length > this.array.length) {
      const larger = new this.array.constructor(Math.max(2 * this.array.length, this.length + values.length));
      larger.set(this.array.subarray(0, this.length));
      this.array = larger;
    }
    this.array.set(values, this.length);
    this.length += values.length;
  }
}

/** Index of the last of the sorted times at or before t, or -1. */
function lastAt(times, rows, t) {
  let low = 0, high = rows;
  while (low < high) {
    const middle = low + high >> 1;
    if (times[middle] <= t + 1e-6) low = middle + 1; else high = middle;
  }
  return low - 1;
}

/** Columns by name that grow chunk by chunk; "t_s" is in order of time. */
class Table {
  constructor() { this.columns = new Map(); this.rows = 0; }
  append(part) {
    for (const [name, values] of part.columns) {
      if (!this.columns.has(name)) this.columns.set(name, new Numbers(name === 't_s' ? Float64Array : Float32Array));
      this.columns.get(name).push(values);
    }
    this.rows += part.rows;
  }
  has(name) { return this.columns.has(name); }
  get(name) { return this.columns.get(name).array; }
  /** The last row at or before t, or -1. */
  rowAt(t) { return this.rows ? lastAt(this.get('t_s'), this.rows, t) : -1; }
}

const kMissing = -(1 << 29);

/** {about, tables: [{about, rows, columns: Map of name to Float64Array}]} of the bytes of sim/replay/block.hpp. */
function readBlock(bytes) {
  const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  let at = 4 + length;
  const tables = head.tables.map(({about, rows, columns}) => {
    const read = new Map();
    for (const [name, step] of columns || []) {
      const values = new Float64Array(rows);
      let value = 0;
      for (let row = 0; row < rows; ++row) {
        let digits = 0, shift = 0, byte;
        do {
          byte = bytes[at++];
          digits |= (byte & 127) << shift;
          shift += 7;
        } while (byte >= 128);
        value += digits >>> 1 ^ -(digits & 1);
        values[row] = value === kMissing ? NaN : value * step;
      }
      read.set(name, values);
    }
    return {about, rows, columns: read};
  });
  return {about: head.about, tables};
}

async function unpack(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function fromBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Interpolates nearby unit quaternions. */
function mixTurns(a, b, s) {
  const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
  const q = a.map((x, i) => (1 - s) * x + s * sign * b[i]);
  const n = Math.hypot(...q) || 1;
  return q.map((x) => x / n);
}

/** The points of a scan in the world, with their attributes. */
class Scan {
  constructor(points, poses) {
    const {vehicle, sensor, t_s, duration_s, returns} = points.about;
    Object.assign(this, {vehicle, sensor, start_s: t_s, duration_s, end_s: t_s + duration_s, returns, count: points.rows});
    for (const [name, values] of points.columns) this[name] = Float32Array.from(values);
    this.p_world_m = new Float32Array(3 * this.count);
    const columns = poses.columns.get('col'), number = poses.rows;
    const place = (k) => ['x_m', 'y_m', 'z_m'].map((c) => poses.columns.get(c)[k]);
    const turn = (k) => ['qx', 'qy', 'qz', 'qw'].map((c) => poses.columns.get(c)[k]);
    const places = [], turns = [];
    for (let k = 0; k < number; ++k) { places.push(place(k)); turns.push(turn(k)); }
    this.origin_m = places[number >> 1];
    const cache = new Map();  // pose by column
    const poseAt = (column) => {
      let pose = cache.get(column);
      if (pose) return pose;
      let k = 0;
      while (k + 2 < number && columns[k + 1] <= column) ++k;
      const next = Math.min(k + 1, number - 1);
      const s = next === k ? 0 : Math.min(1, Math.max(0, (column - columns[k]) / (columns[next] - columns[k] || 1)));
      pose = {p: places[k].map((x, i) => (1 - s) * x + s * places[next][i]), R: matrixOf(mixTurns(turns[k], turns[next], s))};
      cache.set(column, pose);
      return pose;
    };
    for (let i = 0; i < this.count; ++i) {
      const {p, R} = poseAt(this.col[i]);
      const azimuth = this.azimuth_rad[i], elevation = this.elevation_rad[i], range = this.range_m[i];
      const flat = range * Math.cos(elevation);
      const x = flat * Math.cos(azimuth), y = flat * Math.sin(azimuth), z = range * Math.sin(elevation);
      for (let r = 0; r < 3; ++r) this.p_world_m[3 * i + r] = p[r] + R[3 * r] * x + R[3 * r + 1] * y + R[3 * r + 2] * z;
    }
  }
}

/** Rotation matrix by rows, from a quaternion x, y, z, w. */
function matrixOf([x, y, z, w]) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
          2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
}

const kRotorSlowness = 0.04;  // drawn rotor speed / true speed, slow enough to be visible

/** All data of the run received so far. */
class Run {
  constructor() {
    this.head = null;
    this.vehicles = [];
    this.world = [];
    this.scans = [];
    this.overlays = new Map();  // "vehicle/name" -> [{t_s, about, p_world_m, colors}]
    this.tables = {detections: new Table(), tracks: new Table(), track_updates: new Table(), radio: new Table()};
    this.series = new Map();  // "name" -> Map of vehicle to Table
    this.events = [];
    this.end_s = 0;
    this.complete = false;
    this.blocks = 0;  // number of blocks read
  }

  add({about, tables}) {
    ++this.blocks;
    if (about.kind === 'head') this.begin(about, tables);
    if (about.kind === 'world') this.world = Run.meshes(tables);
    if (about.kind === 'scans') {
      for (let i = 0; i + 1 < tables.length; i += 2) this.scans.push(new Scan(tables[i], tables[i + 1]));
      this.scans.sort((a, b) => a.end_s - b.end_s);
    }
    if (about.kind === 'chunk') this.addChunk(about, tables);
    if (about.kind === 'end') { this.end_s = about.t_s; this.complete = true; }
  }

  begin(head, tables) {
    this.head = head;
    this.vehicles = head.vehicles.map((name, index) => (
      {name, index, color: head.palette.vehicles[index], state: new Table(), meshes: [], rotors: [], turned: new Numbers()}));
    for (const mesh of Run.meshes(tables)) this.vehicles[mesh.about.vehicle].meshes.push(mesh);
    for (const table of tables) {
      if (table.about.table !== 'rotors') continue;
      const column = (name) => table.columns.get(name);
      for (let i = 0; i < table.rows; ++i) {
        this.vehicles[table.about.vehicle].rotors.push({
          hub: [column('x_m')[i], column('y_m')[i], column('z_m')[i]], radius_m: column('radius_m')[i],
          chord_m: column('chord_m')[i], blades: column('blades')[i], direction: column('direction')[i]});
      }
    }
  }

  /** Tables in the order vertices, triangles and, for a world, placements. */
  static meshes(tables) {
    const meshes = [];
    for (const table of tables) {
      if (table.about.table === 'vertices') {
        const positions = new Float32Array(3 * table.rows);
        ['x_m', 'y_m', 'z_m'].forEach((name, c) => table.columns.get(name).forEach((v, i) => { positions[3 * i + c] = v; }));
        meshes.push({about: table.about, positions, indices: null, places: null});
      } else if (table.about.table === 'triangles') {
        const indices = new Uint32Array(3 * table.rows);
        ['a', 'b', 'c'].forEach((name, c) => table.columns.get(name).forEach((v, i) => { indices[3 * i + c] = v; }));
        meshes[meshes.length - 1].indices = indices;
      } else if (table.about.table === 'places') {
        meshes[meshes.length - 1].places = table;
      }
    }
    return meshes;
  }

  addChunk(about, tables) {
    this.events.push(...about.events);
    for (const table of tables) {
      const {table: kind, vehicle} = table.about;
      if (kind === 'state') this.addStates(this.vehicles[vehicle], table);
      if (kind in this.tables) this.tables[kind].append(table);
      if (kind === 'series') {
        const {name} = table.about;
        if (!this.series.has(name)) this.series.set(name, new Map());
        const of = this.series.get(name);
        if (!of.has(vehicle)) of.set(vehicle, new Table());
        of.get(vehicle).append(table);
      }
      if (kind === 'overlay') this.addOverlay(table);
    }
  }

  addStates(vehicle, part) {
    const c = (name) => part.columns.get(name);
    const norm = (names) => c('t_s').map((_, i) => Math.hypot(...names.map(([a, b]) => c(a)[i] - (b ? c(b)[i] : 0))));
    part.columns.set('speed_mps', norm([['vx_mps'], ['vy_mps'], ['vz_mps']]));
    part.columns.set('estimate_error_m', norm([['x_m', 'est_x_m'], ['y_m', 'est_y_m'], ['z_m', 'est_z_m']]));
    part.columns.set('reference_error_m', norm([['x_m', 'ref_x_m'], ['y_m', 'ref_y_m'], ['z_m', 'ref_z_m']]));
    part.columns.set('tilt_deg', c('t_s').map((_, i) => Math.acos(Math.max(-1, Math.min(1, 1 - 2 * (c('qx')[i] ** 2 + c('qy')[i] ** 2)))) * 180 / Math.PI));
    const before = vehicle.state.rows, last_t = before ? vehicle.state.get('t_s')[before - 1] : c('t_s')[0];
    let turned = before ? vehicle.turned.array[before - 1] : 0, then = last_t;
    vehicle.turned.push(c('t_s').map((t, i) => {
      turned += (c('rotor0_radps') ? c('rotor0_radps')[i] : 0) * (t - then) * kRotorSlowness;
      then = t;
      return turned;
    }));
    vehicle.state.append(part);
    this.end_s = Math.max(this.end_s, vehicle.state.get('t_s')[vehicle.state.rows - 1]);
  }

  addOverlay(table) {
    const {vehicle, name} = table.about, key = vehicle + '/' + name;
    if (!this.overlays.has(key)) this.overlays.set(key, []);
    const p = new Float32Array(3 * table.rows);
    ['x_m', 'y_m', 'z_m'].forEach((column, c) => (table.columns.get(column) || []).forEach((v, i) => { p[3 * i + c] = v; }));
    this.overlays.get(key).push({t_s: table.about.t_s, about: table.about, p_world_m: p, colors: table.columns.get('color'), count: table.rows});
  }

  /** Interpolated state of a vehicle at t; null before its first state. */
  vehicleAt(index, t) {
    const vehicle = this.vehicles[index], state = vehicle.state, row = Math.max(0, state.rowAt(t));
    if (state.rows === 0) return null;
    const next = Math.min(row + 1, state.rows - 1), times = state.get('t_s');
    const s = next === row ? 0 : Math.min(1, Math.max(0, (t - times[row]) / (times[next] - times[row])));
    const mix = (name) => { const a = state.get(name); return (1 - s) * a[row] + s * a[next]; };
    const q = (k) => ['qx', 'qy', 'qz', 'qw'].map((name) => state.get(name)[k]);
    const turned = vehicle.turned.array;
    return {row, p: [mix('x_m'), mix('y_m'), mix('z_m')], R: matrixOf(mixTurns(q(row), q(next), s)), mix,
            turned: (1 - s) * turned[row] + s * turned[next], crashed: state.get('crashed')[row] > 0.5};
  }

  /** The version of an overlay that is valid at t. */
  overlayAt(key, t) {
    const list = this.overlays.get(key);
    let found = null;
    for (const one of list) { if (one.t_s <= t + 1e-6) found = one; else break; }
    return found && found.count ? found : null;
  }

  signals() {
    const names = [];
    const hidden = new Set(['t_s', 'est_t_s', 'qx', 'qy', 'qz', 'qw', 'est_qx', 'est_qy', 'est_qz', 'est_qw', 'crashed']);
    if (this.vehicles.length) for (const name of this.vehicles[0].state.columns.keys()) if (!hidden.has(name)) names.push(name);
    for (const [table, of] of this.series) {
      const first = [...of.values()][0];
      for (const name of first.columns.keys()) if (name !== 't_s') names.push(table + '.' + name);
    }
    return names;
  }

  /** {t, y, rows} of a signal of a vehicle; null where it has none. */
  signal(name, vehicle) {
    const dot = name.indexOf('.');
    const of = dot < 0 ? null : this.series.get(name.slice(0, dot));
    const table = dot < 0 ? this.vehicles[vehicle].state : of && (of.get(vehicle) || (vehicle === 0 && of.get(-1)));
    const column = dot < 0 ? name : name.slice(dot + 1);
    return table && table.has(column) && table.has('t_s') ? {t: table.get('t_s'), y: table.get(column), rows: table.rows, loose: dot >= 0} : null;
  }
}
