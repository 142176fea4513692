"""Read CVAT for images 1.1: `python cvat.py ROWS.json DATASET OBJECTS.json IDS.npz MIN_VISIBILITY MIN_PIXELS`.

It runs in a Python of its own, which has Datumaro; nothing here is of usdsdg. Datumaro loads the XML, which is also
read as CVAT's own import does; labels are compared with those that the task would have. OBJECTS.json and IDS.npz
have what was there: see `records.record`.
"""

import json
import sys
from pathlib import Path
from xml.etree import ElementTree

import cv2
import numpy as np
from heard import listening, row
from PIL import Image

# Fractions that decide a flag, and are this near to its limit, may have been rounded to the other side.
ROUNDING = 1e-5
OCCLUDED = 0.05


def main() -> None:
    where, dataset, objects, ids, visibility, pixels = sys.argv[1:]
    root, images, expected = Path(dataset), np.load(ids), {}
    for name, listed in json.loads(Path(objects).read_text()).items():
        enough = [
            (place, each)
            for place, each in enumerate(listed, 1)
            if 1.0 - each["hidden"] >= float(visibility) - ROUNDING and each["pixels"] >= int(pixels)
        ]
        expected[Path(name).name] = [(each, images[name] == place) for place, each in enough]
    with listening() as texts:
        rows = [by_datumaro(root, expected)]
    rows.append(row(texts, "Datumaro"))
    rows += by_import(root, expected)
    Path(where).write_text(json.dumps(rows))


def by_datumaro(root: Path, expected: dict) -> list:
    """Compare the shapes, their labels and attributes with what was there."""
    from datumaro.components.annotation import AnnotationType
    from datumaro.components.dataset import Dataset

    loaded = Dataset.import_from(str(root / "annotations.xml"), "cvat")
    names = [each.name for each in loaded.categories()[AnnotationType.label]]
    items, shapes, wrong = 0, dict.fromkeys(("bbox", "polygon", "mask"), 0), []
    for item in loaded:
        items += 1
        wanted = expected[Path(item.media.path).name]
        found: dict = {}
        for each in item.annotations:
            shapes[each.type.name] += 1
            found.setdefault(int(each.attributes["instance"]), []).append(each)
        is_right = item.media.data.shape[:2] == item.media.size and len(found) == len(wanted)
        for other, mask in wanted:
            own = found.get(other["instance"], [])
            is_right &= bool(own) and {names[each.label] for each in own} == {other["name"]}
            is_right &= abs(other["hidden"] - OCCLUDED) < ROUNDING or {each.attributes["occluded"] for each in own} == {
                other["hidden"] > OCCLUDED
            }
            is_right &= bool(own) and is_shape_of(own, other["box"], mask)
            is_right &= len({each.group for each in own}) == 1 and (len(own) == 1 or own[0].group > 0)
        wrong += [] if is_right else [item.id]
    text = f"{items} of {len(expected)} pictures, {shapes}; different: {wrong[:3] or 'none'}"
    return ["Datumaro: labels, shapes, groups, attributes", text, items == len(expected) and not wrong]


def is_shape_of(own: list, box: list, mask: np.ndarray) -> bool:
    """Compare the shapes of one object with its box and its mask."""
    from datumaro.components.annotation import AnnotationType
    from pycocotools import mask as masks

    left, top, right, bottom = box
    if own[0].type == AnnotationType.bbox:
        (each,) = own
        return [each.x, each.y, each.w, each.h] == [left, top, right + 1 - left, bottom + 1 - top]
    if own[0].type == AnnotationType.mask:
        return len(own) == 1 and np.array_equal(own[0].image, mask)
    parts = masks.frPyObjects([each.points for each in own], *mask.shape)
    # A polygon is an outline: its holes are filled, which pixels that touch at a corner do not close.
    around = np.pad(mask.astype(np.uint8), 1)
    cv2.floodFill(around, None, (0, 0), 2, flags=8)
    return np.array_equal(masks.decode(masks.merge(parts)), around[1:-1, 1:-1] < 2)


def by_import(root: Path, expected: dict) -> list:
    """Read the XML as CVAT's import does: frames by their names, runs along the rows of a mask's rectangle."""
    tree = ElementTree.parse(root / "annotations.xml").getroot()
    images = tree.findall("image")
    names = [each.get("name") for each in images]
    labels = {each["name"]: each for each in json.loads((root / "labels.json").read_text())}
    rows = [["pictures by name and by number", f"{len(names)}", names == sorted(expected)]]
    rows[0][2] &= [each.get("id") for each in images] == [str(number) for number in range(len(images))]
    wrong, shapes = [], 0
    for image in images:
        with Image.open(root / "images" / image.get("name")) as picture:
            size = [str(each) for each in picture.size]
        is_right = size == [image.get("width"), image.get("height")]
        by_instance = {each["instance"]: (each, mask) for each, mask in expected[image.get("name")]}
        for shape in image:
            shapes += 1
            values = {each.get("name"): each.text for each in shape.iter("attribute")}
            is_right &= shape.get("label") in labels and shape.get("occluded") in ("0", "1")
            is_right &= set(values) == {each["name"] for each in labels[shape.get("label")]["attributes"]}
            other, mask = by_instance.get(int(values["instance"]), (None, None))
            is_right &= other is not None and (shape.tag != "mask" or np.array_equal(decoded(shape, mask.shape), mask))
        wrong += [] if is_right else [image.get("name")]
    task = [each.text for each in tree.iterfind("meta/task/labels/label/name")]
    text = f"{shapes} shapes, {len(labels)} labels; different: {wrong[:3] or 'none'}"
    return [*rows, ["CVAT's import of the XML and of labels.json", text, task == list(labels) and shapes and not wrong]]


def decoded(shape: ElementTree.Element, size: tuple) -> np.ndarray:
    """Return the pixels of a mask, (H, W) bool."""
    left, top, width, height = (int(shape.get(name)) for name in ("left", "top", "width", "height"))
    pixels, value = [], False
    for length in map(int, shape.get("rle").split(",")):
        pixels += [value] * length
        value = not value
    whole = np.zeros(size, bool)
    whole[top : top + height, left : left + width] = np.array(pixels).reshape(height, width)
    return whole


if __name__ == "__main__":
    main()
