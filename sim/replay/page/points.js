// SPDX-License-Identifier: BSD-3-Clause
// Points of the scans: selection by time, and colors.
'use strict';

const kSensorColors = [[66, 133, 220], [240, 150, 40], [60, 170, 110], [200, 80, 170], [150, 120, 90], [90, 200, 200]];

/** Scans that the ends of the color scales are computed from, evenly over the run. More take longer to measure. */
const kScaleScans = 160;
/** Edge of the cubes that the height scale counts. A cube counts once, so that dense returns from the ground nearby have no more weight than a crown. */
const kScaleCube_m = 1;

class Points {
  constructor(painter, run, choices) {
    Object.assign(this, {painter, run, choices, hidden: new Set(), buffers: new Map(), mode: '', scale: null, measured: 0});
  }

  static sensorOf(scan) { return scan.vehicle + '/' + scan.sensor; }

  /** "0/mid" for each LiDAR with scans. */
  sensors() {
    if (this.counted !== this.run.scans.length) {
      this.counted = this.run.scans.length;
      this.known = [...new Set(this.run.scans.map(Points.sensorOf))].sort();
    }
    return this.known;
  }

  nameOf(sensor) { return this.run.vehicles[parseInt(sensor, 10)].name + sensor.slice(sensor.indexOf('/')); }

  /** The scans shown at t: the latest of each LiDAR, and the earlier ones within the chosen time. */
  at(t) {
    const {scans} = this.run, keep = this.choices.keep_s, found = [], seen = new Set();
    let low = 0, high = scans.length;
    while (low < high) { const middle = low + high >> 1; if (scans[middle].end_s <= t + 1e-6) low = middle + 1; else high = middle; }
    for (let i = low - 1; i >= 0; --i) {
      const scan = scans[i], key = Points.sensorOf(scan);
      if (scan.end_s < t - Math.max(keep, 2.5)) break;
      if (seen.has(key) && scan.end_s < t - keep) continue;
      seen.add(key);
      if (!this.hidden.has(key)) found.push(scan);
    }
    return found;
  }

  /** Ends of the color scales, from scans of the whole run. Heights: 2nd and 98th percentile of the cubes that have points. Ranges: 95th percentile. */
  measure() {
    const {scans} = this.run, cubes = new Map(), ranges = [], step = Math.max(1, scans.length / kScaleScans);
    for (let k = 0; k < scans.length; k += step) {
      const {count, p_world_m: p, range_m} = scans[Math.floor(k)];
      for (let i = 0; i < count; i += 3) {
        const [x, y, z] = [0, 1, 2].map((c) => Math.floor(p[3 * i + c] / kScaleCube_m) + 8192);
        cubes.set((x * 16384 + y) * 16384 + z, p[3 * i + 2]);
        ranges.push(range_m[i]);
      }
    }
    const share = (values, s) => { const sorted = Float32Array.from(values).sort(); return sorted[Math.min(sorted.length - 1, Math.floor(s * sorted.length))] || 0; };
    const low = share(cubes.values(), 0.02), high = share(cubes.values(), 0.98);
    return {low, high: Math.max(high, low + 1), range: Math.max(5, share(ranges, 0.95))};
  }

  /** Scales are recomputed when the number of scans has doubled and when all have arrived. Earlier colors are discarded. */
  update() {
    const number = this.run.scans.length, {color} = this.choices;
    const grown = number > 0 && (number >= 2 * this.measured || this.run.complete && number !== this.measured);
    if (grown) {
      this.scale = this.measure();
      this.measured = number;
    }
    if (!grown && this.mode === color && this.buffers.size <= 600) return;
    for (const made of this.buffers.values()) this.painter.free(made);
    this.buffers.clear();
    this.mode = color;
  }

  /** Writes the color of each point, by the chosen property. */
  colorize(scan, bytes) {
    const {palette} = this.run.head, {scale} = this, vehicle = this.run.vehicles[scan.vehicle];
    const ramp = (colors, s) => colors[Math.max(0, Math.min(colors.length - 1, Math.round(s * (colors.length - 1)) || 0))];
    this.classes ??= new Map(palette.classes.map((c) => [c.number, c.color]));
    const sensor = kSensorColors[this.sensors().indexOf(Points.sensorOf(scan)) % kSensorColors.length];
    const colorOf = {
      height: (i) => ramp(palette.height, (scan.p_world_m[3 * i + 2] - scale.low) / (scale.high - scale.low)),
      range: (i) => ramp(palette.height, scan.range_m[i] / scale.range),
      intensity: (i) => ramp(palette.intensity, (scan.intensity_dB[i] + 25) / 45),
      label: (i) => this.classes.get(scan.class[i]) || [160, 160, 160],
      vehicle: () => vehicle.color,
      sensor: () => sensor,
    }[this.mode];
    for (let i = 0; i < scan.count; ++i) {
      const color = colorOf(i);
      bytes[16 * i + 12] = color[0]; bytes[16 * i + 13] = color[1]; bytes[16 * i + 14] = color[2]; bytes[16 * i + 15] = 255;
    }
  }

  /** The GPU buffer of a scan. */
  bufferOf(scan) {
    let made = this.buffers.get(scan);
    if (made) return made;
    const bytes = new Uint8Array(16 * scan.count), floats = new Float32Array(bytes.buffer);
    for (let i = 0; i < scan.count; ++i) for (let c = 0; c < 3; ++c) floats[4 * i + c] = scan.p_world_m[3 * i + c];
    this.colorize(scan, bytes);
    made = this.painter.points(bytes);
    this.buffers.set(scan, made);
    return made;
  }

  draw(t, view, legend) {
    this.update();
    const {painter, choices} = this, gl = painter.gl, scans = this.at(t).filter((scan) => scan.count), at = painter.use('point', view);
    gl.uniform1f(at.u_size, 0.02 * choices.point * view.pixels_at_1m);
    gl.uniform1f(at.u_least, choices.point);
    for (const scan of scans) {
      const {array, count} = this.bufferOf(scan);
      gl.bindVertexArray(array);
      gl.drawArrays(gl.POINTS, 0, count);
    }
    if (scans.length) this.explain(scans, legend);
  }

  /** The colors of the points in the legend. */
  explain(scans, legend) {
    const {palette} = this.run.head, {scale, mode} = this;
    if (mode === 'height') legend.push({scale: palette.height, low: (Math.round(10 * scale.low) / 10 + 0).toFixed(1), high: scale.high.toFixed(1) + ' m', text: 'height of points'});
    if (mode === 'range') legend.push({scale: palette.height, low: '0', high: scale.range.toFixed(0) + ' m', text: 'range of points'});
    if (mode === 'intensity') legend.push({scale: palette.intensity, low: '-25', high: '20 dB', text: 'intensity of points'});
    if (mode === 'label') {
      const present = new Set(scans.flatMap((s) => [...new Set(s.class)]));
      for (const c of palette.classes) if (present.has(c.number)) legend.push({color: c.color, text: c.name});
    }
    if (mode === 'sensor') this.sensors().forEach((key, i) => legend.push({color: kSensorColors[i % kSensorColors.length], text: this.nameOf(key)}));
  }
}
