"""A client of the viewer without a browser: sends requests, and keeps the messages and pictures that it receives."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.view.channel import Channel
from usdsdg.view.viewer import Viewer

SECONDS = 120.0


class Page:
    """A page of a viewer that runs in this thread."""

    def __init__(self, viewer: Viewer, width: int = 64, height: int = 48, mode: str = "instances") -> None:
        self._viewer = viewer
        self.channel = Channel(viewer.wake)
        self.values: dict[str, Any] = {}
        self.errors: list[str] = []
        self.pictures: list[tuple[dict[str, Any], np.ndarray]] = []
        self.cameras: dict[str, np.ndarray] = {}
        viewer.opened(self.channel)
        self.ask(do="size", width=width, height=height)
        self.ask(do="mode", name=mode)

    def ask(self, **wish: Any) -> None:
        """Ask for something."""
        self.channel.ask(json.dumps(wish))

    def receive(self) -> None:
        """Take what the viewer has sent, and answer its pictures."""
        for message in self.channel.outgoing():
            if isinstance(message, str):
                values = json.loads(message)
                if "error" in values:
                    self.errors.append(values.pop("error"))
                self.values |= values
                continue
            length = int.from_bytes(message[:4], "big")
            header = json.loads(message[4 : 4 + length])
            image = np.asarray(Image.open(io.BytesIO(message[4 + length :])).convert("RGB"))
            if "camera" in header:
                self.cameras[header["camera"]] = image
            else:
                self.pictures.append((header, image))
            self.ask(do="shown")

    def until(self, condition: Callable[[], Any], **options: Any) -> None:
        """Let the viewer run until a condition holds."""
        give_up = time.monotonic() + SECONDS

        def holds() -> bool:
            self.receive()
            assert time.monotonic() < give_up, f"never true; errors: {self.errors}"
            return bool(condition())

        self._viewer.run(until=holds, **options)

    def picture(self, **wish: Any) -> np.ndarray:
        """Ask for something, and return the first picture drawn after it."""
        if wish:
            self.ask(**wish)
        before, selection = len(self.pictures), self.channel
        assert selection.is_open
        self.until(lambda: len(self.pictures) > before)
        return self.pictures[-1][1]
