"""A headless Chromium, driven by chromium-driver over HTTP (W3C WebDriver); needs nothing but Python's own library."""
import base64
import json
import shutil
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request


def missing():
    """What is not installed, or an empty text."""
    if not (shutil.which("chromium") or shutil.which("chromium-browser")):
        return "chromium"
    return "" if shutil.which("chromedriver") else "chromium-driver"


class Browser:
    """A window of a size in pixels of CSS; with a pixel ratio it is the touch screen of a phone."""

    def __init__(self, width=1280, height=800, pixel_ratio=None):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.profile = tempfile.TemporaryDirectory()
        self.driver = subprocess.Popen([shutil.which("chromedriver"), f"--port={port}"], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
        self.address = f"http://127.0.0.1:{port}"
        flags = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
                 "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
                 "--hide-scrollbars", f"--window-size={width},{height}", f"--user-data-dir={self.profile.name}"]
        wanted = {"browserName": "chrome", "goog:loggingPrefs": {"browser": "ALL"}, "pageLoadStrategy": "none",
                  "timeouts": {"script": 110000},  # [ms] a busy machine makes the browser's own 30 s too few
                  "goog:chromeOptions": {"args": flags, "binary": shutil.which("chromium") or shutil.which("chromium-browser")}}
        if pixel_ratio:
            wanted["goog:chromeOptions"]["mobileEmulation"] = {
                "deviceMetrics": {"width": width, "height": height, "pixelRatio": pixel_ratio, "touch": True, "mobile": True}}
        for attempt in range(100):
            try:
                self.session = ""
                made = self.ask("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
                break
            except (urllib.error.URLError, ConnectionError):
                if attempt == 99:
                    raise
                time.sleep(0.1)
        self.session = "/session/" + made["sessionId"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.ask("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait(20)
            self.profile.cleanup()

    def ask(self, method, path, body=None):
        request = urllib.request.Request(self.address + self.session + path, method=method,
                                         data=None if body is None else json.dumps(body).encode(),
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def open(self, address):
        self.ask("POST", "/url", {"url": str(address)})

    def run(self, script, *arguments):
        return self.ask("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, condition, seconds=60):
        """Until the expression is true."""
        for _ in range(int(20 * seconds)):
            if self.run(f"return Boolean({condition})"):
                return
            time.sleep(0.05)
        raise TimeoutError(f"{condition} is not true after {seconds} s; the console: {self.console()}")

    def console(self):
        return [entry["message"] for entry in self.ask("POST", "/se/log", {"type": "browser"})]

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self.ask("GET", "/screenshot")))

    def press(self, *keys):
        """Presses keys together and lifts them."""
        actions = [{"type": "keyDown", "value": key} for key in keys] + [{"type": "keyUp", "value": key} for key in reversed(keys)]
        self.ask("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def pointer(self, *actions):
        self.ask("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": list(actions)}]})

    def hover(self, x, y):
        self.pointer(move(x, y))

    def click(self, x, y):
        self.pointer(move(x, y), DOWN, UP)

    def drag(self, x, y, dx, dy):
        self.pointer(move(x, y), DOWN, move(x + dx, y + dy, 50), UP)

    def wheel(self, x, y, dy):
        self.ask("POST", "/actions", {"actions": [{"type": "wheel", "id": "wheel", "actions": [
            {"type": "scroll", "x": round(x), "y": round(y), "deltaX": 0, "deltaY": round(dy)}]}]})

    def touch(self, *paths):
        """One finger for each path, all at a time: down at its first place, along the others, up."""
        self.ask("POST", "/actions", {"actions": [
            {"type": "pointer", "id": f"finger{i}", "parameters": {"pointerType": "touch"},
             "actions": [move(*path[0]), DOWN, *(move(x, y, 50) for x, y in path[1:]), UP]} for i, path in enumerate(paths)]})


DOWN, UP = {"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}


def move(x, y, duration_ms=0):
    return {"type": "pointerMove", "x": round(x), "y": round(y), "duration": duration_ms}
