"""A JSON file of a COCO dataset, which grows with every image."""

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.formats.coco.coco_categories import Category
from usdsdg.writers.formats.growing_files import GrowingFiles


class CocoFile(GrowingFiles):
    """Images, annotations and categories collected so far."""

    def __init__(
        self,
        backend: BaseBackend,
        head: Callable[[], Mapping[str, Any]],
        categories: Callable[[], Sequence[Category]],
        path: str = "",
    ) -> None:
        """head: returns the sections before the images: info and licenses. categories: those of the dataset so far."""
        super().__init__(backend)
        self.path = path  # "" if it is not yet known
        self._head, self._categories = head, categories
        self._images: list[str] = []
        self._annotations: list[str] = []

    def add(self, image: Mapping[str, Any], annotations: Sequence[Mapping[str, Any]]) -> None:
        """Add an image with its annotations; write the file if it has grown enough."""
        self._images.append(json.dumps(image))
        self._annotations += map(json.dumps, annotations)
        self.grew()

    def texts(self) -> dict[str, str]:
        """Return the JSON text, with one line per record."""
        if not self.path:
            return {}
        separator = ",\n"
        categories = [json.dumps(category) for category in self._categories()]
        tables = {"images": self._images, "annotations": self._annotations, "categories": categories}
        parts = [f"{json.dumps(key)}: {json.dumps(value)}" for key, value in self._head().items()]
        parts += [f'"{name}": [\n{separator.join(rows)}\n]' for name, rows in tables.items()]
        return {self.path: "{\n" + separator.join(parts) + "\n}\n"}
