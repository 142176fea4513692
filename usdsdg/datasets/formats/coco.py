"""Reader of COCO datasets: the JSON of all images, and the images that it names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import PurePosixPath
from typing import Any

import numpy as np

from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import classes_of, truth_of
from usdsdg.datasets.polygons import filled
from usdsdg.datasets.seen import Mask, Masks, Seen, Segments
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.coco.coco_categories import OTHER, Categories
from usdsdg.writers.formats.coco.files import ImageFiles, Names, PlainNames, names_of

NAME = "CocoWriter"
_BOXES = "bounding_box_2d_tight_fast"


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what each JSON says about each of its images."""
    for file in files:
        names = names_of(file)
        values = None if names is None else folder.mapping(file, "all")
        if names is None or values is None:
            continue
        tables = folder.parsed(file, "all", lambda f=file, n=names, v=values: _Tables(folder, f, n, v))
        if tables is not None:
            yield from _images(folder, tables)


def _images(folder: Folder, tables: _Tables) -> Iterator[Seen]:
    for image in tables.images:
        seen = folder.parsed(tables.file, str(image.get("id")), lambda i=image: _image(folder, tables, i))
        if seen is not None:
            yield seen


class _Tables:
    """The sections of a JSON, and those of the panoptic one where there is one."""

    def __init__(self, folder: Folder, file: str, names: Names, values: Mapping[str, Any]) -> None:
        self.file, self.names, self.images = file, names, values["images"]
        self.categories = {each["id"]: each for each in values["categories"]}
        self.by_image: dict[int, list[Mapping[str, Any]]] = {}
        for each in values["annotations"]:
            self.by_image.setdefault(each["image_id"], []).append(each)
        for number in sorted(set(self.by_image) - {each["id"] for each in self.images}):
            folder.faults.append(Fault(file, str(number), "annotations are of an image that is not in `images`"))
        _check_ids(folder, file, values, ("images", "annotations", "categories"))
        self.segments = self._segments(folder)

    def _segments(self, folder: Folder) -> dict[int, Mapping[str, Any]] | None:
        """Return the panoptic annotation of each image; None if there is no such file."""
        file = self.names.panoptic
        values = folder.mapping(file, "all") if folder.has(file) else None
        if values is None:
            return None
        _check_ids(folder, file, values, ("images", "categories"))
        self.panoptic_categories = {each["id"]: each for each in values["categories"]}
        found = {each["image_id"]: each for each in values["annotations"]}
        mine, theirs = ({each["id"] for each in images} for images in (self.images, values["images"]))
        if mine != theirs or mine != set(found):
            folder.faults.append(
                Fault(file, "all", f"has not the images of {self.file}", str(len(mine)), f"{len(theirs)}, {len(found)}")
            )
        for what, own in (("image", values["images"]), ("category", values["categories"])):
            known = self.categories if what == "category" else {each["id"]: each for each in self.images}
            for each in own:
                _compare(folder, file, f"{what} {each['id']}", each, known.get(each["id"], {}), self.file)
        return found


def _check_ids(folder: Folder, file: str, values: Mapping[str, Any], sections: tuple[str, ...]) -> None:
    for name in sections:
        repeated = [number for number, count in Counter(each["id"] for each in values[name]).items() if count > 1]
        if repeated:
            folder.faults.append(Fault(file, "all", f"several of `{name}` have one id", "", _listed(repeated)))


def _compare(
    folder: Folder, file: str, what: str, values: Mapping[str, Any], others: Mapping[str, Any], other_file: str
) -> None:
    """Values that both files have of an image or a category are the same."""
    wrong = {key: value for key, value in values.items() if key in others and others[key] != value}
    if wrong:
        expected = str({key: others[key] for key in wrong})
        folder.faults.append(Fault(file, "all", f"{what} is not as in {other_file}", expected, str(wrong)))


def _listed(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers[:8])) + (", ..." if len(numbers) > 8 else "")


def _image(folder: Folder, tables: _Tables, image: Mapping[str, Any]) -> Seen:
    files = tables.names.image(image["file_name"])
    path, is_plain = PurePosixPath(files.picture), isinstance(tables.names, PlainNames)
    mine = [files.picture, *([files.classes] if files.classes else [])]
    mine += [files.panoptic] if tables.segments is not None else []
    # Of several products the name is before the number.
    view = path.stem.rpartition("_")[0] if is_plain else str(path.parent)
    name = path.relative_to(path.parents[1]).with_suffix("").as_posix() if is_plain else path.stem
    seen = Seen(NAME, name, "", mine, truth_of(folder, mine, view))
    seen.size = (int(image["width"]), int(image["height"]))
    masks = [_mask(each, seen.size) for each in tables.by_image.get(image["id"], [])]
    seen.picture, seen.labels = files.picture, tables.file
    key = seen.truth.filter_of(_BOXES) if seen.truth else ""
    own = _own(folder, seen, tables, is_plain)
    by_class = is_plain and seen.truth is not None and not seen.truth.record.parameters.get("coco_categories")
    seen.masks.append(
        Masks(tables.file, image, masks, tables.categories, own, key, things_only=is_plain, by_class=by_class)
    )
    seen.later(lambda made: _read_images(folder, made, tables, files))
    return seen


def _read_images(folder: Folder, seen: Seen, tables: _Tables, files: ImageFiles) -> None:
    read_color(folder, seen, files.picture)
    drawn = folder.image(files.classes, seen.name) if files.classes and folder.has(files.classes) else None
    if drawn is not None:
        seen.extra["panoptic"] = (files.classes, drawn)
    record = (tables.segments or {}).get(seen.masks[0].image["id"])
    if record is not None:
        seen.segments += _segments(folder, seen, tables, files, record)


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the annotations, with polygons and keypoints."""
    return [_object(each, masks) for masks in seen.masks for each in masks.masks]


def _object(mask: Mask, masks: Masks) -> SeenObject:
    x, y, width, height = mask.box
    name = masks.categories.get(mask.category, {}).get("name", mask.category)
    points = np.array(mask.keypoints[0]).reshape(-1, 3) if mask.keypoints else None
    box = (x, y, x + width, y + height)
    if mask.polygons:
        return SeenObject(str(name), box=box, outline=mask.polygons, keypoints=points)
    return SeenObject(str(name), box=box, mask=lambda _: mask.mask, keypoints=points)


def _segments(
    folder: Folder, seen: Seen, tables: _Tables, files: ImageFiles, record: Mapping[str, Any]
) -> Iterator[Segments]:
    image, file = folder.image(files.panoptic, seen.name), tables.names.panoptic
    if record["file_name"] != files.panoptic_name:
        folder.faults.append(
            Fault(file, seen.name, "names another picture", files.panoptic_name, str(record["file_name"]))
        )
    if image is not None and image.ndim == 3:
        channels = image.astype(np.int64)
        ids = channels[..., 0] + 256 * channels[..., 1] + 256**2 * channels[..., 2]
        yield Segments(file, files.panoptic, ids, record["segments_info"], tables.panoptic_categories)
    elif image is not None:
        folder.faults.append(Fault(files.panoptic, seen.name, "has three channels", "3", "1"))


def _own(folder: Folder, seen: Seen, tables: _Tables, is_plain: bool) -> Mapping[str, Mapping[str, Any]]:
    """Return the categories by label: the user's own, else the classes of the dataset, else COCO's.

    A table of the user's has the file's "other" where it has none of that name.
    """
    if seen.truth is None:
        return {str(each["name"]): each for each in tables.categories.values()}
    record = seen.truth.record
    if record.parameters.get("coco_categories"):
        return _other(tables) | record.parameters["coco_categories"]
    if is_plain:
        listed = classes_of(folder, seen.truth.filter_of(_BOXES)) or []
        # Of several classes of one name, the category is the first.
        return {row["name"]: {key: row[key] for key in ("name", "id")} | _color(row) for row in reversed(listed)}
    if record.semantic_classes:
        return _other(tables) | {name: {"name": name, "id": number} for name, number in record.semantic_classes.items()}
    return {each["name"]: each for each in Categories(None).all()}


def _color(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the color of a class as a category has it."""
    return {"color": row["color"][:3]} if "color" in row else {}


def _other(tables: _Tables) -> dict[str, Mapping[str, Any]]:
    """Return the file's category of objects that the user's table has none for; empty if no object is one."""
    found = [each for each in tables.categories.values() if each["name"] == OTHER]
    return {OTHER: found[0]} if found else {}


def _mask(values: Mapping[str, Any], size: tuple[int, int]) -> Mask:
    x, y, width, height = (float(each) for each in values["bbox"])
    encoded, points = values["segmentation"], None
    if "keypoints" in values:
        points = ([float(each) for each in values["keypoints"]], int(values["num_keypoints"]))
    polygons = [np.array(each, np.float64).reshape(-1, 2) for each in encoded] if isinstance(encoded, list) else []
    return Mask(
        int(values["id"]), int(values["category_id"]), (x, y, width, height), float(values["area"]),
        lambda: _decoded(encoded, polygons, size), not isinstance(encoded, list), polygons, points, values["iscrowd"],
    )  # fmt: skip


def _decoded(encoded: Any, polygons: list[np.ndarray], size: tuple[int, int]) -> np.ndarray | None:
    try:
        return _inside(polygons, size) if isinstance(encoded, list) else decoded(encoded["counts"], encoded["size"])
    except (ValueError, IndexError, TypeError, KeyError):
        return None


def _inside(polygons: list[np.ndarray], size: tuple[int, int]) -> np.ndarray:
    """Return the pixels (H, W) inside of any polygon."""
    inside = np.zeros((size[1], size[0]), bool)
    for each in polygons:
        inside |= filled(each, (size[1], size[0]))
    return inside


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
