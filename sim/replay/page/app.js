// SPDX-License-Identifier: BSD-3-Clause
// The page: reads the blocks, keeps time, speed and camera, and redraws when one of them changes.
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

class App {
  constructor() {
    this.run = new Run();
    this.t = 0;
    this.playing = false;
    this.speed = 1;
    this.dirty = true;
  }

  async start() {
    this.painter = new Painter(byId('view'));
    this.scene = new Scene(this.painter, this.run);
    this.plot = new Plot(byId('plot'), this.run);
    this.captions = new Captions(this.scene, this.run);
    this.panel = new Panel(this);
    const blocks = [...document.querySelectorAll('script.block')];
    if (!blocks.length) return this.follow();
    const unpacked = (i) => {
      const text = blocks[i].textContent;
      blocks[i].remove();  // frees its memory
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

  /** A run in progress: fetches block after block from the page's server. */
  async follow() {
    this.following = true;
    for (let k = 0; !this.run.complete;) {
      const response = await fetch('blocks/' + k, {cache: 'no-store'}).catch(() => null);
      if (!response || response.status > 204) break;  // the run has ended or was stopped
      if (response.status === 204) {
        await new Promise((resolve) => setTimeout(resolve, 150));
        continue;
      }
      this.take(readBlock(await unpack(new Uint8Array(await response.arrayBuffer()))));
      ++k;
      const parts = [this.run.overlays.size, this.scene.points.sensors().length, this.run.tables.tracks.rows > 0, this.run.events.length].join();
      if (this.begun && parts !== this.parts) { this.parts = parts; this.panel.update(); }
    }
    if (!this.begun) {
      byId('progress').textContent = 'the run ended before this page had anything of it; swiftlet run --replay keeps it';
      return;
    }
    byId('notice').textContent = this.run.complete ? '' : 'the run was stopped';
    this.fill();
  }

  /** Adds a block. The first chunk of states opens the page. */
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

  build() {
    const {head} = this.run;
    document.title = 'Swiftlet replay: ' + head.scenario;
    byId('scenario').textContent = head.scenario;
    this.panel.build();
    this.timeline = new Timeline(this.panel.track, this.run);
    listenToView(this);
    listenToTimeline(this);
    listenToPlot(this);
    listenToKeys(this);
    const resized = new ResizeObserver(() => { this.dirty = true; });
    for (const id of ['view', 'plot', 'track']) resized.observe(byId(id));
    window.addEventListener('hashchange', () => this.readAddress());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { this.dirty = true; });
  }

  /** Completes the page after the last block. */
  fill() {
    const {run} = this, count = run.scans.reduce((n, s) => n + s.count, 0), all = run.scans.reduce((n, s) => n + s.returns, 0);
    byId('about').textContent = `${run.vehicles.length} vehicle${run.vehicles.length === 1 ? '' : 's'}, ${run.end_s.toFixed(1)} s`;
    const shown = run.world.reduce((n, m) => n + m.indices.length / 3 * (m.places ? m.places.rows : 1), 0);
    const thinned = [];
    if (count) thinned.push(`scans: ${run.head.rates.scan_hz} a second of each LiDAR, ${count < all ? `${(100 * count / all).toFixed(count / all < 0.1 ? 1 : 0)} % of their points` : 'all points'}`);
    if (run.head.triangles && shown < run.head.triangles) thinned.push(`world: ${Math.round(shown / 1000)} of ${Math.round(run.head.triangles / 1000)} thousand triangles`);
    byId('notice').textContent = thinned.join(' · ');
    this.panel.update();
    if (this.following === undefined) this.readAddress();
    this.ready = true;
    this.dirty = true;
  }

  // --- Time and camera -------------------------------------------------------------------------------------------------

  play(on) {
    if (this.following !== undefined && !this.run.complete) this.following = on && this.t > this.run.end_s - 1;
    if (on && this.t >= this.run.end_s - 1e-6 && (this.run.complete || this.following === undefined)) this.t = 0;
    this.playing = on;
    this.panel.play.textContent = on ? 'Pause' : 'Play';
    if (!on) this.writeAddress();
    this.dirty = true;
  }

  seek(t) {
    if (this.following) this.following = false;  // until play is pressed at the end
    this.t = Math.max(0, Math.min(this.run.end_s, t));
    if (!this.playing) this.writeAddress();
    this.dirty = true;
  }

  /** Steps to the next scan, or by half a second without scans. */
  step(sign) {
    this.play(false);
    const {points} = this.scene, ends = this.run.scans.filter((s) => !points.hidden.has(Points.sensorOf(s))).map((s) => s.end_s);
    const next = sign > 0 ? ends.find((s) => s > this.t + 1e-3) : ends.filter((s) => s < this.t - 1e-3).pop();
    this.seek(next ?? this.t + 0.5 * sign);
  }

  /** "orbit", "top", "follow:uav1", "onboard:uav2"; false for an unknown kind or vehicle. */
  setCamera(text) {
    const colon = text.indexOf(':'), kind = colon < 0 ? text : text.slice(0, colon), name = colon < 0 ? '' : text.slice(colon + 1);
    const {camera, choices} = this.scene, vehicle = name ? this.run.vehicles.findIndex((v) => v.name === name) : camera.vehicle;
    if (!['orbit', 'top', 'follow', 'onboard'].includes(kind) || vehicle < 0) return false;
    const followed = this.run.vehicleAt(camera.vehicle, this.t);
    camera.change(kind, vehicle, followed && followed.p, choices.scale);
    this.panel.camera.value = this.cameraText();
    if (!this.playing) this.writeAddress();
    this.dirty = true;
    return true;
  }

  /** Follows the next vehicle, or the previous one with -1. */
  nextVehicle(step) {
    const {camera} = this.scene, {vehicles} = this.run, next = (camera.vehicle + step + vehicles.length) % vehicles.length;
    this.setCamera((camera.kind === 'onboard' ? 'onboard:' : 'follow:') + vehicles[next].name);
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

  // --- Drawing ---------------------------------------------------------------------------------------------------------

  frame(now) {
    const passed_s = Math.min(0.25, (now - (this.last_frame ?? now)) / 1000);
    this.last_frame = now;
    if (this.following && this.begun && this.t < this.run.end_s) {
      this.t += (this.run.end_s - this.t) * Math.min(1, 3 * passed_s);
      this.dirty = true;
    } else if (this.playing) {
      this.t = Math.min(this.run.end_s, this.t + passed_s * this.speed);
      this.plot.follow(this.t);
      this.dirty = true;
      if (this.t >= this.run.end_s && this.ready) this.play(false);
    }
    // Drawing delays the reading of the run: until it is complete, two pictures a second show the progress.
    const reads = !this.ready && !this.following && now - (this.drawn_at ?? -Infinity) < 500;
    if (this.dirty && !reads) {
      this.drawn_at = now;
      this.hurry(now);
      this.draw();
    } else if (this.scene.hurried && now - this.moved_at > 300) {
      this.scene.hurried = false;  // the motion has ended: a complete picture
      this.draw();
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  /** Where drawing is slow, pictures during motion are coarser and without leaves. */
  hurry(now) {
    const took_ms = now - (this.moved_at ?? 0);
    this.moved_at = now;
    if (took_ms > 1500) this.slow = 0;  // first frame of a motion
    else if (took_ms > 90) this.slow = Math.min(3, (this.slow ?? 0) + 1);
    this.scene.hurried = this.slow >= 3;
  }

  draw() {
    this.dirty = false;
    const canvas = byId('view'), ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.scene.hurried ? 0.5 : 1);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const view = this.scene.draw(this.t);
    this.captions.show(view, this.t);
    this.panel.clock.textContent = `${this.t.toFixed(2)} / ${this.run.end_s.toFixed(1)} s`;
    this.panel.markEvent(this.t);
    this.timeline.draw(this.t);
    this.drawPlot();
  }

  drawPlot() {
    if (byId('plots').hidden) return;
    this.panel.whole.hidden = !this.plot.shown;
    this.plot.draw(this.t);
  }

  /** The view with names and time, as a canvas. */
  picture() {
    this.draw();
    return this.captions.picture(this.t);
  }

  save() {
    this.picture().toBlob((blob) => {
      const link = make('a', {href: URL.createObjectURL(blob), download: `${this.run.head.scenario.replace(/[^\w.-]+/g, '_')}_${this.t.toFixed(2)}s.png`});
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    }, 'image/png');
  }
}

window.swiftlet = new App();
window.swiftlet.start().catch((error) => {
  byId('loading').hidden = false;
  byId('progress').textContent = 'cannot show this run: ' + error.message;
  console.error(error);
});
