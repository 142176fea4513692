"""Reader of CvatWriter's folders."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any
from xml.etree import ElementTree

import numpy as np

from usdsdg.datasets.color_images import read_color
from usdsdg.datasets.faults import Fault
from usdsdg.datasets.folder import Folder
from usdsdg.datasets.matching import truth_of
from usdsdg.datasets.polygons import filled
from usdsdg.datasets.seen import Labeled, Seen
from usdsdg.datasets.seen_object import SeenObject
from usdsdg.writers.formats.cvat.cvat_xml import INSTANCE
from usdsdg.writers.formats.cvat.files import ANNOTATIONS, LABELS, NAME, PICTURES

_SHAPES = ("box", "polygon", "mask")


def read(folder: Folder, files: list[str]) -> Iterator[Seen]:
    """Yield what the XML says of each picture."""
    if ANNOTATIONS not in files or LABELS not in files:
        return
    root = folder.binary(ANNOTATIONS, "all", ElementTree.fromstring)
    if root is None:
        return
    images = root.findall("image")
    names = [each.text or "" for each in root.iterfind("meta/task/labels/label/name")]
    size = root.findtext("meta/task/size")
    if size != str(len(images)):
        folder.faults.append(Fault(ANNOTATIONS, "all", "the size of the task", str(len(images)), str(size)))
    listed_labels = folder.rows(LABELS, "all") or []
    raw = folder.parsed(LABELS, "all", lambda: [each.get("name") for each in listed_labels]) or []
    if raw != names:
        folder.faults.append(Fault(LABELS, "all", f"labels are those of {ANNOTATIONS}", str(names), str(raw)))
    else:
        _compare_labels(folder, root, listed_labels)
    numbers = [each.get("id") for each in sorted(images, key=lambda each: str(each.get("name")))]
    if numbers != [str(number) for number in range(len(images))]:
        what = "pictures are numbered in the order of their names, as CVAT does"
        folder.faults.append(Fault(ANNOTATIONS, "all", what, "", ", ".join(map(str, numbers[:8]))))
    listed = {f"{PICTURES}/{each.get('name')}" for each in images}
    for file in sorted({file for file in files if file.startswith(f"{PICTURES}/")} - listed):
        folder.faults.append(Fault(ANNOTATIONS, "all", f"does not name {file}"))
    for image in images:
        seen = folder.parsed(ANNOTATIONS, str(image.get("name")), lambda i=image: _seen(folder, i, names))
        if seen is not None:
            yield seen


def _compare_labels(folder: Folder, root: ElementTree.Element, listed: list[Any]) -> None:
    """Note the labels whose color or attribute is another one in labels.json than in the XML."""
    for each, label in zip(listed, root.iterfind("meta/task/labels/label"), strict=True):
        attribute = label.find("attributes/attribute")
        described = {} if attribute is None else {part.tag: part.text or "" for part in attribute}
        expected = {
            "name": each["name"],
            "color": label.findtext("color"),
            "attributes": [
                {
                    "name": described.get("name"),
                    "input_type": described.get("input_type"),
                    "mutable": described.get("mutable") == "True",
                    "values": [described.get("values")],
                }
            ],
        }
        if each != expected:
            what = f"the label {each['name']} is as in {ANNOTATIONS}"
            folder.faults.append(Fault(LABELS, "all", what, str(expected), str(each)))


def _seen(folder: Folder, image: ElementTree.Element, names: list[str]) -> Seen:
    path = f"{PICTURES}/{image.attrib['name']}"
    view, _, number = PurePosixPath(path).stem.rpartition("_")
    seen = Seen(NAME, number, view, [path], truth_of(folder, [path], view))
    seen.size, seen.picture = (int(image.attrib["width"]), int(image.attrib["height"])), path
    seen.labels, seen.extra["labels"] = ANNOTATIONS, names
    polygons: dict[str, list[ElementTree.Element]] = {}
    for each in image:
        if each.tag not in _SHAPES:
            raise ValueError(f"there is a shape {each.tag}, which is not written")
        if each.tag == "polygon":
            polygons.setdefault(_instance(each), []).append(each)
        else:
            seen.labeled.append(_labeled(each, _whole(each, seen.size)))
    for parts in polygons.values():
        seen.labeled.append(_labeled(parts[0], _joined(parts, seen.size)))
    seen.later(lambda made: read_color(folder, made, made.picture))
    return seen


def _labeled(
    shape: ElementTree.Element, pixels: tuple[tuple[float, float, float, float], np.ndarray | None]
) -> Labeled:
    box, mask = pixels
    flags = {"occluded": {"0": False, "1": True}[shape.attrib["occluded"]]}
    return Labeled(shape.attrib["label"], box, mask, shape.tag != "polygon", flags, int(_instance(shape)))


def _instance(shape: ElementTree.Element) -> str:
    found = next((each.text for each in shape if each.get("name") == INSTANCE), None)
    if found is None:
        raise KeyError(INSTANCE)
    return found


def _whole(
    shape: ElementTree.Element, size: tuple[int, int]
) -> tuple[tuple[float, float, float, float], np.ndarray | None]:
    """Return the edges and the pixels of a box or a mask."""
    if shape.tag == "box":
        left, top, right, bottom = (float(shape.attrib[name]) for name in ("xtl", "ytl", "xbr", "ybr"))
        return (left, top, right, bottom), None
    left, top, width, height = (int(shape.attrib[name]) for name in ("left", "top", "width", "height"))
    lengths = [int(each) for each in shape.attrib["rle"].split(",")]
    if sum(lengths) != width * height:
        raise ValueError(f"the run lengths of a mask add up to {sum(lengths)}, not {width} x {height} pixels")
    mask = np.zeros((size[1], size[0]), bool)
    inside = np.repeat(np.arange(len(lengths)) % 2 == 1, lengths).reshape(height, width)
    mask[top : top + height, left : left + width] = inside
    return (float(left), float(top), float(left + width), float(top + height)), mask


def _joined(
    parts: list[ElementTree.Element], size: tuple[int, int]
) -> tuple[tuple[float, float, float, float], np.ndarray]:
    """Return the edges and the pixels of the polygons of one object."""
    corners = [
        np.array([pair.split(",") for pair in each.attrib["points"].split(";")], np.float64).reshape(-1, 2)
        for each in parts
    ]
    groups = {each.get("group_id") for each in parts}
    if len(parts) > 1 and (len(groups) != 1 or None in groups):
        raise ValueError(f"the parts of instance {_instance(parts[0])} are not one group")
    mask = np.zeros((size[1], size[0]), bool)
    for each in corners:
        mask |= filled(each, (size[1], size[0]))
    low, high = (getattr(np.concatenate(corners), end)(axis=0) for end in ("min", "max"))
    return (float(low[0]), float(low[1]), float(high[0]), float(high[1])), mask


def objects(seen: Seen) -> list[SeenObject]:
    """Return the objects of the shapes, with their masks."""
    return [_object(each) for each in seen.labeled]


def _object(labeled: Labeled) -> SeenObject:
    return SeenObject(labeled.name, box=labeled.box, mask=None if labeled.mask is None else lambda _: labeled.mask)
