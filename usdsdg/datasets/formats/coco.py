"""Reader of COCO datasets: the JSON of all images, and the images that it names."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.seen import Color, Mask, Masks, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.coco.coco_categories import Categories

NAME = "CocoWriter"
LOOKED_FOR = "CocoWriter's coco_annotations_0.json"
_FILE = re.compile(r"^coco_annotations_.+\.json$")


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what each JSON says about each of its images."""
    for file in files:
        if not _FILE.match(PurePosixPath(file).name):
            continue
        values = folder.json(file, "all")
        tables = None if values is None else folder.parsed(file, "all", lambda f=file, v=values: _Tables(folder, f, v))
        if tables is not None:
            yield from _images(folder, tables)


def _images(folder: Folder, tables: _Tables) -> Iterator[Seen]:
    for image in tables.images:
        seen = folder.parsed(tables.file, str(image.get("id")), lambda i=image: _image(folder, tables, i))
        if seen is not None:
            yield seen


class _Tables:
    """The sections of a JSON."""

    def __init__(self, folder: Folder, file: str, values: Mapping[str, Any]) -> None:
        self.file, self.images = file, values["images"]
        self.categories = {each["id"]: each for each in values["categories"]}
        self.by_image: dict[int, list[Mapping[str, Any]]] = {}
        for each in values["annotations"]:
            self.by_image.setdefault(each["image_id"], []).append(each)
        for number in sorted(set(self.by_image) - {each["id"] for each in self.images}):
            folder.faults.append(Fault(file, str(number), "annotations are of an image that is not in `images`"))
        for name in ("images", "annotations", "categories"):
            repeated = [number for number, count in Counter(each["id"] for each in values[name]).items() if count > 1]
            if repeated:
                folder.faults.append(Fault(file, "all", f"several of `{name}` have one id", "", _listed(repeated)))


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers[:8])) + (", ..." if len(numbers) > 8 else "")


def _image(folder: Folder, tables: _Tables, image: Mapping[str, Any]) -> Seen:
    path = PurePosixPath(image["file_name"])
    panoptic = str(path.with_name(path.name.replace("rgb_", "panoptic_", 1)).with_suffix(".png"))
    mine = [str(path), panoptic]
    seen = Seen(NAME, path.stem, "", mine, truth_of(folder, mine, str(path.parent)))
    seen.size = (int(image["width"]), int(image["height"]))
    masks = [_mask(each) for each in tables.by_image.get(image["id"], [])]
    seen.picture, seen.labels = str(path), tables.file
    seen.later(lambda made: _read_images(folder, made, panoptic))
    key = seen.truth.filter_of("bounding_box_2d_tight_fast") if seen.truth else ""
    seen.masks.append(Masks(tables.file, image, masks, tables.categories, _own(seen, tables), key))
    return seen


def _read_images(folder: Folder, seen: Seen, panoptic: str) -> None:
    color = folder.image(seen.picture, seen.name)
    if color is not None:
        seen.colors.append(Color(seen.picture, color, exact=seen.picture.lower().endswith(".png")))
    drawn = folder.image(panoptic, seen.name) if folder.has(panoptic) else None
    if drawn is not None:
        seen.extra["panoptic"] = (panoptic, drawn)


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the annotations."""
    return [_object(each, masks) for masks in seen.masks for each in masks.masks]


def _object(mask: Mask, masks: Masks) -> SeenObject:
    x, y, width, height = mask.box
    name = masks.categories.get(mask.category, {}).get("name", mask.category)
    return SeenObject(str(name), box=(x, y, x + width, y + height), mask=lambda _: mask.mask)


def _own(seen: Seen, tables: _Tables) -> Mapping[str, Mapping[str, Any]]:
    """Return the categories by label: the user's own, else the classes that the user has fixed, else COCO's."""
    if seen.truth is None:
        return {str(each["name"]): each for each in tables.categories.values()}
    record = seen.truth.record
    if record.parameters.get("coco_categories"):
        return record.parameters["coco_categories"]
    if record.semantic_classes:
        return {name: {"name": name, "id": number} for name, number in record.semantic_classes.items()}
    return {each["name"]: each for each in Categories(None).all()}


def _mask(values: Mapping[str, Any]) -> Mask:
    x, y, width, height = (float(each) for each in values["bbox"])
    number, category = int(values["id"]), int(values["category_id"])
    return Mask(number, category, (x, y, width, height), float(values["area"]), lambda: _decoded(values))


def _decoded(values: Mapping[str, Any]) -> np.ndarray | None:
    encoded = values["segmentation"]
    try:
        return decoded(encoded["counts"], tuple(encoded["size"]))
    except (ValueError, IndexError, TypeError):
        return None


def decoded(counts: str | list[int], size: tuple[int, int]) -> np.ndarray:
    """Return the mask (H, W) of COCO's run lengths, compressed as text or not: down the columns, first pixels outside.

    Raises:
        ValueError: they do not fill an image of this size.
    """
    lengths = counts if isinstance(counts, list) else _lengths(counts)
    if min(lengths, default=0) < 0 or sum(lengths) != size[0] * size[1]:
        raise ValueError(f"the run lengths add up to {sum(lengths)}, not {size[0]} x {size[1]} pixels")
    inside = np.arange(len(lengths)) % 2 == 1
    return np.repeat(inside, lengths).reshape(size[1], size[0]).T


def _lengths(text: str) -> list[int]:
    """Return the numbers of a compressed text: five bits a character, lowest first, with sign; from the fourth on they
    are differences from the one two before.
    """
    lengths: list[int] = []
    number = shift = 0
    for character in text:
        bits = ord(character) - 48
        number |= (bits & 31) << shift
        shift += 5
        if bits & 32:
            continue
        if bits & 16:
            number -= 1 << shift
        if len(lengths) > 2:
            number += lengths[-2]
        lengths.append(number)
        number = shift = 0
    if shift:
        raise ValueError("the run lengths are cut off")
    return lengths
