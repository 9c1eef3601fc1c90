// SPDX-License-Identifier: BSD-3-Clause
// Signals over time, and the time line: plain two-dimensional drawing.
'use strict';

/** A canvas whose pixels are the screen's. */
function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = '11px system-ui, "DejaVu Sans", sans-serif';
  return {context, width, height};
}

function themed(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

/** Round numbers that divide a range into about `count` parts. */
function ticksOf(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((s) => s * power >= raw) * power, ticks = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; ++k) ticks.push(k * step);
  return {ticks, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

const rgb = (color) => `rgb(${color[0]},${color[1]},${color[2]})`;

/** The curves of some signals of some vehicles, side by side, with the common cursor. */
class Plot {
  constructor(canvas, run) { this.canvas = canvas; this.run = run; this.signals = []; this.vehicles = null; }

  /** Left edge and width of the panel of a signal. */
  panel(k, width) {
    const gap = 62, each = (width - 14) / this.signals.length;
    return {left: 4 + k * each + gap - 12, width: each - gap};
  }

  /** Curves are drawn when something of them changed, and then the cursor alone moves over a copy of them. */
  draw(t) {
    const {context: c, width, height} = fitted(this.canvas), {canvas} = this;
    const key = [this.run.blocks, canvas.width, canvas.height, themed('--text'), this.signals, this.vehicles && [...this.vehicles]].join(' ');
    if (key !== this.drawn) {
      this.drawn = key;
      this.signals.forEach((name, k) => this.drawPanel(c, name, this.panel(k, width), 16, height - 34));
      this.curves = this.curves || document.createElement('canvas');
      this.curves.width = canvas.width; this.curves.height = canvas.height;
      this.curves.getContext('2d').drawImage(canvas, 0, 0);
    } else {
      c.drawImage(this.curves, 0, 0, width, height);
    }
    c.strokeStyle = themed('--accent'); c.lineWidth = 1;
    c.beginPath();
    this.signals.forEach((name, k) => {
      const panel = this.panel(k, width), x = panel.left + panel.width * t / Math.max(this.run.end_s, 1e-3);
      c.moveTo(x, 16); c.lineTo(x, height - 18);
    });
    c.stroke();
  }

  drawPanel(c, name, {left, width}, top, height) {
    const end = Math.max(this.run.end_s, 1e-3), curves = [];
    let low = Infinity, high = -Infinity;
    this.run.vehicles.forEach((vehicle, v) => {
      if (this.vehicles && !this.vehicles.has(v)) return;
      const signal = this.run.signal(name, v);
      if (!signal) return;
      for (let i = 0; i < signal.rows; ++i) if (Number.isFinite(signal.y[i])) { low = Math.min(low, signal.y[i]); high = Math.max(high, signal.y[i]); }
      curves.push({signal, color: rgb(vehicle.color)});
    });
    if (!(low <= high)) { low = 0; high = 1; }
    const margin = 0.06 * (high - low) || 0.5;
    low -= margin; high += margin;
    const x = (s) => left + width * s / end, y = (v) => top + height * (high - v) / (high - low);
    c.strokeStyle = themed('--line'); c.fillStyle = themed('--soft'); c.lineWidth = 1;
    const vertical = ticksOf(low, high, 4), horizontal = ticksOf(0, end, Math.max(2, width / 90));
    c.beginPath();
    c.textAlign = 'right'; c.textBaseline = 'middle';
    for (const v of vertical.ticks) { c.moveTo(left, Math.round(y(v)) + 0.5); c.lineTo(left + width, Math.round(y(v)) + 0.5); c.fillText(v.toFixed(vertical.digits), left - 5, y(v)); }
    c.textAlign = 'center'; c.textBaseline = 'top';
    for (const s of horizontal.ticks) { c.moveTo(Math.round(x(s)) + 0.5, top + height); c.lineTo(Math.round(x(s)) + 0.5, top + height + 4); c.fillText(s.toFixed(horizontal.digits), x(s), top + height + 5); }
    c.stroke();
    c.textAlign = 'left'; c.textBaseline = 'bottom'; c.fillStyle = themed('--text');
    c.fillText(name, left, top - 2);
    c.save();
    c.beginPath(); c.rect(left, top, width, height); c.clip();
    for (const {signal, color} of curves) this.drawCurve(c, signal, color, x, y, width);
    c.restore();
  }

  drawCurve(c, {t, y: values, rows, loose}, color, x, y, width) {
    c.strokeStyle = c.fillStyle = color; c.lineWidth = 1.4;
    if (loose) {  // several rows at one instant: no curve
      for (let i = 0; i < rows; ++i) if (Number.isFinite(values[i])) c.fillRect(x(t[i]) - 1.2, y(values[i]) - 1.2, 2.4, 2.4);
      return;
    }
    const step = Math.max(1, Math.floor(rows / (2 * width)));
    let pen = false;
    c.beginPath();
    for (let i = 0; i < rows; i += step) {
      if (!Number.isFinite(values[i])) { pen = false; continue; }
      if (pen) c.lineTo(x(t[i]), y(values[i])); else c.moveTo(x(t[i]), y(values[i]));
      pen = true;
    }
    c.stroke();
  }

  /** The instant under a pixel of the canvas. */
  timeAt(pixel) {
    for (let k = 0; k < this.signals.length; ++k) {
      const {left, width} = this.panel(k, this.canvas.clientWidth);
      if (pixel >= left - 6 && pixel <= left + width + 6) return Math.max(0, Math.min(1, (pixel - left) / width)) * this.run.end_s;
    }
    return null;
  }
}

/** Where in the run one is, and what happened when. */
function drawTimeline(canvas, run, t) {
  const {context: c, width, height} = fitted(canvas), x = (s) => 6 + (width - 12) * s / Math.max(run.end_s, 1e-3), middle = height / 2;
  c.fillStyle = themed('--line'); c.fillRect(6, middle - 2, width - 12, 4);
  c.fillStyle = themed('--accent'); c.fillRect(6, middle - 2, x(t) - 6, 4);
  for (const event of run.events) {
    const vehicle = run.vehicles[event.vehicle];
    c.fillStyle = event.kind === 'crash' ? '#d9302b' : vehicle ? rgb(vehicle.color) : themed('--soft');
    c.fillRect(x(event.t_s) - 1.5, middle - 10, 3, event.kind === 'crash' ? 20 : 8);
  }
  c.fillStyle = themed('--accent');
  c.beginPath(); c.arc(x(t), middle, 6, 0, 7); c.fill();
}
