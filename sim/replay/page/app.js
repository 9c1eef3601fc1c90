// SPDX-License-Identifier: BSD-3-Clause
// The page: reads the blocks, then draws what the controls, the keys and the address ask for.
'use strict';

const byId = (id) => document.getElementById(id);

/** An element with its attributes and children; texts are texts and never markup. */
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

const kSpeeds = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const kFirstSignals = ['z_m', 'speed_mps', 'clearance_m'];

class App {
  constructor() {
    this.run = new Run();
    this.t = 0;
    this.playing = false;
    this.speed = 1;
    this.dirty = true;
    this.frames = [];  // times of the last drawings [ms]
  }

  async start() {
    this.painter = new Painter(byId('view'));
    this.scene = new Scene(this.painter, this.run);
    this.plot = new Plot(byId('plot'), this.run);
    const blocks = [...document.querySelectorAll('script.block')];
    if (!blocks.length) return this.follow();
    const unpacked = (i) => {
      const text = blocks[i].textContent;
      blocks[i].remove();  // its memory is of use elsewhere
      return unpack(fromBase64(text));
    };
    // The browser unpacks the next block while this one is read.
    for (let i = 0, next = unpacked(0); i < blocks.length; ++i) {
      const block = readBlock(await next);
      if (i + 1 < blocks.length) next = unpacked(i + 1);
      this.take(block);
      byId('progress').textContent = `reading the run: ${Math.round(100 * (i + 1) / blocks.length)} %`;
    }
    this.fill();
  }

  /** A run that goes on: block after block from whoever serves the page. */
  async follow() {
    this.following = true;
    for (let k = 0; !this.run.complete;) {
      const answer = await fetch('blocks/' + k, {cache: 'no-store'}).catch(() => null);
      if (!answer || answer.status > 204) break;  // the run has ended, or was stopped
      if (answer.status === 204) {
        await new Promise((resolve) => setTimeout(resolve, 150));
        continue;
      }
      this.take(readBlock(await unpack(new Uint8Array(await answer.arrayBuffer()))));
      ++k;
      const parts = [this.run.overlays.size, this.scene.sensors().length, this.run.tables.tracks.rows > 0, this.run.events.length].join();
      if (this.begun && parts !== this.parts) { this.parts = parts; this.buildPanel(); this.buildSignals(); }
    }
    if (!this.begun) {
      byId('progress').textContent = 'the run ended before this page had anything of it; swiftlet run --replay keeps it';
      return;
    }
    byId('notice').textContent = this.run.complete ? '' : 'the run was stopped';
    this.fill();
  }

  /** One block more. What is needed to see anything comes first. */
  take(block) {
    this.run.add(block);
    this.dirty = true;
    if (block.about.kind !== 'chunk' && block.about.kind !== 'end' || this.begun) return;
    this.begun = true;
    this.scene.begin();
    this.scene.look();
    this.build();
    this.readAddress();
    byId('loading').hidden = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  // --- Controls --------------------------------------------------------------------------------------------------------

  build() {
    const {head} = this.run;
    document.title = 'Swiftlet replay: ' + head.scenario;
    byId('scenario').textContent = head.scenario;
    this.buildBar();
    this.buildPanel();
    this.buildSignals();
    this.listen();
  }

  /** What is known only at the end. */
  fill() {
    const {run} = this, count = run.scans.reduce((n, s) => n + s.count, 0), all = run.scans.reduce((n, s) => n + s.returns, 0);
    byId('about').textContent = `${run.vehicles.length} vehicle${run.vehicles.length === 1 ? '' : 's'}, ${run.end_s.toFixed(1)} s`;
    const shown = run.world.reduce((n, m) => n + m.indices.length / 3 * (m.places ? m.places.rows : 1), 0);
    const thinned = [];
    if (count) thinned.push(`scans: ${run.head.rates.scan_hz} a second of each LiDAR, ${count < all ? `${(100 * count / all).toFixed(count / all < 0.1 ? 1 : 0)} % of their points` : 'all points'}`);
    if (run.head.triangles && shown < run.head.triangles) thinned.push(`world: ${Math.round(shown / 1000)} of ${Math.round(run.head.triangles / 1000)} thousand triangles`);
    byId('notice').textContent = thinned.join(' · ');
    this.buildPanel();
    this.buildSignals();
    if (this.following === undefined) this.readAddress();
    this.ready = true;
    this.dirty = true;
  }

  buildBar() {
    this.track = make('canvas', {id: 'track', title: 'time line'});
    const step = (sign, title, text, id) => make('button', {id, title, textContent: text, onclick: () => this.step(sign)});
    this.playButton = make('button', {id: 'play', title: 'play or pause (space)', onclick: () => this.play(!this.playing)}, 'Play');
    this.speedChoice = make('select', {id: 'speed', title: 'speed (+ and -)', onchange: () => { this.speed = Number(this.speedChoice.value); }},
      ...kSpeeds.map((s) => make('option', {value: s, textContent: s + ' ×', selected: s === this.speed})));
    this.cameraChoice = make('select', {id: 'camera', title: 'camera (1 orbit, 2 follow, 3 on board, 4 top; tab: next vehicle)', onchange: () => this.setCamera(this.cameraChoice.value)});
    this.clock = make('span', {id: 'time'});
    byId('bar').replaceChildren(step(-1, 'previous scan (left)', '◂', 'back'), this.playButton, step(1, 'next scan (right)', '▸', 'next'), this.speedChoice, this.clock, this.track,
      this.cameraChoice, make('button', {id: 'plotted', title: 'signals (g)', textContent: 'Signals', onclick: () => this.toggle('plots')}),
      make('button', {id: 'picture', title: 'picture as PNG (p)', textContent: 'Picture', onclick: () => this.save()}),
      make('button', {id: 'layered', title: 'layers (l)', textContent: 'Layers', onclick: () => { document.body.classList.toggle('wide'); this.dirty = true; }}));
    this.cameraChoice.append(make('option', {value: 'orbit', textContent: 'Orbit'}), make('option', {value: 'top', textContent: 'Top'}));
    for (const [kind, text] of [['follow', 'Follow '], ['onboard', 'On board ']]) {
      for (const vehicle of this.run.vehicles) this.cameraChoice.append(make('option', {value: kind + ':' + vehicle.name, textContent: text + vehicle.name}));
    }
  }

  check(text, on, change, note = '', color = null, id = '') {
    const box = make('input', {type: 'checkbox', checked: on, id, onchange: () => { change(box.checked); this.dirty = true; }});
    return make('label', {title: text}, box, ...(color ? [make('i', {}, '')] : []), make('span', {textContent: text}), make('em', {textContent: note}));
  }

  choice(text, id, options) {
    const {choices} = this.scene;
    const select = make('select', {id, onchange: () => { const v = select.value; choices[id] = id === 'color' || id === 'sky' || id === 'cut' ? v : Number(v); this.dirty = true; }},
      ...options.map(([value, label]) => make('option', {value, textContent: label, selected: String(choices[id]) === String(value)})));
    return make('label', {}, make('span', {textContent: text}), select);
  }

  buildPanel() {
    const {scene, run} = this, {tables} = run;
    for (const key of run.overlays.keys()) {
      const group = Scene.groupOf(key);
      if (!scene.groups.has(group)) scene.groups.set(group, !kOffAtFirst.test(group));
    }
    const has = {sweeps: run.scans.length, detections: tables.detections.rows, tracks: tables.tracks.rows, covariances: tables.tracks.rows, radio: tables.radio.rows, events: run.events.length, world: run.world.length};
    const layers = kLayers.filter(([key]) => !(key in has) || has[key]).map(([key, text]) => {
      return this.check(text, scene.layers[key], (on) => { scene.layers[key] = on; }, key === 'events' ? String(run.events.length) : '', null, 'layer-' + key);
    });
    const groups = [...scene.groups].sort().map(([group, on]) => this.check(group, on, (now) => { scene.groups.set(group, now); }, '', null, 'overlay-' + group));
    const sensors = scene.sensors();
    scene.hidden_sensors ??= new Set();
    const lidars = sensors.map((key) => {
      const vehicle = run.vehicles[parseInt(key, 10)], label = this.check(vehicle.name + '/' + key.slice(key.indexOf('/') + 1), !scene.hidden_sensors.has(key), (on) => { if (on) scene.hidden_sensors.delete(key); else scene.hidden_sensors.add(key); }, '', vehicle.color);
      label.querySelector('i').style.background = rgb(vehicle.color);
      return label;
    });
    byId('panel').replaceChildren(
      make('h2', {textContent: 'Layers'}), ...layers,
      ...(groups.length ? [make('h2', {textContent: 'What vehicles draw'}), ...groups] : []),
      ...(lidars.length ? [make('h2', {textContent: 'LiDARs'}), ...lidars,
        this.choice('color by', 'color', [['height', 'height'], ['range', 'range'], ['intensity', 'intensity'], ['label', 'label'], ['vehicle', 'vehicle'], ['sensor', 'sensor']]),
        this.choice('keep', 'keep_s', [[0, 'latest scan'], [1, '1 s'], [3, '3 s'], [10, '10 s'], [1e6, 'all so far']]),
        this.choice('point size', 'point', [[1, 'small'], [2, 'medium'], [3, 'large'], [5, 'huge']])] : []),
      make('h2', {textContent: 'View'}),
      this.choice('trails', 'trail_s', [[5, '5 s'], [15, '15 s'], [60, '60 s'], [1e6, 'whole']]),
      this.choice('vehicles', 'scale', [[1, 'true size'], [2, '2 × larger'], [4, '4 × larger'], [8, '8 × larger']]),
      this.choice('hide above', 'cut', [['none', 'nothing'], ...kCuts.map((cut) => [cut, cut + ' m'])]),
      this.choice('background', 'sky', [['day', 'day'], ['dark', 'dark']]),
      make('small', {}, make('kbd', {}, 'space'), ' play  ', make('kbd', {}, '←'), ' ', make('kbd', {}, '→'), ' scan by scan  ', make('kbd', {}, '1'), '–', make('kbd', {}, '4'), ' camera  ', make('kbd', {}, 'tab'), ' next vehicle. Drag turns, right or shift drag moves, wheel zooms, a click tells what lies there.'),
      make('small', {id: 'license'}, 'Swiftlet replay. The page is free software under the BSD 3-Clause License; it contains no code of others and asks for nothing from the network.'));
  }

  buildSignals() {
    const names = this.run.signals();
    if (!this.plot.signals.length) this.plot.signals = kFirstSignals.filter((n) => names.includes(n));
    const picks = this.plot.signals.map((name, k) => make('select', {id: 'signal' + k, onchange: (e) => { this.plot.signals[k] = e.target.value; this.dirty = true; }},
      ...names.map((n) => make('option', {value: n, textContent: n, selected: n === name}))));
    const keys = this.run.vehicles.slice(0, 12).map((vehicle) => {
      const key = make('span', {textContent: vehicle.name});
      key.style.color = rgb(vehicle.color);
      return key;
    });
    byId('signals').replaceChildren('Signals', ...picks, ...keys);
  }

  toggle(id) { byId(id).hidden = !byId(id).hidden; this.dirty = true; }

  // --- Time and camera -------------------------------------------------------------------------------------------------

  play(on) {
    if (this.following !== undefined && !this.run.complete) this.following = on && this.t > this.run.end_s - 1;
    if (on && this.t >= this.run.end_s - 1e-6 && (this.run.complete || this.following === undefined)) this.t = 0;
    this.playing = on;
    this.playButton.textContent = on ? 'Pause' : 'Play';
    if (!on) this.writeAddress();
    this.dirty = true;
  }

  seek(t) {
    if (this.following) this.following = false;  // until play is asked for at the end
    this.t = Math.max(0, Math.min(this.run.end_s, t));
    if (!this.playing) this.writeAddress();
    this.dirty = true;
  }

  /** To the next scan, or half a second where there is none. */
  step(sign) {
    this.play(false);
    const ends = this.run.scans.filter((s) => !this.scene.hidden_sensors.has(s.vehicle + '/' + s.sensor)).map((s) => s.end_s);
    const next = sign > 0 ? ends.find((s) => s > this.t + 1e-3) : ends.filter((s) => s < this.t - 1e-3).pop();
    this.seek(next ?? this.t + 0.5 * sign);
  }

  /** "orbit", "top", "follow:uav1", "onboard:uav2"; false when there is no such thing. */
  setCamera(text) {
    const colon = text.indexOf(':'), kind = colon < 0 ? text : text.slice(0, colon), name = colon < 0 ? '' : text.slice(colon + 1);
    const {camera} = this.scene, vehicle = name ? this.run.vehicles.findIndex((v) => v.name === name) : camera.vehicle;
    if (!['orbit', 'top', 'follow', 'onboard'].includes(kind) || vehicle < 0) return false;
    const follows = (k) => k === 'follow' || k === 'onboard';
    if (follows(camera.kind) && !follows(kind)) camera.target = this.run.vehicleAt(camera.vehicle, this.t).p;
    if (kind === 'follow' && camera.kind !== 'follow') { camera.before = camera.distance; camera.distance = 5 * Math.sqrt(this.scene.choices.scale); camera.pitch = 0.35; camera.offset = [0, 0, 0]; }
    if (kind !== 'follow' && camera.kind === 'follow' && camera.before) camera.distance = camera.before;
    camera.kind = kind;
    camera.vehicle = vehicle;
    this.cameraChoice.value = this.cameraText();
    if (!this.playing) this.writeAddress();
    this.dirty = true;
    return true;
  }

  cameraText() {
    const {kind, vehicle} = this.scene.camera;
    return kind === 'orbit' || kind === 'top' ? kind : kind + ':' + this.run.vehicles[vehicle].name;
  }

  readAddress() {
    if (!location.hash) return;
    const asked = new URLSearchParams(location.hash.slice(1));
    if (asked.has('cam')) this.setCamera(asked.get('cam'));
    const t = parseFloat(asked.get('t'));
    if (Number.isFinite(t)) this.seek(t);
  }

  writeAddress() {
    if (!this.ready) return;
    const hash = `#t=${Number(this.t.toFixed(3))}&cam=${encodeURIComponent(this.cameraText()).replace('%3A', ':')}`;
    if (hash !== location.hash) history.replaceState(null, '', hash);
  }

  // --- Pointer and keys ------------------------------------------------------------------------------------------------

  listen() {
    const canvas = byId('view'), {camera} = this.scene;
    let drag = null, moved = 0;
    canvas.addEventListener('pointerdown', (e) => { drag = {x: e.clientX, y: e.clientY, move: e.button === 2 || e.shiftKey}; moved = 0; canvas.setPointerCapture(e.pointerId); canvas.focus(); });
    canvas.addEventListener('pointermove', (e) => {
      if (!drag) return;
      const dx = e.clientX - drag.x, dy = e.clientY - drag.y;
      drag.x = e.clientX; drag.y = e.clientY;
      moved += Math.abs(dx) + Math.abs(dy);
      if (drag.move || camera.kind === 'top') this.pan(dx, dy);
      else { camera.yaw -= 0.006 * dx; camera.pitch = Math.max(-1.5, Math.min(1.56, camera.pitch + 0.006 * dy)); }
      this.dirty = true;
    });
    canvas.addEventListener('pointerup', (e) => {
      if (drag && moved < 4) { const box = canvas.getBoundingClientRect(); this.tell(e.clientX - box.left, e.clientY - box.top); }
      drag = null;
    });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    canvas.addEventListener('wheel', (e) => { e.preventDefault(); camera.distance = Math.max(0.5, Math.min(2000, camera.distance * Math.exp(0.0011 * e.deltaY))); this.dirty = true; }, {passive: false});
    const scrub = (element, timeAt) => {
      let held = false;
      const go = (e) => { const t = timeAt(e.clientX - element.getBoundingClientRect().left); if (t !== null) this.seek(t); };
      element.addEventListener('pointerdown', (e) => { held = true; element.setPointerCapture(e.pointerId); go(e); });
      element.addEventListener('pointermove', (e) => { if (held) go(e); });
      element.addEventListener('pointerup', () => { held = false; });
    };
    scrub(this.track, (x) => (x - 6) / Math.max(1, this.track.clientWidth - 12) * this.run.end_s);
    scrub(byId('plot'), (x) => this.plot.timeAt(x));
    window.addEventListener('resize', () => { this.dirty = true; });
    window.addEventListener('hashchange', () => this.readAddress());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.dirty = true; });
    window.addEventListener('keydown', (e) => this.key(e));
  }

  pan(dx, dy) {
    const {camera} = this.scene, view = this.scene.last_view, canvas = byId('view');
    const scale = camera.distance / view.pixels_at_1m * canvas.height / canvas.clientHeight;
    const shift = [0, 1, 2].map((i) => (-dx * view.right[i] + dy * view.up[i]) * scale);
    if (camera.kind === 'follow') camera.offset = along(camera.offset, 1, shift);
    else camera.target = along(camera.target, 1, shift);
  }

  key(e) {
    if (/^(SELECT|INPUT)$/.test(e.target.tagName) && e.target.type !== 'checkbox' || e.ctrlKey || e.metaKey || e.altKey) return;
    const speed = (by) => { this.speed = kSpeeds[Math.max(0, Math.min(kSpeeds.length - 1, kSpeeds.indexOf(this.speed) + by))]; this.speedChoice.value = String(this.speed); };
    const name = () => this.run.vehicles[this.scene.camera.vehicle].name;
    const actions = {
      ' ': () => this.play(!this.playing), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), '+': () => speed(1), '-': () => speed(-1),
      1: () => this.setCamera('orbit'), 2: () => this.setCamera('follow:' + name()), 3: () => this.setCamera('onboard:' + name()), 4: () => this.setCamera('top'),
      Home: () => this.seek(0), End: () => this.seek(this.run.end_s), p: () => this.save(), g: () => this.toggle('plots'), Escape: () => { byId('card').hidden = true; },
      l: () => { document.body.classList.toggle('wide'); this.dirty = true; },
      Tab: () => { const {camera} = this.scene, next = this.run.vehicles[(camera.vehicle + 1) % this.run.vehicles.length]; this.setCamera((camera.kind === 'onboard' ? 'onboard:' : 'follow:') + next.name); },
    };
    if (!(e.key in actions) || e.key === 'Tab' && e.target !== byId('view')) return;
    e.preventDefault();
    actions[e.key]();
  }

  /** The facts about what lies under a pixel. */
  tell(x, y) {
    this.picked = this.scene.pick(x, y, this.t);
    this.showCard();
  }

  showCard() {
    const card = byId('card'), {picked} = this;
    card.hidden = !picked;
    if (!picked) return;
    const {title, rows} = picked.scan ? this.pointFacts(picked) : this.vehicleFacts(picked.vehicle);
    card.replaceChildren(make('b', {textContent: title}), make('button', {title: 'close', textContent: '×', onclick: () => { this.picked = null; this.showCard(); }}),
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

  vehicleFacts(index) {
    const state = this.run.vehicleAt(index, this.t), f = (name, digits = 2) => { const v = state.mix(name); return Number.isFinite(v) ? v.toFixed(digits) : '–'; };
    const [, , , c, , , s] = [0, 0, 0, state.R[0], 0, 0, state.R[3]];
    return {title: this.run.vehicles[index].name + (state.crashed ? ' (crashed)' : ''), rows: [
      ['position', ['x_m', 'y_m', 'z_m'].map((n) => f(n)).join(', ') + ' m'], ['speed', f('speed_mps') + ' m/s'],
      ['velocity', ['vx_mps', 'vy_mps', 'vz_mps'].map((n) => f(n)).join(', ') + ' m/s'], ['heading', (Math.atan2(s, c) * 180 / Math.PI).toFixed(1) + '°'], ['tilt', f('tilt_deg', 1) + '°'],
      ['clearance', f('clearance_m') + ' m'], ['error of the estimate', f('estimate_error_m', 3) + ' m'], ['from the reference', f('reference_error_m') + ' m']]};
  }

  // --- Drawing ---------------------------------------------------------------------------------------------------------

  frame(now) {
    const passed_s = Math.min(0.25, (now - (this.last_frame ?? now)) / 1000);
    this.last_frame = now;
    if (this.following && this.begun && this.t < this.run.end_s) {
      this.t += (this.run.end_s - this.t) * Math.min(1, 3 * passed_s);
      this.dirty = true;
    } else if (this.playing) {
      this.t = Math.min(this.run.end_s, this.t + passed_s * this.speed);
      this.dirty = true;
      if (this.t >= this.run.end_s && this.ready) this.play(false);
    }
    // While the run is read, pictures only hold the reading up: two a second show that it goes on.
    const reads = !this.ready && !this.following && now - (this.drawn_at ?? -Infinity) < 500;
    if (this.dirty && !reads) {
      this.drawn_at = now;
      this.hurry(now);
      this.draw();
    } else if (this.scene.hurried && now - this.moved_at > 300) {
      this.scene.hurried = false;  // nothing moves any more: a whole picture
      this.draw();
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  /** Where pictures take too long, those of a motion are coarser and without leaves. */
  hurry(now) {
    const took_ms = now - (this.moved_at ?? 0);
    this.moved_at = now;
    if (took_ms > 1500) this.slow = 0;  // the first of a motion
    else if (took_ms > 90) this.slow = Math.min(3, (this.slow ?? 0) + 1);
    this.scene.hurried = this.slow >= 3;
  }

  draw() {
    this.dirty = false;
    const canvas = byId('view'), ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.scene.hurried ? 0.5 : 1);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const view = this.scene.draw(this.t);
    this.showLabels(view);
    this.showLegend();
    this.clock.textContent = `${this.t.toFixed(2)} / ${this.run.end_s.toFixed(1)} s`;
    drawTimeline(this.track, this.run, this.t);
    if (!byId('plots').hidden) this.plot.draw(this.t);
    if (this.picked && !this.picked.scan) this.showCard();
  }

  showLabels(view) {
    const box = byId('labels');
    while (box.children.length > this.scene.labels.length) box.lastChild.remove();
    this.placed_labels = [];
    this.scene.labels.forEach((label, i) => {
      const span = box.children[i] || box.appendChild(make('span'));
      const at = this.scene.project(label.p, view);
      span.hidden = !at;
      if (!at) return;
      if (span.textContent !== label.text) span.textContent = label.text;
      span.style.color = rgb(label.color.map((c) => Math.round(90 + 0.65 * c)));
      span.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px) translate(-50%, -100%)`;
      this.placed_labels.push({...label, x: at[0], y: at[1]});
    });
  }

  showLegend() {
    const key = JSON.stringify(this.scene.legend);
    if (key === this.legend_key) return;
    this.legend_key = key;
    byId('legend').replaceChildren(...this.scene.legend.flatMap((entry) => {
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

  /** The view with its names and its instant, as a canvas. */
  picture() {
    this.draw();
    const view = byId('view'), out = make('canvas', {width: view.width, height: view.height}), c = out.getContext('2d');
    const ratio = view.width / view.clientWidth;
    c.drawImage(view, 0, 0);
    c.scale(ratio, ratio);
    c.font = '600 12px system-ui, "DejaVu Sans", sans-serif';
    c.textAlign = 'center';
    c.lineWidth = 3;
    c.strokeStyle = '#000a';
    for (const {text, color, x, y} of this.placed_labels) {
      c.fillStyle = rgb(color.map((v) => Math.round(90 + 0.65 * v)));
      c.strokeText(text, x, y - 4);
      c.fillText(text, x, y - 4);
    }
    c.textAlign = 'left';
    c.fillStyle = '#fff';
    const caption = `${this.run.head.scenario}   t = ${this.t.toFixed(2)} s`;
    c.strokeText(caption, 12, view.clientHeight - 12);
    c.fillText(caption, 12, view.clientHeight - 12);
    return out;
  }

  save() {
    this.picture().toBlob((blob) => {
      const link = make('a', {href: URL.createObjectURL(blob), download: `${this.run.head.scenario.replace(/[^\w.-]+/g, '_')}_${this.t.toFixed(2)}s.png`});
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    }, 'image/png');
  }

  /** Milliseconds of a drawing that is waited for, for those who measure. */
  measure(frames = 10) {
    const {gl} = this.painter, pixel = new Uint8Array(4), start = performance.now();
    for (let k = 0; k < frames; ++k) { this.scene.draw(this.t); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); }
    return {ms: (performance.now() - start) / frames, points: this.scene.drawn_points};
  }
}

window.swiftlet = new App();
window.swiftlet.start().catch((error) => {
  byId('loading').hidden = false;
  byId('progress').textContent = 'cannot show this run: ' + error.message;
  console.error(error);
});
