// SPDX-License-Identifier: BSD-3-Clause
// Controls: the bar, the panel with layers, events and help, the selection of signals.
'use strict';

/** Windows in which the panel lies over the picture and is closed at first; those in which plots are too. As in replay.css. */
const kNarrow = matchMedia('(max-width: 900px)'), kSmall = matchMedia('(max-width: 560px), (max-height: 480px)');
const kTabs = [['layers', 'Layers'], ['events', 'Events'], ['help', 'Help']];
const kSpeeds = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const kFirstSignals = ['z_m', 'speed_mps', 'clearance_m'];
const kHelp = [
  ['Keys', [
    ['space', 'play or pause'], ['← →', 'previous or next scan'], ['+ −', 'speed'], ['home end', 'start or end of the run'], ['1 2 3 4', 'camera: orbit, follow, on board, top'],
    ['tab', 'next vehicle; with shift the previous one'], ['esc', 'closes the facts; then tab walks through the controls'],
    ['l e h', 'layers, events, help'], ['g', 'signals'], ['p', 'picture as PNG']]],
  ['Picture', [
    ['drag', 'turns'], ['shift or right drag', 'moves'], ['wheel', 'zooms'], ['click', 'facts about a vehicle or a point'],
    ['one finger', 'turns'], ['two fingers', 'move; a pinch zooms'], ['tap', 'facts']]],
  ['Signals', [
    ['pointer', 'values at an instant'], ['click, tap', 'goes there'], ['wheel, pinch', 'zooms the time'], ['drag', 'zooms to an interval'],
    ['double click', 'whole run']]],
];

class Panel {
  constructor(app) { Object.assign(this, {app, run: app.run, scene: app.scene, plot: app.plot, kind: ''}); }

  build() {
    byId('panel').firstElementChild.replaceChildren(...kTabs.map(([tab, text]) => make('button', {id: 'tab-' + tab, textContent: text, onclick: () => this.open(tab)})),
      make('button', {title: 'close', textContent: '×', onclick: () => this.open('')}));
    this.buildBar();
    this.buildHelp();
    this.update();
    byId('plots').hidden = kSmall.matches;
    byId('legend').open = !kSmall.matches;
    this.open(kNarrow.matches ? '' : 'layers');
  }

  /** Builds everything that depends on the content of the run. */
  update() {
    this.buildLayers();
    this.buildEvents();
    this.buildSignals();
  }

  // --- Bar -------------------------------------------------------------------------------------------------------------

  buildBar() {
    const {app} = this, button = (id, title, textContent, onclick) => make('button', {id, title, textContent, onclick});
    this.play = button('play', 'play or pause (space)', 'Play', () => app.play(!app.playing));
    this.speed = make('select', {id: 'speed', title: 'speed (+ and −)', onchange: () => { app.speed = Number(this.speed.value); }},
      ...kSpeeds.map((s) => make('option', {value: s, textContent: s + ' ×', selected: s === app.speed})));
    this.camera = make('select', {id: 'camera', title: 'camera (1 orbit, 2 follow, 3 on board, 4 top; tab: next vehicle)', onchange: () => app.setCamera(this.camera.value)},
      make('option', {value: 'orbit', textContent: 'Orbit'}), make('option', {value: 'top', textContent: 'Top'}),
      ...[['follow', 'Follow '], ['onboard', 'On board ']].flatMap(([kind, text]) => this.run.vehicles.map(({name}) => make('option', {value: kind + ':' + name, textContent: text + name}))));
    this.clock = make('span', {id: 'time'});
    this.track = make('canvas', {id: 'track', title: 'time line'});
    byId('bar').replaceChildren(
      button('back', 'previous scan (left)', '◂', () => app.step(-1)), this.play, button('next', 'next scan (right)', '▸', () => app.step(1)), this.speed, this.clock, this.track,
      this.camera, button('plotted', 'signals (g)', 'Signals', () => this.togglePlots()), button('layered', 'layers (l)', 'Layers', () => this.toggle('layers')),
      button('listed', 'events (e)', 'Events', () => this.toggle('events')), button('picture', 'picture as PNG (p)', 'Picture', () => app.save()));
  }

  setSpeed(by) {
    const at = kSpeeds.indexOf(this.app.speed) + by;
    this.app.speed = kSpeeds[Math.max(0, Math.min(kSpeeds.length - 1, at))];
    this.speed.value = String(this.app.speed);
  }

  // --- Panel and plots: only one of them on small screens -------------------------------------------------------------

  /** Opens a tab; no name closes the panel. */
  open(tab) {
    document.body.dataset.panel = this.tab = tab;
    for (const [name] of kTabs) {
      byId(name).hidden = name !== tab;
      byId('tab-' + name).setAttribute('aria-pressed', name === tab);
    }
    if (tab && kSmall.matches) byId('plots').hidden = true;
    this.app.dirty = true;
  }

  toggle(tab) { this.open(this.tab === tab ? '' : tab); }

  togglePlots() {
    byId('plots').hidden = !byId('plots').hidden;
    if (!byId('plots').hidden && kSmall.matches) this.open('');
    this.app.dirty = true;
  }

  // --- Layers ----------------------------------------------------------------------------------------------------------

  check(text, title, on, change, id = '', color = null) {
    const box = make('input', {type: 'checkbox', checked: on, id, onchange: () => { change(box.checked); this.app.dirty = true; }}), mark = make('i');
    if (color) mark.style.background = rgb(color);
    return make('label', {title}, box, ...(color ? [mark] : []), make('span', {textContent: text}));
  }

  choice(text, id, options) {
    const {choices} = this.scene, isText = typeof choices[id] === 'string';
    const select = make('select', {id, onchange: () => { choices[id] = isText ? select.value : Number(select.value); this.app.dirty = true; }},
      ...options.map(([value, label]) => make('option', {value, textContent: label ?? value, selected: String(choices[id]) === String(value)})));
    return make('label', {}, make('span', {textContent: text}), select);
  }

  layers() {
    const {scene, run} = this, {tables} = run;
    const has = {sweeps: run.scans.length, detections: tables.detections.rows, tracks: tables.tracks.rows, covariances: tables.tracks.rows, radio: tables.radio.rows,
                 events: run.events.some((e) => e.kind === 'crash'), world: run.world.length};
    return kLayers.filter(([key]) => !(key in has) || has[key])
      .map(([key, text, hint]) => this.check(text, hint, scene.layers[key], (on) => { scene.layers[key] = on; }, 'layer-' + key));
  }

  overlays() {
    const {scene, run} = this, meanings = new Map();
    for (const [key, list] of run.overlays) {
      const group = scene.addGroup(key);
      if (!meanings.has(group)) meanings.set(group, new Set());
      for (const {about} of list) for (const {meaning} of about.legend || []) meanings.get(group).add(meaning);
    }
    return [...scene.groups].sort().map(([group, on]) => {
      const {text, hint} = describeOverlay(group, meanings.get(group) || []);
      return this.check(text, hint, on, (now) => { scene.groups.set(group, now); }, 'overlay-' + group);
    });
  }

  lidars() {
    const {points} = this.scene;
    return points.sensors().map((key) => this.check(points.nameOf(key), 'Scans of this LiDAR', !points.hidden.has(key),
      (on) => { if (on) points.hidden.delete(key); else points.hidden.add(key); }, 'lidar-' + key, this.run.vehicles[parseInt(key, 10)].color));
  }

  buildLayers() {
    const overlays = this.overlays(), lidars = this.lidars(), title = (textContent) => make('h2', {textContent});
    byId('layers').replaceChildren(
      title('Layers'), ...this.layers(), ...(overlays.length ? [title('Drawn by the vehicles'), ...overlays] : []),
      ...(lidars.length ? [title('LiDARs'), ...lidars,
        this.choice('color by', 'color', [['height'], ['range'], ['intensity'], ['label'], ['vehicle'], ['sensor']]),
        this.choice('keep', 'keep_s', [[0, 'latest scan'], [1, '1 s'], [3, '3 s'], [10, '10 s'], [1e6, 'all so far']]),
        this.choice('point size', 'point', [[1, 'small'], [2, 'medium'], [3, 'large'], [5, 'huge']])] : []),
      title('View'),
      this.choice('trails', 'trail_s', [[5, '5 s'], [15, '15 s'], [60, '60 s'], [1e6, 'whole']]),
      this.choice('vehicles', 'scale', [[1, 'true size'], [2, '2 × larger'], [4, '4 × larger'], [8, '8 × larger']]),
      this.choice('hide above', 'cut', [['none', 'nothing'], ...kCuts.map((cut) => [cut, cut + ' m'])]),
      this.choice('background', 'sky', [['day'], ['dark']]));
  }

  // --- Events ----------------------------------------------------------------------------------------------------------

  /** The list of events; a click goes to the instant of one. */
  buildEvents() {
    const {events, vehicles} = this.run, kinds = [...new Set(events.map((e) => e.kind))].sort();
    if (!kinds.includes(this.kind)) this.kind = '';
    const filter = make('select', {id: 'kind', title: 'kind of events', onchange: () => { this.kind = filter.value; this.buildEvents(); }},
      make('option', {value: '', textContent: 'all kinds'}), ...kinds.map((kind) => make('option', {value: kind, textContent: kind.replace(/_/g, ' '), selected: kind === this.kind})));
    this.listed = events.filter((e) => !this.kind || e.kind === this.kind);
    this.current = -1;
    this.items = this.listed.map((event) => {
      const vehicle = vehicles[event.vehicle], name = make('b', {textContent: vehicle ? vehicle.name + ' ' : ''});
      if (vehicle) name.style.color = rgb(vehicle.color);
      return make('button', {className: event.kind === 'crash' ? 'crash' : '', onclick: () => this.app.seek(event.t_s)},
        make('time', {textContent: event.t_s.toFixed(2) + ' s'}), make('span', {}, name, describeEvent(event)));
    });
    byId('events').replaceChildren(make('h2', {textContent: `Events (${events.length})`}), ...(kinds.length > 1 ? [filter] : []),
      ...(events.length ? this.items : [make('p', {textContent: 'The run has no events.'})]));
  }

  /** Marks the last event before t. */
  markEvent(t) {
    const now = this.listed.findLastIndex((event) => event.t_s <= t + 1e-6);
    if (now === this.current) return;
    for (const [index, on] of [[this.current, false], [now, true]]) if (index >= 0) this.items[index].classList.toggle('now', on);
    this.current = now;
    if (now >= 0 && this.tab === 'events') this.items[now].scrollIntoView({block: 'nearest'});
  }

  // --- Signals and help ------------------------------------------------------------------------------------------------

  buildSignals() {
    const names = this.run.signals(), {plot} = this;
    if (!plot.signals.length) plot.signals = kFirstSignals.filter((n) => names.includes(n));
    const picks = plot.signals.map((name, k) => make('select', {id: 'signal' + k, title: 'signal', onchange: (e) => { plot.signals[k] = e.target.value; this.app.dirty = true; }},
      ...names.map((n) => make('option', {value: n, textContent: n, selected: n === name}))));
    const keys = this.run.vehicles.slice(0, 12).map((vehicle) => {
      const key = make('span', {textContent: vehicle.name});
      key.style.color = rgb(vehicle.color);
      return key;
    });
    this.whole = make('button', {id: 'whole', textContent: 'Whole run', title: 'show the whole run (double click)', hidden: !plot.shown, onclick: () => { plot.shown = null; this.app.dirty = true; }});
    byId('signals').replaceChildren(make('b', {textContent: 'Signals'}), ...picks, ...keys, this.whole);
  }

  buildHelp() {
    const keys = (what) => what.split(' ').map((key) => make('kbd', {textContent: key}));
    byId('help').replaceChildren(...kHelp.map(([title, rows]) => make('div', {className: title.toLowerCase()}, make('h2', {textContent: title}),
      make('table', {}, ...rows.map(([what, effect]) => make('tr', {}, make('td', {}, ...(title === 'Keys' ? keys(what) : [what])), make('td', {textContent: effect})))))),
      make('small', {id: 'license'}, 'Swiftlet replay. The page is free software under the BSD 3-Clause License; it contains no code of others and asks for nothing from the network.'));
  }
}
