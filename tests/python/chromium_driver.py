"""A page in headless Chromium, driven as a hand does: the mouse, fingers, keys. Chromium's own protocol through two pipes; nothing goes over a network."""

import base64
import contextlib
import fcntl
import json
import os
import select
import subprocess
import tempfile
import time
from pathlib import Path

from quoin_tools.show import browser

PATIENCE = 60  # [s] for one answer, on a machine with other work


class Page:
    """Of a local file. errors: what its scripts complained of; asked: addresses that it wanted to load."""

    def __init__(self, send, receive, process):
        self.send, self.receive, self.process = send, receive, process
        self.count, self.rest, self.session = 0, b"", None
        self.errors, self.asked = [], []

    def call(self, method, **given):
        """What Chromium answers."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": given} | ({"sessionId": self.session} if self.session else {})
        os.write(self.send, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.next()
            if answer.get("id") == self.count:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
            self.note(answer)

    def next(self):
        until = time.monotonic() + PATIENCE
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.receive], [], [], max(0.0, until - time.monotonic()))
            assert ready, "Chromium does not answer"
            data = os.read(self.receive, 1 << 20)
            assert data, "Chromium has ended"
            self.rest += data
        answer, self.rest = self.rest.split(b"\0", 1)
        return json.loads(answer)

    def note(self, event):
        if event.get("method") == "Runtime.exceptionThrown":
            self.errors.append(event["params"]["exceptionDetails"])
        elif event.get("method") == "Log.entryAdded" and event["params"]["entry"]["level"] == "error":
            self.errors.append(event["params"]["entry"]["text"])
        elif event.get("method") == "Network.requestWillBeSent":
            self.asked.append(event["params"]["request"]["url"])

    def open(self, path, width, height, touch):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        self.call("Page.navigate", url=Path(path).resolve().as_uri())
        until = time.monotonic() + PATIENCE
        while self.value("document.readyState") != "complete" or self.value("location.href") == "about:blank":
            assert time.monotonic() < until, "the page does not load"
            time.sleep(0.05)
        self.settle()

    def value(self, expression):
        """Of JavaScript in the page."""
        done = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in done, done["exceptionDetails"]
        return done["result"].get("value")

    def settle(self):
        """Waits until what was asked for is drawn."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    # ---- hands

    def place(self, selector, right=0.5, lower=0.5):
        """A place within an element, scrolled into view [px]."""
        box = self.value(f"(() => {{ const e = document.querySelector({selector!r}); e.scrollIntoView({{block: 'nearest'}}); const b = e.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; }})()")
        return box[0] + right * box[2], box[1] + lower * box[3]

    def click(self, selector, right=0.5, lower=0.5):
        x, y = self.place(selector, right, lower)
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        self.settle()

    def drag(self, selector, start, end):
        (x, y), (to_x, to_y) = self.place(selector, *start), self.place(selector, *end)
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1)
        for part in (0.3, 0.6, 1.0):
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + part * (to_x - x), y=y + part * (to_y - y), button="left", buttons=1)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=to_x, y=to_y, button="left", buttons=0, clickCount=1)
        self.settle()

    def touch(self, kind, *fingers):
        self.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(fingers)])
        self.settle()

    def key(self, key, code=0):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, **({"text": key} if kind == "keyDown" and len(key) == 1 else {}))
        self.settle()

    def choose(self, selector, value):
        """A row of a list."""
        self.value(f"(() => {{ const e = document.querySelector({selector!r}); e.value = {value!r}; e.dispatchEvent(new Event('change')); return e.value; }})()")
        self.settle()

    # ---- what is to be seen

    def number(self, key, table="numbers"):
        """Of a row of a table, as the page computes it; None: no such row."""
        found = self.value(f"document.querySelector('#{table} tr[data-key=\"{key}\"] td')?.dataset.value ?? null")
        return None if found is None else float(found)

    def text(self, selector):
        return self.value(f"document.querySelector({selector!r}).textContent")

    def colours(self, selector="#section"):
        """How many dots of a canvas have each colour: {(r, g, b): n}."""
        rows = self.value(f"""(() => {{ const c = document.querySelector({selector!r}), d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data, n = {{}};
            for (let i = 0; i < d.length; i += 4) if (d[i + 3] > 200) {{ const k = d[i] + "," + d[i + 1] + "," + d[i + 2]; n[k] = (n[k] || 0) + 1; }} return n; }})()""")
        return {tuple(map(int, key.split(","))): count for key, count in rows.items()}

    def screenshot(self, path):
        Path(path).write_bytes(base64.b64decode(self.call("Page.captureScreenshot", captureBeyondViewport=True)["data"]))


def leave(page):
    """Chromium ends by itself, and takes its files with it; else it is ended."""
    with contextlib.suppress(AssertionError, OSError):
        page.session = None
        page.call("Browser.close")
    try:
        page.process.wait(10)
    except subprocess.TimeoutExpired:
        page.process.kill()
        page.process.wait()


@contextlib.contextmanager
def opened(path, width=1200, height=1000, touch=False):
    """A Page of a local file."""
    to_chromium, from_chromium = os.pipe(), os.pipe()
    theirs = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_chromium[0], from_chromium[1])]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser.find(), *browser.FLAGS, f"--user-data-dir={profile}", "--remote-debugging-pipe", "about:blank"]
        wired = ["bash", "-c", f'exec "$@" 3<&{theirs[0]} 4>&{theirs[1]}', "bash", *command]  # Chromium reads 3 and writes 4
        process = subprocess.Popen(wired, pass_fds=theirs, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for end in (to_chromium[0], from_chromium[1], *theirs):
            os.close(end)
        page = Page(to_chromium[1], from_chromium[0], process)
        try:
            page.open(path, width, height, touch)
            yield page
        finally:
            leave(page)
            os.close(to_chromium[1])
            os.close(from_chromium[0])
