// SPDX-License-Identifier: BSD-3-Clause
// Plots of signals over time with values at the pointer, and the time line, drawn on a 2D canvas.
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

/** Margins of a panel [px]: values on the left, the name above, times below. */
const kPlotLeft = 54, kPlotRight = 12, kPlotTop = 16, kPlotBottom = 20;
/** Panels narrower than this are put below each other, and are lower then [px]. */
const kNarrowPanel = 200, kPanelHeight = 150, kLowPanelHeight = 94;
/** Shortest interval that zooming shows [s]. */
const kShortestSpan_s = 0.1;
/** A value is read from the nearest sample within this share of the shown interval, and at least this time [s]. */
const kReach = 0.02, kReach_s = 0.1;

/** Curves of the chosen signals over a common interval of time, with the cursor, and the value under a pointer. */
class Plot {
  constructor(canvas, run) { Object.assign(this, {canvas, run, signals: [], shown: null, pointer: null, selection: null}); }

  /** Beginning and end of the shown interval [s]. */
  get span() { return this.shown || [0, Math.max(this.run.end_s, 1e-3)]; }

  /** Shows an interval, within the run; the whole run is no zoom. */
  show(from, to) {
    const end = Math.max(this.run.end_s, 1e-3), length = Math.max(kShortestSpan_s, to - from);
    if (length >= end) { this.shown = null; return; }
    const first = Math.max(0, Math.min(end - length, from));
    this.shown = [first, first + length];
  }

  /** Makes the interval `factor` times as long around an instant, and moves it by some seconds. */
  zoom(factor, about_s, shift_s = 0) {
    const [from, to] = this.span;
    this.show(about_s + (from - about_s) * factor + shift_s, about_s + (to - about_s) * factor + shift_s);
  }

  /** During playback, moves the interval with the time. */
  follow(t) {
    const [from, to] = this.span;
    if (this.shown && (t < from || t > to)) this.show(t - 0.05 * (to - from), t + 0.95 * (to - from));
  }

  get columns() { return this.canvas.clientWidth / this.signals.length >= kNarrowPanel ? this.signals.length : 1; }
  get rows() { return Math.ceil(this.signals.length / this.columns); }

  /** The area of the curves of a signal, in pixels of CSS. */
  panel(k) {
    const {columns, rows, canvas} = this, width = canvas.clientWidth / columns, height = canvas.clientHeight / rows;
    return {left: k % columns * width + kPlotLeft, top: Math.floor(k / columns) * height + kPlotTop,
            width: width - kPlotLeft - kPlotRight, height: height - kPlotTop - kPlotBottom};
  }

  /** The signal whose panel is at a place, or -1. */
  panelAt(x, y) {
    return this.signals.findIndex((_, k) => {
      const {left, top, width, height} = this.panel(k);
      return x >= left - 8 && x <= left + width + 8 && y >= top - kPlotTop && y <= top + height + kPlotBottom;
    });
  }

  /** The instant at a place, or null outside of the panels. */
  timeAt(x, y) {
    const k = this.panelAt(x, y);
    if (k < 0) return null;
    const {left, width} = this.panel(k), [from, to] = this.span;
    return from + Math.max(0, Math.min(1, (x - left) / width)) * (to - from);
  }

  /** Values of a signal near t, of each vehicle that has one. */
  valuesAt(name, t) {
    const [from, to] = this.span, values = [];
    for (const vehicle of this.run.vehicles) {
      const signal = this.run.signal(name, vehicle.index);
      if (!signal || !signal.rows) continue;
      const before = Math.max(0, lastAt(signal.t, signal.rows, t)), after = Math.min(signal.rows - 1, before + 1);
      const row = t - signal.t[before] <= signal.t[after] - t ? before : after;
      if (Number.isFinite(signal.y[row]) && Math.abs(signal.t[row] - t) < Math.max(kReach_s, kReach * (to - from))) values.push({vehicle, value: signal.y[row]});
    }
    return values;
  }

  /** Curves are drawn when they have changed; else a copy of them is drawn under the cursor. */
  draw(t) {
    const {canvas} = this;
    canvas.style.height = (this.rows > 1 ? this.rows * kLowPanelHeight : kPanelHeight) + 'px';
    const {context: c, width, height} = fitted(canvas);
    const key = [this.run.blocks, canvas.width, canvas.height, themed('--text'), this.signals, this.span].join(' ');
    if (key !== this.drawn) {
      this.drawn = key;
      this.signals.forEach((name, k) => this.drawPanel(c, name, this.panel(k)));
      this.curves ??= document.createElement('canvas');
      this.curves.width = canvas.width; this.curves.height = canvas.height;
      this.curves.getContext('2d').drawImage(canvas, 0, 0);
    } else {
      c.drawImage(this.curves, 0, 0, width, height);
    }
    this.signals.forEach((_, k) => this.drawCursors(c, this.panel(k), t));
  }

  /** The instant of the picture, the one under the pointer, and the interval that a drag selects. */
  drawCursors(c, {left, top, width, height}, t) {
    const [from, to] = this.span, x = (s) => left + width * (s - from) / (to - from);
    const line = (s, color) => { if (s >= from && s <= to) { c.fillStyle = color; c.fillRect(x(s) - 0.5, top, 1, height); } };
    if (this.selection) {
      const [a, b] = this.selection.map(x).sort((p, q) => p - q);
      c.globalAlpha = 0.2; c.fillStyle = themed('--accent'); c.fillRect(a, top, b - a, height); c.globalAlpha = 1;
    }
    line(t, themed('--accent'));
    if (this.pointer !== null) line(this.pointer, themed('--soft'));
  }

  /** Curves of a signal that has rows in the shown interval, and the range of their values there. */
  curvesOf(name) {
    const [from, to] = this.span, curves = [];
    let low = Infinity, high = -Infinity;
    for (const vehicle of this.run.vehicles) {
      const signal = this.run.signal(name, vehicle.index);
      if (!signal) continue;
      const first = Math.max(0, lastAt(signal.t, signal.rows, from)), last = Math.min(signal.rows, lastAt(signal.t, signal.rows, to) + 2);
      for (let i = first; i < last; ++i) if (Number.isFinite(signal.y[i])) { low = Math.min(low, signal.y[i]); high = Math.max(high, signal.y[i]); }
      curves.push({signal, first, last, color: rgb(vehicle.color)});
    }
    if (!(low <= high)) { low = 0; high = 1; }
    const margin = 0.06 * (high - low) || 0.5;
    return {curves, low: low - margin, high: high + margin};
  }

  drawPanel(c, name, {left, top, width, height}) {
    const [from, to] = this.span, {curves, low, high} = this.curvesOf(name);
    const x = (s) => left + width * (s - from) / (to - from), y = (v) => top + height * (high - v) / (high - low);
    c.strokeStyle = themed('--line'); c.fillStyle = themed('--soft'); c.lineWidth = 1;
    const vertical = ticksOf(low, high, height < 70 ? 3 : 4), horizontal = ticksOf(from, to, Math.max(2, width / 90));
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
    for (const curve of curves) this.drawCurve(c, curve, x, y, width);
    c.restore();
  }

  drawCurve(c, {signal: {t, y: values, loose}, first, last, color}, x, y, width) {
    c.strokeStyle = c.fillStyle = color; c.lineWidth = 1.4;
    if (loose) {  // several rows at one time: no curve
      for (let i = first; i < last; ++i) if (Number.isFinite(values[i])) c.fillRect(x(t[i]) - 1.2, y(values[i]) - 1.2, 2.4, 2.4);
      return;
    }
    const step = Math.max(1, Math.floor((last - first) / (2 * width)));
    let pen = false;
    c.beginPath();
    for (let i = first; i < last; i += step) {
      if (!Number.isFinite(values[i])) { pen = false; continue; }
      if (pen) c.lineTo(x(t[i]), y(values[i])); else c.moveTo(x(t[i]), y(values[i]));
      pen = true;
    }
    c.stroke();
  }
}

/** Largest number of listed vehicles, those with values nearest to the pointer, and distance of the list from it [px]. */
const kTipRows = 8, kTipAway = 14;

/** Values of the signal under a place of the plots, beside it; null hides them. */
function showValues(plot, p) {
  const tip = byId('tip'), k = p ? plot.panelAt(p.x, p.y) : -1;
  plot.pointer = k < 0 ? null : plot.timeAt(p.x, p.y);
  tip.hidden = k < 0;
  if (k < 0) return;
  const {canvas} = plot, name = plot.signals[k], unit = unitOf(name);
  const {low, high} = plot.curvesOf(name), panel = plot.panel(k), under = high - (p.y - panel.top) / panel.height * (high - low);
  const values = plot.valuesAt(name, plot.pointer).sort((a, b) => Math.abs(a.value - under) - Math.abs(b.value - under)).slice(0, kTipRows);
  values.sort((a, b) => a.vehicle.index - b.vehicle.index);
  tip.replaceChildren(make('div', {}, make('span', {textContent: name}), make('b', {textContent: plot.pointer.toFixed(2) + ' s'})), ...values.map(({vehicle, value}) => {
    const label = make('span', {textContent: vehicle.name});
    label.style.color = rgb(vehicle.color);
    return make('div', {}, label, make('b', {textContent: `${Math.abs(value) < 1000 ? value.toPrecision(4) : value.toFixed(0)} ${unit}`}));
  }));
  const box = tip.parentElement, x = canvas.offsetLeft + p.x, y = canvas.offsetTop + p.y, room = p.x + kTipAway + tip.offsetWidth < canvas.clientWidth;
  const lowest = box.scrollTop + box.clientHeight - tip.offsetHeight;
  tip.style.left = Math.max(2, room ? x + kTipAway : x - kTipAway - tip.offsetWidth) + 'px';
  tip.style.top = Math.max(box.scrollTop, Math.min(lowest, y - tip.offsetHeight / 2)) + 'px';
}

/** The time line: the instant within the run, and a tick for each event. */
class Timeline {
  constructor(canvas, run) { Object.assign(this, {canvas, run}); }

  get width() { return Math.max(1, this.canvas.clientWidth - 12); }
  timeAt(x) { return (x - 6) / this.width * this.run.end_s; }
  x(t) { return 6 + this.width * t / Math.max(this.run.end_s, 1e-3); }

  /** The event whose tick is nearest to a place, within some pixels. */
  eventAt(x, within = 5) {
    let best = null;
    for (const event of this.run.events) {
      const away = Math.abs(this.x(event.t_s) - x);
      if (away <= within) { best = event; within = away; }
    }
    return best;
  }

  draw(t) {
    const {context: c, height} = fitted(this.canvas), {run} = this, middle = height / 2;
    c.fillStyle = themed('--line'); c.fillRect(6, middle - 2, this.width, 4);
    c.fillStyle = themed('--accent'); c.fillRect(6, middle - 2, this.x(t) - 6, 4);
    for (const event of run.events) {
      const vehicle = run.vehicles[event.vehicle], crash = event.kind === 'crash';
      c.fillStyle = crash ? '#d9302b' : vehicle ? rgb(vehicle.color) : themed('--soft');
      c.fillRect(this.x(event.t_s) - 1.5, middle - 10, 3, crash ? 20 : 8);
    }
    c.fillStyle = themed('--accent');
    c.beginPath(); c.arc(this.x(t), middle, 6, 0, 7); c.fill();
  }
}
