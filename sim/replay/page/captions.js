// SPDX-License-Identifier: BSD-3-Clause
// Overlays of the picture: names, legend, data of a vehicle or a point; and export of the picture as PNG.
'use strict';

const kLabelFont = '600 12px system-ui, "DejaVu Sans", sans-serif';
/** Names are lighter than the colors of vehicles, for readability over the world. */
const labelColor = (color) => rgb(color.map((c) => Math.round(90 + 0.65 * c)));

class Captions {
  constructor(scene, run) { Object.assign(this, {scene, run, picked: null, labels: []}); }

  show(view, t) {
    this.showLabels(view);
    this.showLegend();
    if (this.picked && !this.picked.scan) this.showCard(t);
  }

  showLabels(view) {
    const box = byId('labels');
    while (box.children.length > this.scene.labels.length) box.lastChild.remove();
    this.labels = [];
    this.scene.labels.forEach((label, i) => {
      const span = box.children[i] || box.appendChild(make('span'));
      const at = this.scene.project(label.p, view);
      span.hidden = !at;
      if (!at) return;
      if (span.textContent !== label.text) span.textContent = label.text;
      span.style.color = labelColor(label.color);
      span.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, -100%)`;
      this.labels.push({...label, x: at[0], y: at[1]});
    });
  }

  showLegend() {
    const key = JSON.stringify(this.scene.legend);
    if (key === this.legend) return;
    this.legend = key;
    byId('legend').hidden = !this.scene.legend.length;
    byId('legend').lastElementChild.replaceChildren(...this.scene.legend.flatMap((entry) => {
      if (!entry.scale) {
        const mark = make('i');
        mark.style.background = rgb(entry.color.map(Math.round));
        return [make('div', {}, mark, entry.text)];
      }
      const bar = make('div', {className: 'scale'});
      bar.style.background = `linear-gradient(to right, ${entry.scale.map(rgb).join(',')})`;
      return [make('div', {textContent: entry.text}), bar, make('div', {className: 'ends'}, make('span', {textContent: entry.low}), make('span', {textContent: entry.high}))];
    }));
  }

  /** Shows data of the picked vehicle or point; null closes the card. */
  pick(picked, t) {
    this.picked = picked;
    this.showCard(t);
  }

  showCard(t) {
    const card = byId('card'), {picked} = this;
    card.hidden = !picked;
    if (!picked) return;
    const {title, rows} = picked.scan ? this.pointFacts(picked) : this.vehicleFacts(picked.vehicle, t);
    card.replaceChildren(make('b', {textContent: title}), make('button', {title: 'close (esc)', textContent: '×', onclick: () => this.pick(null)}),
      make('table', {}, ...rows.map(([name, value]) => make('tr', {}, make('td', {textContent: name}), make('td', {textContent: value})))));
  }

  pointFacts({scan, point: i}) {
    const surface = scan.class[i], known = this.run.head.palette.classes.find((c) => c.number === surface), instance = scan.instance[i];
    const other = surface === 300 && this.run.vehicles[instance - 1];
    return {title: known ? known.name : 'class ' + surface, rows: [
      ['class', String(surface)], ['instance', other ? `${instance} (${other.name})` : String(instance)], ['range', scan.range_m[i].toFixed(2) + ' m'],
      ['beam', `row ${scan.row[i]}, column ${scan.col[i]}`], ['intensity', scan.intensity_dB[i].toFixed(0) + ' dB'],
      ['position', [0, 1, 2].map((c) => scan.p_world_m[3 * i + c].toFixed(2)).join(', ') + ' m'],
      ['seen by', this.run.vehicles[scan.vehicle].name + '/' + scan.sensor], ['sweep from', scan.start_s.toFixed(3) + ' s']]};
  }

  vehicleFacts(index, t) {
    const state = this.run.vehicleAt(index, t), f = (name, digits = 2) => { const v = state.mix(name); return Number.isFinite(v) ? v.toFixed(digits) : '–'; };
    return {title: this.run.vehicles[index].name + (state.crashed ? ' (crashed)' : ''), rows: [
      ['position', ['x_m', 'y_m', 'z_m'].map((n) => f(n)).join(', ') + ' m'], ['speed', f('speed_mps') + ' m/s'],
      ['velocity', ['vx_mps', 'vy_mps', 'vz_mps'].map((n) => f(n)).join(', ') + ' m/s'],
      ['heading', (Math.atan2(state.R[3], state.R[0]) * 180 / Math.PI).toFixed(1) + '°'], ['tilt', f('tilt_deg', 1) + '°'],
      ['clearance', f('clearance_m') + ' m'], ['estimate error', f('estimate_error_m', 3) + ' m'], ['distance to reference', f('reference_error_m') + ' m']]};
  }

  /** The view with names and time, as a canvas. */
  picture(t) {
    const view = byId('view'), out = make('canvas', {width: view.width, height: view.height}), c = out.getContext('2d');
    const ratio = view.width / view.clientWidth;
    const text = (words, x, y, color) => { c.fillStyle = color; c.strokeText(words, x, y); c.fillText(words, x, y); };
    c.drawImage(view, 0, 0);
    c.scale(ratio, ratio);
    Object.assign(c, {font: kLabelFont, lineWidth: 3, strokeStyle: '#000a', textAlign: 'center'});
    for (const label of this.labels) text(label.text, label.x, label.y - 4, labelColor(label.color));
    c.textAlign = 'left';
    text(`${this.run.head.scenario}   t = ${t.toFixed(2)} s`, 12, view.clientHeight - 12, '#fff');
    return out;
  }
}
