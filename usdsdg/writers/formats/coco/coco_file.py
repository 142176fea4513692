"""A JSON file of a COCO dataset, which grows with every image."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.files import write_text
from usdsdg.writers.formats.coco.coco_categories import Category

# The file is rewritten after this many new images, or after this relative growth: for n images the total cost is
# proportional to n, not n².
_IMAGES, _GROWTH = 25, 0.1


class CocoFile:
    """Images, annotations and categories collected so far; the file contains those up to the last `write`."""

    def __init__(
        self,
        backend: BaseBackend,
        head: Callable[[], Mapping[str, Any]],
        categories: Callable[[], Sequence[Category]],
        path: str = "",
    ) -> None:
        """head: returns the sections before the images: info and licenses. categories: those of the dataset so far."""
        self._backend, self._head, self._categories = backend, head, categories
        self.path = path
        self._images: list[str] = []
        self._annotations: list[str] = []
        self._written = -1  # number of images in the file

    def add(self, image: Mapping[str, Any], annotations: Sequence[Mapping[str, Any]]) -> None:
        """Add an image with its annotations; write the file if it has grown enough."""
        self._images.append(json.dumps(image))
        self._annotations += map(json.dumps, annotations)
        count = len(self._images)
        if count == 1 or count - self._written >= max(_IMAGES, _GROWTH * self._written):
            self.write()

    def write(self) -> None:
        """Schedule the file after the images that it names; it is replaced atomically."""
        if self.path and self._written != len(self._images):
            self._backend.schedule_after_all(write_text, path=self.path, text=self._text())
            self._written = len(self._images)

    def _text(self) -> str:
        """Return the JSON text, with one line per record."""
        separator = ",\n"
        categories = [json.dumps(category) for category in self._categories()]
        tables = {"images": self._images, "annotations": self._annotations, "categories": categories}
        parts = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in self._head().items()]
        parts += [f'"{name}": [\n{separator.join(rows)}\n]' for name, rows in tables.items()]
        return "{\n" + separator.join(parts) + "\n}\n"
