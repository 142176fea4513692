"""Reading a page back: its values and its pictures."""

from __future__ import annotations

import base64
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from PIL import Image


class Page(HTMLParser):
    """`values` is the page's JSON, `image(i)` a picture as Pillow opens it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.text = path.read_text(encoding="utf-8")
        self.scripts: dict[str, str] = {}
        self.tags: list[tuple[str, dict[str, Any]]] = []
        self._open: str | None = None
        self.feed(self.text)
        self.values = json.loads(self.scripts["dataset"])

    def handle_starttag(self, tag: str, attrs: list) -> None:
        attributes = dict(attrs)
        self.tags.append((tag, attributes))
        if tag == "script":
            self._open = attributes.get("id", "code")
            self.scripts[self._open] = ""

    def handle_endtag(self, tag: str) -> None:
        if tag == "script":
            self._open = None

    def handle_data(self, data: str) -> None:
        if self._open:
            self.scripts[self._open] += data

    def image(self, number: int) -> Image.Image:
        match = re.fullmatch(r"data:image/(png|jpeg);base64,(.*)", self.scripts[f"i{number}"])
        assert match
        return Image.open(io.BytesIO(base64.b64decode(match[2])))

    def frame(self, name: str) -> dict[str, Any]:
        return next(frame for frame in self.values["frames"] if frame["name"] == name)

    def problems(self) -> dict[str, list[str]]:
        return {group["kind"]: [text for text, _ in group["list"]] for group in self.values["problems"]}
