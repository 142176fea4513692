"""The lists of pictures of a Pascal VOC dataset: those of a part, and which of them show a class."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.formats.growing_files import GrowingFiles
from usdsdg.writers.formats.voc import files
from usdsdg.writers.formats.voc.voc_xml import VocObject

SHOWN, NOT_SHOWN, ONLY_DIFFICULT = 1, -1, 0


class ImageSets(GrowingFiles):
    """Lists with a name in each line; those of a class also have 1, -1 or, if all its objects are difficult, 0."""

    def __init__(self, backend: BaseBackend, splits: Sequence[str], classes: Callable[[], Sequence[str]]) -> None:
        """splits: names of the parts. classes: returns those of the dataset so far."""
        super().__init__(backend)
        self._classes = classes
        self._rows: dict[str, list[tuple[str, dict[str, int]]]] = {split: [] for split in splits}

    def add(self, split: str, stem: str, objects: Sequence[VocObject]) -> None:
        """Add a picture with its objects."""
        shown: dict[str, int] = {}
        for each in objects:
            shown[each.name] = max(shown.get(each.name, ONLY_DIFFICULT), ONLY_DIFFICULT if each.difficult else SHOWN)
        self._rows[split].append((stem, shown))
        self.grew()

    def texts(self) -> dict[str, str]:
        if not any(self._rows.values()):
            return {}
        found = {}
        for split, rows in self._rows.items():
            listed = "".join(f"{stem}\n" for stem, _ in rows)
            found |= {files.image_set(folder, split): listed for folder in (files.MAIN, files.SEGMENTATION)}
            for name in self._classes():
                lines = [f"{stem} {shown.get(name, NOT_SHOWN):2d}\n" for stem, shown in rows]
                found[files.image_set(files.MAIN, split, name)] = "".join(lines)
        return found
