"""The one JSON file of a COCO dataset, which grows with every picture."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import write_text
from usdsdg.writers.formats.coco_categories import Category

# It is written again after this many pictures, or when it has grown by this share: writing a file of n pictures so
# often costs a few times n, not n².
_PICTURES, _GROWTH = 25, 0.1


class CocoFile:
    """Images, annotations and categories in hand, of which the file has those of the last `write`."""

    def __init__(self, backend: BaseBackend, head: Mapping[str, Any]) -> None:
        """head: what stands before the images: info and licenses."""
        self._backend, self._head = backend, head
        self.path = ""
        self._images: list[str] = []
        self._annotations: list[str] = []
        self._categories: dict[int, Category] = {}
        self._written = -1  # how many images the file has

    def next_image_id(self) -> int:
        """Images are counted from 0."""
        return len(self._images)

    def next_annotation_id(self) -> int:
        """Annotations are counted from 1: COCO's own evaluation takes one with the id 0 for none."""
        return len(self._annotations) + 1

    def add(self, image: Mapping[str, Any], annotations: Sequence[Mapping[str, Any]], used: Sequence[Category]) -> None:
        """One picture, what is in it, and the categories of that; writes the file when it is time."""
        self._images.append(json.dumps(image))
        self._annotations += map(json.dumps, annotations)
        self._categories.update((category["id"], category) for category in used)
        count = len(self._images)
        if count == 1 or count - self._written >= max(_PICTURES, _GROWTH * self._written):
            self.write()

    def write(self) -> None:
        """Schedule the file, after the pictures that it names; it appears whole or stays as it was."""
        if self.path and self._written != len(self._images):
            self._backend.wait_until_done()
            self._backend.schedule(write_text, path=self.path, text=self._text())
            self._written = len(self._images)

    def _text(self) -> str:
        """JSON with a line for every record."""
        separator = ",\n"
        categories = [json.dumps(self._categories[number]) for number in sorted(self._categories)]
        tables = {"images": self._images, "annotations": self._annotations, "categories": categories}
        parts = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in self._head.items()]
        parts += [f'"{name}": [\n{separator.join(rows)}\n]' for name, rows in tables.items()]
        return "{\n" + separator.join(parts) + "\n}\n"
