"""A headless browser driven through a pair of pipes, without a further package (Chrome DevTools Protocol)."""

from __future__ import annotations

import base64
import contextlib
import itertools
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
KEYS = {"Enter": ("Enter", 13, "\r"), " ": ("Space", 32, " "), "Tab": ("Tab", 9, "")}


def find_browser() -> str | None:
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One page of a browser that has no network but this machine."""

    def __init__(self, folder: Path, timeout: float = 60.0):
        options = (
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--remote-debugging-pipe",
            "--no-first-run",
        )
        options += ("--autoplay-policy=no-user-gesture-required", f"--user-data-dir={folder}", "about:blank")
        options += ("--proxy-server=127.0.0.1:9", "--proxy-bypass-list=127.0.0.1", "--disable-dev-shm-usage")
        theirs, self._write = os.pipe()
        self._read, theirs_too = os.pipe()
        # A shell puts the pipes where the browser expects them: 3 and 4.
        line = f'exec "$0" "$@" 3<&{theirs} 4>&{theirs_too}'
        command = ["bash", "-c", line, find_browser(), *options]
        self._process = subprocess.Popen(
            command, pass_fds=(theirs, theirs_too), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        os.close(theirs), os.close(theirs_too)
        self._numbers, self._buffer, self._timeout, self.messages = itertools.count(1), b"", timeout, []
        target = self.call("Target.createTarget", session=None, url="about:blank")["targetId"]
        self._session = None
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Page.enable"), self.call("Runtime.enable"), self.call("Log.enable")
        self.call("Browser.setDownloadBehavior", session=None, behavior="allow", downloadPath=str(folder))

    def call(self, method, session="page", **options):
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": options}
        if session and getattr(self, "_session", None):
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + self._timeout
        while True:
            while b"\0" not in self._buffer:
                if not select.select([self._read], [], [], max(0, end - time.monotonic()))[0]:
                    raise TimeoutError(method)
                part = os.read(self._read, 1 << 20)
                assert part, "the browser has ended"
                self._buffer += part
            head, self._buffer = self._buffer.split(b"\0", 1)
            reply = json.loads(head)
            if reply.get("id") == number:
                assert "error" not in reply, reply
                return reply["result"]
            if reply.get("method") in (
                "Log.entryAdded",
                "Runtime.exceptionThrown",
                "Runtime.consoleAPICalled",
            ):
                self.messages.append(reply["params"])

    def run(self, script):
        reply = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in reply, reply
        return reply["result"].get("value")

    def wait(self, script, seconds=30.0):
        end = time.monotonic() + seconds
        while not (value := self.run(script)):
            assert time.monotonic() < end, f"{script} stays {value!r}"
            time.sleep(0.05)
        return value

    def open(self, address):
        self.call("Page.navigate", url="about:blank")  # a new fragment alone would load nothing
        self.call("Page.navigate", url=address)
        self.wait("location.href != 'about:blank' && document.readyState == 'complete'")

    def resize(self, width, height, phone=False):
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=phone,
        )

    def press(self, key):
        code, number, text = KEYS.get(key, (f"Digit{key}", ord(key[0]), key))
        for kind in ("keyDown", "keyUp"):
            told = {"text": text} if kind == "keyDown" and text else {}
            self.call(
                "Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, **told
            )

    def picture(self, path, whole=False):
        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        Path(path).write_bytes(base64.b64decode(shot["data"]))

    def close(self):
        with contextlib.suppress(Exception):
            self.call("Browser.close", session=None)
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._read), os.close(self._write)
