// SPDX-License-Identifier: BSD-3-Clause
// Pointers, fingers and keys.
'use strict';

/** A press that moves by less is a click or a tap [px]; larger for fingers than for a mouse. */
const kMouseSlack = 4, kFingerSlack = 12;
/** Two taps within this time are a double tap, as double clicks in browsers. */
const kDoubleTap_ms = 500;

/**
 * Gestures on an element, for mouse and fingers alike, in pixels of CSS from its corner:
 *   drag(dx, dy, p, e, from)  one pointer moves, pressed at `from`
 *   pinch(scale, dx, dy, p)   two fingers change their distance by a factor and move their middle p
 *   tap(p, e, is_double)      a press without motion
 *   end(p, e, from)           the last pointer has been lifted
 */
function onGestures(element, {drag, pinch, tap = () => {}, end = () => {}}) {
  const held = new Map();
  let from = null, travel = 0, several = false, last_tap = {t: -Infinity, x: 0, y: 0};
  const at = (e) => { const box = element.getBoundingClientRect(); return {x: e.clientX - box.left, y: e.clientY - box.top}; };
  const pair = () => {
    const [a, b] = [...held.values()];
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, length: Math.max(10, Math.hypot(a.x - b.x, a.y - b.y))};
  };
  element.addEventListener('pointerdown', (e) => {
    if (!held.size) { from = at(e); travel = 0; several = false; }
    held.set(e.pointerId, at(e));
    several ||= held.size > 1;
    element.setPointerCapture(e.pointerId);
  });
  element.addEventListener('pointermove', (e) => {
    const before = held.get(e.pointerId), p = at(e);
    if (!before) return;
    const was = held.size === 2 && pair();
    held.set(e.pointerId, p);
    travel += Math.hypot(p.x - before.x, p.y - before.y);
    if (!several) drag(p.x - before.x, p.y - before.y, p, e, from);
    if (!was) return;
    const now = pair();
    pinch(now.length / was.length, now.x - was.x, now.y - was.y, now);
  });
  const lift = (e) => {
    if (!held.delete(e.pointerId) || held.size) return;
    const p = at(e);
    end(p, e, from);
    if (e.type !== 'pointerup' || several || travel >= (e.pointerType === 'mouse' ? kMouseSlack : kFingerSlack)) return;
    const is_double = e.timeStamp - last_tap.t < kDoubleTap_ms && Math.hypot(p.x - last_tap.x, p.y - last_tap.y) < 2 * kFingerSlack;
    last_tap = {t: is_double ? -Infinity : e.timeStamp, ...p};
    tap(p, e, is_double);
  };
  element.addEventListener('pointerup', lift);
  element.addEventListener('pointercancel', lift);
}

/** The 3D view: one pointer rotates, or pans in views without rotation; two fingers pan and zoom. */
function listenToView(app) {
  const canvas = byId('view'), {scene} = app, {camera} = scene;
  const pan = (dx, dy) => camera.pan(dx, dy, scene.last_view, canvas);
  onGestures(canvas, {
    drag: (dx, dy, p, e) => {
      if (e.buttons & 2 || e.shiftKey || camera.kind === 'top') pan(dx, dy); else camera.turn(dx, dy);
      app.dirty = true;
    },
    pinch: (scale, dx, dy) => {
      camera.zoom(1 / scale);
      pan(dx, dy);
      app.dirty = true;
    },
    tap: (p, e) => app.captions.pick(scene.pick(p.x, p.y, app.t, e.pointerType === 'mouse' ? 5 : 14), app.t),
  });
  canvas.addEventListener('pointerdown', () => canvas.focus());
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  canvas.addEventListener('wheel', (e) => {
    e.preventDefault();
    camera.zoom(Math.exp(0.0011 * e.deltaY));
    app.dirty = true;
  }, {passive: false});
}

/** The time line: press and drag set the time; a tick under the pointer shows its event. */
function listenToTimeline(app) {
  const {track} = app.panel, {timeline} = app, go = (e) => app.seek(timeline.timeAt(e.clientX - track.getBoundingClientRect().left));
  track.addEventListener('pointerdown', go);
  onGestures(track, {drag: (dx, dy, p) => app.seek(timeline.timeAt(p.x)), pinch: () => {}});
  track.addEventListener('pointermove', (e) => {
    const event = timeline.eventAt(e.offsetX), vehicle = event && app.run.vehicles[event.vehicle];
    track.title = event ? `${event.t_s.toFixed(2)} s ${vehicle ? vehicle.name + ' ' : ''}${describeEvent(event)}` : 'time line';
  });
}

/** The plots: values under the pointer or finger, a click sets the time, wheel, pinch and drag zoom, a double click shows the whole run. */
function listenToPlot(app) {
  const {plot} = app, {canvas} = plot, redraw = () => app.drawPlot();
  const read = (e) => { if (e.isPrimary) { showValues(plot, {x: e.offsetX, y: e.offsetY}); redraw(); } };
  const leave = () => { showValues(plot, null); redraw(); };
  onGestures(canvas, {
    drag: (dx, dy, p, e, from) => {
      if (e.pointerType === 'mouse') plot.selection = [plot.timeAt(from.x, from.y), plot.timeAt(p.x, from.y)];
      if (plot.selection && plot.selection.includes(null)) plot.selection = null;
      redraw();
    },
    pinch: (scale, dx, dy, p) => {
      const t = plot.timeAt(p.x, p.y), [from, to] = plot.span;
      if (t !== null) plot.zoom(1 / scale, t, -dx / plot.panel(0).width * (to - from));
      showValues(plot, null);
      redraw();
    },
    tap: (p, e, is_double) => {
      const t = plot.timeAt(p.x, p.y);
      if (t === null) return;
      if (is_double) plot.shown = null; else app.seek(t);
      redraw();
    },
    end: (p, e, from) => {
      const chosen = plot.selection;
      plot.selection = null;
      if (chosen && Math.abs(p.x - from.x) > kFingerSlack) plot.show(Math.min(...chosen), Math.max(...chosen));
      redraw();
    },
  });
  canvas.addEventListener('pointermove', read);
  canvas.addEventListener('pointerdown', read);
  // Values at a touched position stay visible until the next touch elsewhere.
  canvas.addEventListener('pointerleave', (e) => { if (e.pointerType === 'mouse') leave(); });
  document.addEventListener('pointerdown', (e) => { if (e.target !== canvas && plot.pointer !== null) leave(); });
  canvas.addEventListener('wheel', (e) => {
    const t = plot.timeAt(e.offsetX, e.offsetY), [from, to] = plot.span;
    if (t === null) return;
    e.preventDefault();
    const sideways = e.shiftKey || Math.abs(e.deltaX) > Math.abs(e.deltaY);
    if (sideways) plot.zoom(1, t, (e.deltaX || e.deltaY) / plot.panel(0).width * (to - from));
    else plot.zoom(Math.exp(0.002 * e.deltaY), t);
    redraw();
  }, {passive: false});
}

/** Controls keep their standard keys; all others are shortcuts. */
function keepsKey(target, key) {
  if (target.tagName === 'SELECT') return key !== 'Escape';
  return /^(BUTTON|INPUT|SUMMARY)$/.test(target.tagName) && (key === ' ' || key === 'Enter');
}

/** Shortcuts by key. They work from the start, and tab takes the next vehicle until a control has the focus. */
function listenToKeys(app) {
  const {panel, scene} = app, view = byId('view'), name = () => app.run.vehicles[scene.camera.vehicle].name;
  const escape = () => {
    if (app.captions.picked) app.captions.pick(null);
    else if (document.activeElement === view || document.activeElement === document.body) panel.play.focus();
    else view.focus();
  };
  const actions = {
    ' ': () => app.play(!app.playing), ArrowLeft: () => app.step(-1), ArrowRight: () => app.step(1), Home: () => app.seek(0), End: () => app.seek(app.run.end_s),
    '+': () => panel.setSpeed(1), '=': () => panel.setSpeed(1), '-': () => panel.setSpeed(-1),
    1: () => app.setCamera('orbit'), 2: () => app.setCamera('follow:' + name()), 3: () => app.setCamera('onboard:' + name()), 4: () => app.setCamera('top'),
    l: () => panel.toggle('layers'), e: () => panel.toggle('events'), h: () => panel.toggle('help'), '?': () => panel.toggle('help'),
    g: () => panel.togglePlots(), p: () => app.save(), Escape: escape, Tab: (e) => app.nextVehicle(e.shiftKey ? -1 : 1),
  };
  window.addEventListener('keydown', (e) => {
    if (!(e.key in actions) || e.ctrlKey || e.metaKey || e.altKey || keepsKey(e.target, e.key)) return;
    if (e.key === 'Tab' && e.target !== view && e.target !== document.body) return;
    e.preventDefault();
    actions[e.key](e);
  });
  // A mouse click keeps the focus in the view, so that shortcuts still work after using a control.
  let by_pointer = false;
  document.addEventListener('mousedown', (e) => { if (e.target.tagName !== 'SELECT' && e.target.closest('button, label, summary')) e.preventDefault(); });
  document.addEventListener('pointerdown', () => { by_pointer = true; });
  document.addEventListener('keydown', () => { by_pointer = false; });
  document.addEventListener('change', (e) => { if (by_pointer && e.target.tagName === 'SELECT') view.focus(); });
  if (window.parent === window) view.focus();
}
