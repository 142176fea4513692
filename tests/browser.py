"""A headless Chromium, driven through chromedriver's WebDriver protocol, where both are installed."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.error import HTTPError

from PIL import Image

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
DRIVER = "chromedriver"
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the protocol's name of an element
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
_SECONDS = 20.0
KEYS = {"Left": "\ue012", "Right": "\ue014", "Home": "\ue011", "End": "\ue010", "Escape": "\ue00c"}


def missing() -> str | None:
    """Return why there is no browser; None if there is one."""
    if not any(map(shutil.which, BROWSERS)):
        return f"none of {', '.join(BROWSERS)} is installed"
    return None if shutil.which(DRIVER) else f"{DRIVER} is not installed"


class Browser:
    """One session of a browser. Elements are named by CSS selectors."""

    def __init__(self, port: int, session: str) -> None:
        self._root = f"http://127.0.0.1:{port}/session/{session}"

    def open(self, page: Path, *, width: int = 1280, height: int = 900) -> None:
        """Show a file in a window of a size."""
        self.visit(page.resolve().as_uri(), width=width, height=height)

    def visit(self, url: str, *, width: int = 1280, height: int = 900) -> None:
        """Show an address in a window of a size."""
        self.resize(width, height)
        self._do("POST", "/url", {"url": url})

    def resize(self, width: int, height: int) -> None:
        """Change the size of the window."""
        self._do("POST", "/window/rect", {"width": width, "height": height})

    def run(self, script: str) -> Any:
        """Return what a script returns."""
        return self._do("POST", "/execute/sync", {"script": script, "args": []})

    def click(self, selector: str) -> None:
        """Click the middle of an element."""
        self._do("POST", f"/element/{self._find(selector)}/click", {})

    def text(self, selector: str) -> str:
        """Return the text of an element as it is shown."""
        return self._do("GET", f"/element/{self._find(selector)}/text")

    def press(self, key: str) -> None:
        """Press a key and let it go."""
        value = KEYS.get(key, key)
        actions = [{"type": kind, "value": value} for kind in ("keyDown", "keyUp")]
        self._do("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def point(self, selector: str, x: float, y: float) -> None:
        """Move the mouse to a place in an element, in pixels from its middle."""
        origin = {_ELEMENT: self._find(selector)}
        move = {"type": "pointerMove", "duration": 0, "origin": origin, "x": round(x), "y": round(y)}
        self._do("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": [move]}]})

    def drag(self, selector: str, x: float, y: float, *, steps: int = 4) -> None:
        """Press the mouse in the middle of an element, move it by pixels, and let it go."""
        origin = {_ELEMENT: self._find(selector)}
        actions = [{"type": "pointerMove", "duration": 0, "origin": origin, "x": 0, "y": 0}]
        actions += [{"type": "pointerDown", "button": 0}]
        for step in range(1, steps + 1):
            place = {"x": round(x * step / steps), "y": round(y * step / steps)}
            actions.append({"type": "pointerMove", "duration": 30, "origin": origin, **place})
        actions.append({"type": "pointerUp", "button": 0})
        self._do("POST", "/actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]})

    def screenshot(self) -> Image.Image:
        """Return what the window shows."""
        return Image.open(io.BytesIO(base64.b64decode(self._do("GET", "/screenshot")))).convert("RGB")

    def until(self, script: str, *, seconds: float = _SECONDS) -> None:
        """Wait until a script returns true."""
        give_up = time.monotonic() + seconds
        while not self.run(script):
            assert time.monotonic() < give_up, f"never true: {script}"
            time.sleep(0.02)

    def errors(self) -> list[str]:
        """Return what the page has reported to the console since the last call."""
        return [each["message"] for each in self._do("POST", "/se/log", {"type": "browser"})]

    def close(self) -> None:
        """End the session."""
        self._do("DELETE", "")

    def _find(self, selector: str) -> str:
        return self._do("POST", "/element", {"using": "css selector", "value": selector})[_ELEMENT]

    def _do(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        return _asked(method, self._root + path, body)


@contextlib.contextmanager
def browser() -> Iterator[Browser]:
    """A browser with an empty profile, which is removed afterward."""
    binary = next(filter(None, map(shutil.which, BROWSERS)))
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile, _driver(Path(profile)) as port:
        options = {"binary": binary, "args": [*_FLAGS, f"--user-data-dir={profile}/user"]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        made = _asked("POST", f"http://127.0.0.1:{port}/session", {"capabilities": {"alwaysMatch": wanted}})
        session = Browser(port, made["sessionId"])
        try:
            yield session
        finally:
            session.close()


@contextlib.contextmanager
def _driver(folder: Path) -> Iterator[int]:
    """Start chromedriver on a free port."""
    log = folder / "driver.log"
    with log.open("wb") as output:
        # A group of its own, so that the browser ends with it.
        process = subprocess.Popen([DRIVER, "--port=0"], stdout=output, stderr=output, start_new_session=True)
    try:
        give_up = time.monotonic() + _SECONDS
        while "on port " not in (said := log.read_text().partition("started successfully")[2]):
            assert process.poll() is None, log.read_text()
            assert time.monotonic() < give_up, f"{DRIVER} does not start: {log.read_text()}"
            time.sleep(0.02)
        yield int("".join(filter(str.isdigit, said.partition("on port ")[2].splitlines()[0])))
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(_SECONDS)


def _asked(method: str, url: str, body: dict[str, Any] | None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(url, data, {"Content-Type": "application/json"}, method=method)
    try:
        # No proxy: the driver is on this machine.
        with urllib.request.build_opener(urllib.request.ProxyHandler({})).open(request, timeout=_SECONDS) as answer:
            return json.load(answer)["value"]
    except HTTPError as error:
        raise AssertionError(f"{method} {url}: {error.read().decode()[:500]}") from None
