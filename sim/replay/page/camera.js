// SPDX-License-Identifier: BSD-3-Clause
// The camera: its types, its control by a pointer, its projection.
'use strict';

class Camera {
  constructor() {
    Object.assign(this, {kind: 'orbit', vehicle: 0, target: [0, 0, 0], offset: [0, 0, 0], yaw: -2.2, pitch: 0.45, distance: 30});
  }

  get follows() { return this.kind === 'follow' || this.kind === 'onboard'; }

  /** Changes type and vehicle. `place` is the followed position, the new target of orbit and top. */
  change(kind, vehicle, place, scale) {
    if (this.follows && kind !== 'follow' && kind !== 'onboard' && place) this.target = place;
    if (kind === 'follow' && this.kind !== 'follow') {
      this.before = this.distance;
      this.distance = 5 * Math.sqrt(scale);
      this.pitch = 0.35;
      this.offset = [0, 0, 0];
    }
    if (kind !== 'follow' && this.kind === 'follow' && this.before) this.distance = this.before;
    this.kind = kind;
    this.vehicle = vehicle;
  }

  /** Orbits by a drag in pixels. */
  turn(dx, dy) {
    this.yaw -= 0.006 * dx;
    this.pitch = Math.max(-1.5, Math.min(1.56, this.pitch + 0.006 * dy));
  }

  zoom(factor) { this.distance = Math.max(0.5, Math.min(2000, this.distance * factor)); }

  /** Pans by a drag in CSS pixels; points at the target's depth stay under the pointer. */
  pan(dx, dy, view, canvas) {
    const scale = this.distance / view.pixels_at_1m * canvas.height / canvas.clientHeight;
    const shift = [0, 1, 2].map((i) => (-dx * view.right[i] + dy * view.up[i]) * scale);
    if (this.kind === 'follow') this.offset = along(this.offset, 1, shift);
    else this.target = along(this.target, 1, shift);
  }

  /** Eye and forward direction; `at` is the state of the followed vehicle. */
  eye(at, scale) {
    if (this.kind === 'onboard' && at) {
      const ahead = -0.02 * scale, up = turn(at.R, [0, 0, 1]), forward = turn(at.R, [1, 0, 0]);
      return {eye: along(along(at.p, ahead, forward), 0.12 * scale, up), forward, up};
    }
    const target = at ? along(at.p, 1, this.offset) : this.target;
    const pitch = this.kind === 'top' ? Math.PI / 2 : this.pitch, yaw = this.kind === 'top' ? -Math.PI / 2 : this.yaw;
    const back = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
    return {eye: along(target, this.distance, back), forward: back.map((x) => -x), up: pitch > 1.55 ? [-Math.cos(yaw), -Math.sin(yaw), 0] : [0, 0, 1]};
  }

  /** Axes and projection for a canvas. The field of view spans its shorter side, so that an upright phone does not show less. */
  view(at, canvas, scale, size_m) {
    const fov = this.kind === 'onboard' ? 1.35 : 0.9, aspect = canvas.width / Math.max(1, canvas.height);
    const half_height = Math.tan(fov / 2) / Math.min(1, aspect);
    const {eye, forward, up: above} = this.eye(at, scale), right = unit(cross(forward, above)), up = cross(right, forward);
    const near = this.kind === 'onboard' ? 0.05 : Math.max(0.05, 0.01 * this.distance), far = 4 * size_m + 10 * this.distance + 500;
    const clip = Mat.multiply(Mat.perspective(half_height, aspect, near, far), Mat.view(eye, right, up, forward.map((x) => -x)));
    return {eye, forward, right, up, clip, half_height, half_width: half_height * aspect, pixels_at_1m: canvas.height / (2 * half_height),
            hidden: this.kind === 'onboard' ? this.vehicle : -1, close: this.follows};
  }
}
