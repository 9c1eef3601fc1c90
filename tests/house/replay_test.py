#!/usr/bin/env python3
"""A replay as a user meets it: the commands, and the page in a headless Chromium. Usage: replay_test.py SWIFTLET

Where Chromium or its driver is not installed, the page is not looked at, and the exit status is 77.
"""
import base64
import functools
import gzip
import http.client
import http.server
import json
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import browser

SWIFTLET = pathlib.Path(sys.argv[1]).resolve()
HOSTILE = "</script><script>window.injected=1</script><img src=x onerror='window.injected=2'>"
TAB, ESCAPE, SHIFT = "\ue004", "\ue00c", "\ue008"
SCENARIO = """name: yard
duration_s: 3
world: {type: hall}
radio: {}
vehicles:
  - name: uav1
    model: x500
    start: {position_m: [0, 0, 2.5]}
    sensors: [{type: lidar, name: mid, model: mid360}]
    agent:
      localization: {type: ground_truth}
      tracker: {type: ground_truth}
      guidance: {type: waypoints, waypoints_m: [[2, 0, 2.5]]}
  - name: uav2
    model: x500
    start: {position_m: [-3, 4, 2.5]}
    agent: {localization: {type: ground_truth}, guidance: {type: hover}}
recorders: []
"""


def swiftlet(folder, *arguments):
    return subprocess.run([str(SWIFTLET), *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300)


def blocks(page):
    """The heads of the blocks of a page."""
    for text in re.findall(r'class="block">([^<]*)<', page.read_text()):
        raw = gzip.decompress(base64.b64decode(text))
        yield json.loads(raw[4:4 + int.from_bytes(raw[:4], "little")])


class Made(unittest.TestCase):
    """A run and its replay, made once."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        (cls.path / "yard.yaml").write_text(SCENARIO)
        result = swiftlet(cls.path, "run", "yard.yaml", "--out", "run", "--replay", "--threads", 1)
        assert result.returncode == 0, result.stderr
        assert f"to view it, open {cls.path.resolve() / 'run/replay.html'}" in result.stdout, result.stdout
        cls.page = cls.path / "run/replay.html"

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()


class Command(Made):
    def refused(self, *arguments, expected):
        result = swiftlet(self.path, *arguments)
        self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
        for text in expected:
            self.assertIn(text, result.stderr)

    def test_a_finished_run_is_flown_again_into_the_same_page(self):
        result = swiftlet(self.path, "replay", "run", "-o", "again.html")
        self.assertEqual((result.returncode, result.stdout), (0, "again.html\n"), result.stderr)
        self.assertEqual((self.path / "again.html").read_bytes(), self.page.read_bytes())

    def test_what_is_no_run_is_refused(self):
        self.refused("replay", expected=["run"])
        self.refused("replay", "nowhere", expected=["nowhere: expected the directory of a finished run"])
        self.refused("replay", "run", "-o", "no/such/folder/a.html", expected=["no/such/folder/a.html", "directory"])
        self.refused("replay", "run", "-o", "run", expected=["found a directory"])
        self.refused("replay", "run", "--scan-rate", "-1", expected=["--scan-rate"])
        self.assertFalse((self.path / "no").exists())

    def test_a_run_that_this_program_flies_otherwise_is_refused_and_no_page_is_left(self):
        other = self.path / "other"
        other.mkdir()
        summary = json.loads((self.path / "run/summary.json").read_text())
        summary["state_hash"] = "0123456789abcdef"
        (other / "summary.json").write_text(json.dumps(summary))
        (other / "scenario.yaml").write_text((self.path / "run/scenario.yaml").read_text())
        self.refused("replay", "other", expected=["other:", "state hash"])
        self.assertEqual(sorted(p.name for p in other.iterdir()), ["scenario.yaml", "summary.json"])

    def test_a_wrong_key_of_the_recorder_is_reported_with_its_place(self):
        self.refused("run", "yard.yaml", "--out", "b", "--set", "recorders=[{type: replay, rate_hz: 0}]",
                     expected=["recorders[0].rate_hz"])
        self.refused("run", "yard.yaml", "--out", "b", "--set", "recorders=[{type: replay, ratehz: 10}]",
                     expected=["rate_hz"])

    def test_the_run_is_the_same_with_and_without_a_replay(self):
        swiftlet(self.path, "run", "yard.yaml", "--out", "plain", "-q", "--threads", 1)
        hashes = {json.loads((self.path / d / "summary.json").read_text())["state_hash"] for d in ("run", "plain")}
        self.assertEqual(len(hashes), 1)

    def test_a_report_shows_the_replay_or_the_command_that_makes_one(self):
        self.assertEqual(swiftlet(self.path, "report", "run").returncode, 0)
        frame = re.search('<iframe src="replay.html"[^>]*>', (self.path / "run/report.html").read_text()).group(0)
        self.assertIn('sandbox="allow-scripts allow-downloads"', frame)  # the page of an unknown run reads no other file
        swiftlet(self.path, "run", "yard.yaml", "--out", "bare", "-q", "--duration", 1)
        self.assertEqual(swiftlet(self.path, "report", "bare").returncode, 0)
        self.assertIn("swiftlet replay bare", (self.path / "bare/report.html").read_text())

    def test_the_page_asks_for_nothing_and_allows_its_own_scripts_only(self):
        text = self.page.read_text()
        policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text).group(1)
        self.assertTrue(policy.startswith("default-src 'none'"))
        self.assertNotIn("unsafe", policy)
        own = len(re.findall(r"<script>|<style>", text))
        self.assertGreater(own, 1)
        self.assertEqual(policy.count("sha256-"), own)
        self.assertIn("BSD 3-Clause", text)
        self.assertIsNone(re.search(r'(src|href)="?https?:', text))


class View(Made):
    """`run --view`: the same page while the run goes on."""

    def setUp(self):
        self.fly(20000)  # a browser may take its time to start; the run is stopped at the end

    def fly(self, duration_s):
        self.run_ = subprocess.Popen([str(SWIFTLET), "run", "yard.yaml", "--view", "--out", "live", "--duration", str(duration_s),
                                      "-q", "--threads", "1"], cwd=self.path, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(self.stop)
        line = self.run_.stdout.readline()
        self.host, self.port, self.token = re.fullmatch(r"view the run at http://(127\.0\.0\.1):(\d+)/([0-9a-f]{32})/\n", line).groups()

    def test_a_run_that_ends_waits_until_an_open_page_has_everything(self):
        self.stop()
        self.fly(5)
        kinds = []
        while not kinds or kinds[-1] != "end":
            status, block = self.ask(f"/{self.token}/blocks/{len(kinds)}")
            if status == 204:
                time.sleep(0.05)
                continue
            raw = gzip.decompress(block)
            kinds.append(json.loads(raw[4:4 + int.from_bytes(raw[:4], "little")])["about"]["kind"])
        self.assertEqual(self.run_.wait(60), 0)
        self.assertEqual(kinds[:2], ["head", "world"])
        self.assertTrue((self.path / "live/summary.json").is_file())

    def test_a_client_that_sends_byte_by_byte_does_not_hold_a_finished_run(self):
        self.stop()
        self.fly(1)
        with socket.create_connection((self.host, int(self.port))) as client:
            for _ in range(1200):
                if self.run_.poll() is not None:
                    break
                try:
                    client.send(b"G")
                except OSError:
                    pass  # closed by the server
                time.sleep(0.05)
        self.assertEqual(self.run_.wait(60), 0)

    def stop(self):
        self.run_.send_signal(signal.SIGINT)
        self.run_.wait(60)
        self.run_.stdout.close()
        shutil.rmtree(self.path / "live", ignore_errors=True)

    def ask(self, path, method="GET", host=None):
        connection = http.client.HTTPConnection(self.host, int(self.port), timeout=20)
        connection.request(method, path, headers={"Host": host} if host else {})
        answer = connection.getresponse()
        return answer.status, answer.read()

    def test_only_this_machine_with_the_address_can_read_and_writing_is_refused(self):
        page = f"/{self.token}/"
        status, text = self.ask(page)
        self.assertEqual(status, 200)
        self.assertIn(b"connect-src 'self'", text)
        self.assertEqual(self.ask("/")[0], 404)
        self.assertEqual(self.ask("/" + "0" * 32 + "/")[0], 404)
        self.assertEqual(self.ask(page + "../summary.json")[0], 404)
        self.assertEqual(self.ask(page + "blocks/x")[0], 404)
        self.assertEqual(self.ask(page + "blocks/99999999")[0], 204)
        self.assertEqual(self.ask(page, method="POST")[0], 405)
        self.assertEqual(self.ask(page, host="evil.example")[0], 403)
        status, block = self.ask(page + "blocks/0")
        self.assertEqual(status, 200)
        self.assertIn(b'"kind":"head"', gzip.decompress(block))
        with self.assertRaises(OSError):  # not on the other addresses of this machine
            socket.create_connection(("127.0.0.2", int(self.port)), timeout=2).close()

    def test_an_interrupted_run_ends_and_leaves_nothing(self):
        self.ask(f"/{self.token}/")
        self.stop()
        self.assertNotEqual(self.run_.returncode, 0)
        self.assertFalse((self.path / "live").exists())

    @unittest.skipIf(browser.missing(), f"{browser.missing()} is not installed")
    def test_a_page_opened_after_the_run_reports_so(self):
        (self.path / "late").mkdir()
        (self.path / "late/index.html").write_bytes(self.ask(f"/{self.token}/")[1])
        class Quiet(http.server.SimpleHTTPRequestHandler):
            def log_message(self, *_):
                pass

        handler = functools.partial(Quiet, directory=self.path / "late")
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server, browser.Browser() as window:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            self.addCleanup(shutil.rmtree, self.path / "late")
            window.open(f"http://127.0.0.1:{server.server_port}/")
            window.wait("document.getElementById('loading').textContent.includes('ended before')")
            self.assertFalse([line for line in window.console() if "TypeError" in line])
            server.shutdown()

    @unittest.skipIf(browser.missing(), f"{browser.missing()} is not installed")
    def test_the_page_follows_the_run_and_shows_when_it_stops(self):
        with browser.Browser() as window:
            window.open(f"http://{self.host}:{self.port}/{self.token}/")
            window.wait("window.swiftlet && swiftlet.begun && swiftlet.t > 0.5 && swiftlet.run.scans.length > 3")
            before = window.run("return swiftlet.t")
            window.wait(f"swiftlet.t > {before} + 0.5")
            self.assertFalse(window.run("return swiftlet.run.complete"))
            window.run("swiftlet.seek(0.25)")
            self.assertEqual(window.run("return swiftlet.t"), 0.25)
            self.stop()
            window.wait("swiftlet.ready")
            self.assertEqual(window.run("return swiftlet.t"), 0.25)


@unittest.skipIf(browser.missing(), f"{browser.missing()} is not installed")
class Browsing(Made):
    """The page of the run in a window of some size."""

    window = {}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser.Browser(**cls.window)
        cls.open("")

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        super().tearDownClass()

    @classmethod
    def open(cls, address, page=None):
        cls.browser.open("about:blank")
        cls.browser.open((page or cls.page).as_uri() + address)
        cls.browser.wait("window.swiftlet && window.swiftlet.ready")

    def setUp(self):
        self.open("#t=1&cam=orbit")

    def tearDown(self):
        self.assertEqual([line for line in self.browser.console() if "SEVERE" in line or "rror" in line], [])

    def value(self, expression):
        return self.browser.run("return " + expression)

    def box(self, element):
        """Left, top, width and height of an element by its id."""
        return self.value(f"(b => [b.left, b.top, b.width, b.height])(document.getElementById('{element}').getBoundingClientRect())")

    def place(self, element, across, down):
        """A place within an element, as shares of its width and height."""
        left, top, width, height = self.box(element)
        return left + across * width, top + down * height

    def tip(self):
        """Lines of the values beside the pointer."""
        return self.value("document.getElementById('tip').hidden ? [] : [...document.querySelectorAll('#tip div')].map(d => [...d.children].map(c => c.textContent))")

    def outside(self):
        """Visible elements that reach out of the window or are cut off by their box."""
        return self.browser.run("""
            const out = [], seen = (e) => e.checkVisibility() && e.getBoundingClientRect().width > 0;
            for (const e of document.querySelectorAll('body *')) {
              if (!seen(e) || e.closest('#labels, #loading, #tip')) continue;
              const b = e.getBoundingClientRect();
              if (b.left < -0.5 || b.right > innerWidth + 0.5) out.push('outside: ' + (e.id || e.tagName + ' ' + e.textContent));
              if (e.tagName === 'BUTTON' && e.scrollWidth > e.clientWidth + 1) out.push('cut off: ' + e.textContent);
            }
            if (document.documentElement.scrollWidth > innerWidth) out.push('the page scrolls sideways');
            return out;""")

    def check_that_nothing_reaches_out(self):
        for tab in ("", "layers", "events", "help"):
            self.browser.run("swiftlet.panel.open(arguments[0]); swiftlet.draw()", tab)
            self.assertEqual(self.outside(), [], tab)
        self.browser.run("if (document.getElementById('plots').hidden) swiftlet.panel.togglePlots(); swiftlet.draw()")
        self.assertEqual(self.outside(), [], "with signals")


class Phone(Browsing):
    window = {"width": 412, "height": 839, "pixel_ratio": 2.6}

    def setUp(self):
        super().setUp()
        self.center = self.place("view", 0.5, 0.5)

    def camera(self):
        return self.value("(c => ({distance: c.distance, yaw: c.yaw, target: [...c.target]}))(swiftlet.scene.camera)")

    def fingers(self, before, after):
        """Two fingers at distances from the center of the picture, each given as x and y."""
        x, y = self.center
        self.browser.touch(*([(x + a[0], y + a[1]), (x + b[0], y + b[1])] for a, b in zip(before, after)))

    def test_nothing_reaches_out_of_the_window(self):
        self.check_that_nothing_reaches_out()

    def test_a_pinch_zooms_and_does_not_turn(self):
        before = self.camera()
        self.fingers([(-40, 0), (40, 0)], [(-120, 0), (120, 0)])
        after = self.camera()
        self.assertAlmostEqual(after["distance"], before["distance"] / 3, delta=0.02 * before["distance"])
        self.assertEqual(after["yaw"], before["yaw"])
        self.fingers([(-120, 0), (120, 0)], [(-40, 0), (40, 0)])
        self.assertAlmostEqual(self.camera()["distance"], before["distance"], delta=0.05 * before["distance"])

    def test_two_fingers_move_and_one_turns(self):
        before = self.camera()
        self.fingers([(-40, 0), (40, 0)], [(-40, 80), (40, 80)])
        moved = self.camera()
        self.assertNotEqual(moved["target"], before["target"])
        self.assertAlmostEqual(moved["distance"], before["distance"], delta=0.05 * before["distance"])
        self.browser.touch([self.center, (self.center[0] + 90, self.center[1])])
        turned = self.camera()
        self.assertNotEqual(turned["yaw"], moved["yaw"])
        self.assertEqual((turned["distance"], turned["target"]), (moved["distance"], moved["target"]))

    def test_a_tap_shows_facts_of_a_vehicle(self):
        self.browser.run("swiftlet.setCamera('follow:uav2'); swiftlet.draw()")
        self.browser.touch([self.place("view", 0.5, 0.5)])
        self.assertIn("uav2", self.value("document.getElementById('card').textContent"))

    def test_plots_answer_to_taps_and_pinches(self):
        self.browser.run("document.getElementById('plotted').click(); swiftlet.draw()")
        x, y = self.place("plot", 0.55, 0.2)
        self.browser.touch([(x, y)])
        self.assertRegex(self.tip()[0][1], r"^[\d.]+ s$")
        self.assertRegex(dict(self.tip()[1:])["uav1"], r"^-?[\d.]+ m$")
        self.assertGreater(self.value("swiftlet.t"), 1.1)
        self.browser.touch([(x - 20, y), (x - 60, y)], [(x + 20, y), (x + 60, y)])
        first, last = self.value("swiftlet.plot.span")
        self.assertAlmostEqual(last - first, 1.0, delta=0.1)  # a third of the run
        self.browser.run("const c = document.getElementById('whole'); if (c.hidden) throw Error('no control shows the whole run'); c.click()")
        self.assertEqual(self.value("swiftlet.plot.span"), [0, 3])


class Page(Browsing):
    def pixels(self, change):
        """How many pixels differ from those of the picture without that change."""
        return self.browser.run("""
            const take = () => { swiftlet.draw(); const {gl, canvas: c} = swiftlet.painter, p = new Uint8Array(4 * c.width * c.height);
              gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p); return p; };
            const before = take(); eval_change(); const after = take();
            let n = 0; for (let i = 0; i < after.length; i += 4) n += before[i] !== after[i] || before[i + 1] !== after[i + 1] || before[i + 2] !== after[i + 2];
            return n;""".replace("eval_change()", change))

    def test_a_followed_vehicle_is_seen_in_its_color(self):
        count = """
            swiftlet.setCamera('follow:' + arguments[0]); for (const layer of ['world', 'sweeps', 'trails']) swiftlet.scene.layers[layer] = false;
            swiftlet.draw(); const {gl, canvas: c} = swiftlet.painter, p = new Uint8Array(4 * c.width * c.height);
            gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p); let red = 0, blue = 0;
            for (let i = 0; i < p.length; i += 4) { red += p[i] > 1.8 * p[i + 2] + 20; blue += p[i + 2] > 1.8 * p[i] + 20; }
            return [red, blue];"""
        red, blue = self.browser.run(count, "uav1")  # the first color of the palette is red, the second blue
        self.assertGreater(red, 60)
        self.assertGreater(red, blue)
        red, blue = self.browser.run(count, "uav2")
        self.assertGreater(blue, 60)
        self.assertGreater(blue, red)

    def test_every_layer_changes_the_picture(self):
        self.browser.run("swiftlet.setCamera('follow:uav1')")
        for layer in ("world", "vehicles", "trails", "sweeps", "tracks", "covariances", "references", "estimates"):
            self.browser.run("swiftlet.seek(2.2)")
            self.assertGreater(self.pixels(f"document.getElementById('layer-{layer}').click()"), 10 if layer != "covariances" else 0, layer)  # that of the truth is small
        labels = "[...document.querySelectorAll('#labels span')].filter(s => !s.hidden).map(s => s.textContent)"
        self.assertIn("uav2", self.value(labels))
        self.browser.run("document.getElementById('layer-names').click(); swiftlet.draw()")
        self.assertNotIn("uav2", self.value(labels))

    def test_every_coloring_of_points_differs(self):
        self.browser.run("swiftlet.setCamera('follow:uav1'); swiftlet.seek(2)")
        for color in ("range", "intensity", "label", "vehicle", "sensor", "height"):
            change = f"{{const s = document.getElementById('color'); s.value = '{color}'; s.dispatchEvent(new Event('change'));}}"
            self.assertGreater(self.pixels(change), 10, color)

    def test_every_camera_sees_something_else(self):
        for camera in ("follow:uav2", "onboard:uav1", "top", "orbit"):
            change = f"{{const s = document.getElementById('camera'); s.value = '{camera}'; s.dispatchEvent(new Event('change'));}}"
            self.assertGreater(self.pixels(change), 1000, camera)
            self.assertEqual(self.value("swiftlet.cameraText()"), camera)

    def test_it_plays_at_the_chosen_speed_and_stops_at_the_end(self):
        self.browser.run("swiftlet.seek(0); const s = document.getElementById('speed'); s.value = '50'; s.dispatchEvent(new Event('change'));")
        self.browser.press(" ")
        self.browser.wait("swiftlet.t === swiftlet.run.end_s && !swiftlet.playing")
        self.browser.press("-")
        self.assertEqual(self.value("swiftlet.speed"), 20)
        self.assertEqual(self.value("swiftlet.run.end_s"), 3)

    def test_steps_go_from_scan_to_scan(self):
        self.browser.run("swiftlet.seek(0.2)")
        first = self.browser.run("document.getElementById('next').click(); return swiftlet.t")
        second = self.browser.run("document.getElementById('next').click(); return swiftlet.t")
        ends = self.value("swiftlet.run.scans.map(s => s.end_s)")
        self.assertIn(first, ends)
        self.assertIn(second, ends)
        self.assertGreater(second, first)
        self.assertEqual(self.browser.run("document.getElementById('back').click(); return swiftlet.t"), first)

    def test_nothing_reaches_out_of_the_window(self):
        self.check_that_nothing_reaches_out()

    def test_keys_work_without_a_click(self):
        self.assertEqual(self.value("swiftlet.cameraText()"), "orbit")
        self.browser.press(TAB)
        self.assertEqual(self.value("swiftlet.cameraText()"), "follow:uav2")
        self.browser.press(TAB)
        self.assertEqual(self.value("swiftlet.cameraText()"), "follow:uav1")
        self.browser.press(SHIFT, TAB)
        self.assertEqual(self.value("swiftlet.cameraText()"), "follow:uav2")
        self.browser.press("4")
        self.assertEqual(self.value("swiftlet.cameraText()"), "top")
        self.browser.press(" ")
        self.assertTrue(self.value("swiftlet.playing"))

    def test_escape_leads_to_the_controls_and_back(self):
        self.browser.press(ESCAPE)
        self.browser.press(TAB)
        self.browser.press(TAB)
        self.assertEqual(self.value("document.activeElement.tagName"), "SELECT")
        self.assertEqual(self.value("swiftlet.cameraText()"), "orbit")
        self.browser.press(SHIFT, TAB)
        before = self.value("swiftlet.t")
        self.browser.press(" ")  # activates the button with the focus
        self.assertGreater(self.value("swiftlet.t"), before)
        self.assertFalse(self.value("swiftlet.playing"))
        self.browser.press(ESCAPE)
        self.browser.press(TAB)
        self.assertEqual(self.value("swiftlet.cameraText()"), "follow:uav2")

    def test_every_key_of_the_help_does_something(self):
        keys = self.value("[...document.querySelectorAll('#help kbd')].map(k => k.textContent)")
        self.assertIn("tab", keys)
        codes = {"space": " ", "←": "\ue012", "→": "\ue014", "−": "-", "home": "\ue011", "end": "\ue010", "tab": TAB, "esc": ESCAPE}
        self.browser.run("window.asked = []; for (const name of ['play', 'step', 'seek', 'setCamera', 'save']) { swiftlet[name] = () => asked.push(name); }"
                         "for (const name of ['toggle', 'togglePlots', 'setSpeed']) { swiftlet.panel[name] = () => asked.push(name); }"
                         "swiftlet.captions.pick({vehicle: 0}, 1); swiftlet.captions.pick = () => asked.push('pick');")
        for key in keys:
            self.browser.press(codes.get(key, key))
            self.assertEqual(len(self.browser.run("return asked.splice(0)")), 1, key)

    def test_the_event_log_is_text_and_seeks(self):
        events = self.value("swiftlet.run.events")
        crash = next(i for i, event in enumerate(events) if event["kind"] == "crash")
        self.browser.press("e")
        lines = self.value("[...document.querySelectorAll('#events button')].map(b => b.innerText)")
        self.assertEqual(len(lines), len(events))
        for text in (f"{events[crash]['t_s']:.2f} s", "uav1", "crash into " + events[crash]["partner"]):
            self.assertIn(text, lines[crash])
        left, top, width, height = self.value(f"(b => [b.left, b.top, b.width, b.height])(document.querySelectorAll('#events button')[{crash}].getBoundingClientRect())")
        self.browser.click(left + width / 2, top + height / 2)
        self.assertEqual(self.value("swiftlet.t"), events[crash]["t_s"])
        self.browser.wait(f"document.querySelectorAll('#events button')[{crash}].classList.contains('now')")

    def test_the_pointer_reads_values_in_the_plots(self):
        self.browser.hover(*self.place("plot", 0.1, 0.5))  # before the crash, where heights change slowly
        (signal, instant), *values = self.tip()
        t = float(instant.removesuffix(" s"))
        self.assertEqual((signal, [name for name, _ in values]), ("z_m", ["uav1", "uav2"]))
        self.assertGreater(t, 0)
        for i, (_, value) in enumerate(values):
            self.assertTrue(value.endswith(" m"), value)
            self.assertAlmostEqual(float(value.removesuffix(" m")), self.value(f"swiftlet.run.vehicleAt({i}, {t}).p[2]"), delta=0.02)
        self.browser.hover(*self.place("plot", 0.55, 0.5))
        self.assertEqual([self.tip()[0][0], self.tip()[1][1].split()[-1]], ["speed_mps", "m/s"])
        self.browser.hover(*self.place("view", 0.5, 0.5))
        self.assertEqual(self.tip(), [])

    def test_the_time_of_the_plots_zooms_by_wheel_and_drag(self):
        x, y = self.place("plot", 0.2, 0.5)
        self.browser.hover(x, y)
        self.browser.wheel(x, y, -400)
        self.browser.wait("swiftlet.plot.span[1] - swiftlet.plot.span[0] < 2", 10)  # on a busy machine the page scrolls later
        first, last = self.value("swiftlet.plot.span")
        self.assertTrue(first < self.value("swiftlet.plot.pointer") < last)
        dragged = [self.value(f"swiftlet.plot.timeAt({a}, 60)") for a in (x, x + 60)]
        self.browser.drag(x, y, 60, 0)
        for bound, expected in zip(self.value("swiftlet.plot.span"), dragged):
            self.assertAlmostEqual(bound, expected, delta=0.02)

    def test_the_time_line_and_the_plots_seek(self):
        for element, share in (("track", 0.5), ("plot", 0.25)):
            self.browser.run("swiftlet.seek(0)")
            self.browser.click(*self.place(element, share, 0.5))
            self.assertGreater(self.value("swiftlet.t"), 0.2, element)
            self.assertLess(self.value("swiftlet.t"), 3.0, element)

    def test_an_address_names_an_instant_and_a_camera(self):
        self.open("#t=1.5&cam=follow:uav2")
        self.assertEqual(self.value("[swiftlet.t, swiftlet.cameraText()]"), [1.5, "follow:uav2"])
        self.browser.run("swiftlet.seek(2.25); swiftlet.setCamera('onboard:uav1')")
        self.assertEqual(self.value("location.hash"), "#t=2.25&cam=onboard:uav1")
        self.open("#t=never&cam=nowhere:uav9")
        self.assertEqual(self.value("swiftlet.t"), 0)

    def test_a_click_shows_facts_of_a_vehicle_and_of_a_point(self):
        self.browser.run("swiftlet.seek(2)")
        place = "(a => { const b = document.getElementById('view').getBoundingClientRect(); return [a[0] + b.left, a[1] + b.top]; })"
        self.browser.run("swiftlet.setCamera('follow:uav2'); swiftlet.draw()")
        self.browser.click(*self.value(place + "(swiftlet.scene.project(swiftlet.run.vehicleAt(1, swiftlet.t).p, swiftlet.scene.last_view))"))
        self.assertIn("uav2", self.value("document.getElementById('card').textContent"))
        self.assertIn("speed", self.value("document.getElementById('card').textContent"))
        # A point that is on the screen and not behind a vehicle.
        at = self.browser.run("""swiftlet.setCamera('top'); swiftlet.scene.camera.distance = 25; swiftlet.draw();
            const scan = swiftlet.scene.points.at(swiftlet.t)[0], c = document.getElementById('view'), b = c.getBoundingClientRect();
            for (let i = 0; i < scan.count; ++i) {
              const a = swiftlet.scene.project([...scan.p_world_m.slice(3 * i, 3 * i + 3)], swiftlet.scene.last_view);
              if (!a || a[0] < 100 || a[1] < 100 || a[0] > c.clientWidth - 100 || a[1] > c.clientHeight - 100) continue;
              const hit = swiftlet.scene.pick(a[0], a[1], swiftlet.t);
              if (hit && hit.scan) return [a[0] + b.left, a[1] + b.top];
            }""")
        self.browser.click(*at)
        card = self.value("document.getElementById('card').textContent")
        for word in ("class", "instance", "range", "beam", "uav1/mid"):
            self.assertIn(word, card)

    def test_a_point_lies_where_its_surface_is(self):
        # The hall has walls, floor and ceiling: no point lies outside of its bounds.
        outside = self.browser.run("""const [low, high] = swiftlet.run.head.bounds_m; let n = 0;
            for (const s of swiftlet.run.scans) for (let i = 0; i < s.count; ++i) for (let c = 0; c < 3; ++c) {
              const x = s.p_world_m[3 * i + c]; n += x < low[c] - 0.5 || x > high[c] + 0.5 ? 1 : 0; }
            return n;""")
        points = self.value("swiftlet.run.scans.reduce((n, s) => n + s.count, 0)")
        self.assertGreater(points, 2000)
        self.assertLess(outside, 0.001 * points)

    def test_signals_can_be_chosen_and_a_picture_is_a_png(self):
        self.assertIn("est_x_m", self.value("swiftlet.run.signals()"))
        self.browser.run("const s = document.getElementById('signal0'); s.value = 'tilt_deg'; s.dispatchEvent(new Event('change'));")
        self.assertEqual(self.value("swiftlet.plot.signals[0]"), "tilt_deg")
        png = self.value("swiftlet.picture().toDataURL('image/png')")
        self.assertTrue(base64.b64decode(png.split(",")[1]).startswith(b"\x89PNG"))

    def test_names_of_a_scenario_are_shown_and_never_run(self):
        (self.path / "hostile.yaml").write_text(SCENARIO.replace("name: yard", "name: " + json.dumps(HOSTILE)))
        result = swiftlet(self.path, "run", "hostile.yaml", "--out", "hostile", "--replay", "-q", "--duration", 1)
        if result.returncode == 2:  # such a name is refused before it gets anywhere
            self.assertIn("name", result.stderr)
            page = self.path / "hostile.html"
            text = self.page.read_text()
            head = re.search(r'class="block">([^<]*)<', text)
            raw = gzip.decompress(base64.b64decode(head.group(1)))
            length = int.from_bytes(raw[:4], "little")
            about = json.loads(raw[4:4 + length])
            about["about"]["scenario"] = HOSTILE
            about["about"]["vehicles"][0] = HOSTILE
            head_bytes = json.dumps(about).encode()
            packed = base64.b64encode(gzip.compress(len(head_bytes).to_bytes(4, "little") + head_bytes + raw[4 + length:])).decode()
            page.write_text(text.replace(head.group(1), packed, 1))
        else:
            page = self.path / "hostile/replay.html"
        self.open("", page)
        self.assertEqual(self.value("document.getElementById('scenario').textContent"), HOSTILE)
        self.browser.run("swiftlet.captions.pick({vehicle: 0}, swiftlet.t); swiftlet.draw()")
        self.assertIsNone(self.value("window.injected"))
        self.assertEqual(self.value("document.querySelectorAll('img').length"), 0)

    def test_the_policy_stops_a_script_that_got_in(self):
        self.browser.run("const s = document.createElement('script'); s.textContent = 'window.injected = 3'; document.body.append(s)")
        self.assertIsNone(self.value("window.injected"))
        self.assertTrue(any("Content Security Policy" in line for line in self.browser.console()))


if __name__ == "__main__":
    program = unittest.main(argv=sys.argv[:1], exit=False)
    if not program.result.wasSuccessful():
        sys.exit(1)
    if browser.missing():
        print(f"the page was not looked at: {browser.missing()} is not installed")
        sys.exit(77)
