"""Read Pascal VOC: `python voc.py ROWS.json DATASET OBJECTS.json IDS.npz MIN_VISIBILITY MIN_PIXELS`.

It runs in a Python of its own, which has Datumaro; nothing here is of usdsdg. Datumaro loads every part; the XML is
also read as torchvision reads it, and the lists as the development kit does, whose rules score the segments' boxes
against those of the XML. OBJECTS.json and IDS.npz have what was there: see `records.record`.
"""

import json
import sys
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from heard import listening, row
from PIL import Image

# Fractions that decide a flag, and are this near to its limit, may have been rounded to the other side.
ROUNDING = 1e-5
FLAGS = {"occluded": ("hidden", 0.05), "truncated": ("outside", 0.15)}


def main() -> None:
    where, dataset, objects, ids, visibility, pixels = sys.argv[1:]
    root, expected, images = Path(dataset), json.loads(Path(objects).read_text()), np.load(ids)
    expected = {Path(name).stem: each for name, each in expected.items()}
    images = {Path(name).stem: images[name] for name in images.files}
    with listening() as texts:
        rows = [*by_datumaro(root, expected, images)]
    rows.append(row(texts, "Datumaro"))
    found = {path.stem: parsed(path) for path in sorted((root / "Annotations").glob("*.xml"))}
    rows.append(by_torchvision(root, found, expected, float(visibility), int(pixels)))
    rows += lists(root, found)
    rows.append(palettes(root, images))
    rows += scores(root, found)
    Path(where).write_text(json.dumps(rows))


def by_datumaro(root: Path, expected: dict, images: dict) -> list:
    """Compare names, boxes and masks of its annotations with what was there, and its pictures with the files."""
    from datumaro.components.annotation import AnnotationType
    from datumaro.components.dataset import Dataset

    loaded = Dataset.import_from(str(root), "voc", coordinate_mode="voc-one-based")
    names = [each.name for each in loaded.categories()[AnnotationType.label]]
    boxes = masks = wrong = items = 0
    for item in loaded:
        items += 1
        wanted, ids = expected[item.id], images[item.id]
        wrong += item.media.data.shape[:2] != ids.shape
        own = [each for each in item.annotations if each.type == AnnotationType.bbox]
        wrong += len(own) != len(wanted)
        for each, other in zip(own, wanted):
            left, top, right, bottom = other["box"]
            boxes += 1
            wrong += [each.x, each.y, each.w, each.h] != [left, top, right + 1 - left, bottom + 1 - top]
            wrong += names[each.label] != other["name"]
        own = {each.group: each for each in item.annotations if each.type == AnnotationType.mask and each.group}
        wrong += sorted(own) != list(range(1, len(wanted) + 1))
        for place, each in own.items():
            masks += 1
            wrong += names[each.label] != wanted[place - 1]["name"] or not np.array_equal(each.image, ids == place)
        own = {names[each.label] for each in item.annotations if each.type == AnnotationType.label}
        easy = {
            names[each.label]
            for each in item.annotations
            if each.type == AnnotationType.bbox and not each.attributes["difficult"]
        }
        wrong += own != easy
    text = f"{items} of {len(expected)} pictures, {boxes} boxes, {masks} masks; {wrong} different"
    yield ["Datumaro: names, boxes, masks, classes of lists", text, items == len(expected) and boxes > 0 and not wrong]


def parsed(path: Path) -> dict:
    """Return an annotation as torchvision's VOCDetection does."""

    def parse(node: ElementTree.Element) -> dict:
        children = list(node)
        if not children:
            return {node.tag: (node.text or "").strip()}
        collected = defaultdict(list)
        for each in map(parse, children):
            for key, value in each.items():
                collected[key].append(value)
        if node.tag == "annotation":
            collected["object"] = [collected["object"]]
        return {node.tag: {key: value[0] if len(value) == 1 else value for key, value in collected.items()}}

    return parse(ElementTree.parse(path).getroot())["annotation"]


def by_torchvision(root: Path, found: dict, expected: dict, visibility: float, pixels: int) -> list:
    """Compare every value of the XML with what was there."""
    wrong, objects, raised = [], 0, dict.fromkeys((*FLAGS, "difficult"), 0)
    for stem, values in found.items():
        with Image.open(root / "JPEGImages" / values["filename"]) as picture:
            size = [str(each) for each in picture.size]
            is_right = size == [values["size"]["width"], values["size"]["height"]] and picture.mode == "RGB"
        is_right &= values["size"]["depth"] == "3" and values["segmented"] == "1"
        is_right &= len(values["object"]) == len(expected[stem])
        for each, other in zip(values["object"], expected[stem]):
            objects += 1
            sides = [int(each["bndbox"][side]) - 1 for side in ("xmin", "ymin", "xmax", "ymax")]
            is_right &= each["name"] == other["name"] and sides == other["box"]
            for flag, (fraction, limit) in FLAGS.items():
                raised[flag] += int(each[flag])
                is_right &= abs(other[fraction] - limit) < ROUNDING or int(each[flag]) == (other[fraction] > limit)
            hard = 1.0 - other["hidden"] < visibility - ROUNDING or other["pixels"] < pixels
            raised["difficult"] += hard
            is_right &= int(each["difficult"]) == hard
        wrong += [] if is_right else [stem]
    shown = ", ".join(f"{count} {flag}" for flag, count in raised.items())
    text = f"{len(found)} of {len(expected)} pictures, {objects} objects, {shown}; different: {wrong[:3] or 'none'}"
    enough = set(found) == set(expected) and all(raised[flag] for flag in FLAGS)
    return ["torchvision's reading of the XML", text, enough and not wrong]


def lists(root: Path, found: dict) -> list:
    """Read the lists as the development kit does: names, and 1, 0 or -1 for a class."""
    main, segments = root / "ImageSets/Main", root / "ImageSets/Segmentation"
    parts = {part: (main / f"{part}.txt").read_text().split() for part in ("train", "val")}
    every = [stem for each in parts.values() for stem in each]
    rows = [
        ["pictures of parts", str({part: len(each) for part, each in parts.items()}), sorted(every) == sorted(found)]
    ]
    wrong = [part for part, each in parts.items() if (segments / f"{part}.txt").read_text().split() != each]
    classes = {each["name"] for values in found.values() for each in values["object"]}
    for part, stems in parts.items():
        for name in classes:
            said = dict(line.split() for line in (main / f"{name}_{part}.txt").read_text().splitlines())
            for stem in stems:
                hard = [each["difficult"] == "1" for each in found[stem]["object"] if each["name"] == name]
                if said[stem] != ("-1" if not hard else "0" if all(hard) else "1"):
                    wrong.append(f"{name}_{part} of {stem}")
    return [*rows, ["lists of classes", f"{len(classes)} classes; different: {wrong[:3] or 'none'}", not wrong]]


def palettes(root: Path, images: dict) -> list:
    """Look at the colors of indices, which are those of VOClabelcolormap.m, and at the objects of pixels."""
    colors = np.zeros((256, 3), int)
    for index in range(256):
        for bit in range(8):
            for channel in range(3):
                colors[index, channel] |= (index >> (3 * bit + channel) & 1) << (7 - bit)
    wrong = []
    for stem, ids in images.items():
        for kind in ("SegmentationClass", "SegmentationObject"):
            with Image.open(root / kind / f"{stem}.png") as picture:
                own = np.array(picture)
                is_right = picture.mode == "P" and picture.getpalette() == colors.ravel().tolist()
            is_right &= ((own > 0) == (ids > 0)).all() if kind == "SegmentationClass" else (own == ids).all()
            wrong += [] if is_right else [f"{kind}/{stem}"]
    return [
        "colors of indices, and pixels of objects",
        f"{2 * len(images)} pictures; {wrong[:3] or 'none'} wrong",
        not wrong,
    ]


def scores(root: Path, found: dict) -> list:
    """Score the extents of the segments as detections, class by class, as VOCevaldet.m does."""
    rows = []
    for part in ("train", "val"):
        stems = (root / f"ImageSets/Main/{part}.txt").read_text().split()
        precisions = {}
        for name in sorted({each["name"] for stem in stems for each in found[stem]["object"]}):
            truth = {stem: [each for each in found[stem]["object"] if each["name"] == name] for stem in stems}
            detections = [(stem, box) for stem in stems for box in extents(root, stem, found[stem]["object"], name)]
            precisions[name] = average_precision(truth, detections)
        text = ", ".join(f"{name} {value:.4f}" for name, value in precisions.items())
        rows.append([f"VOCevaldet: AP of the segments of {part}", text, bool(text) and min(precisions.values()) == 1.0])
    return rows


def extents(root: Path, stem: str, objects: list, name: str) -> list:
    """Return the boxes, counted from 1, of a class's segments in SegmentationObject."""
    ids = np.array(Image.open(root / f"SegmentationObject/{stem}.png"))
    boxes = []
    for place, each in enumerate(objects, 1):
        if each["name"] == name:
            rows, columns = np.nonzero(ids == place)
            boxes.append([columns.min() + 1, rows.min() + 1, columns.max() + 1, rows.max() + 1])
    return boxes


def average_precision(truth: dict, detections: list) -> float:
    """Return the average precision of detections, all equally sure; difficult objects count neither way."""
    sides = ("xmin", "ymin", "xmax", "ymax")
    boxes = {stem: np.array([[float(o["bndbox"][s]) for s in sides] for o in own]) for stem, own in truth.items()}
    hard = {stem: [o["difficult"] == "1" for o in own] for stem, own in truth.items()}
    taken = {stem: [False] * len(own) for stem, own in truth.items()}
    wanted = sum(not each for own in hard.values() for each in own)
    hits, misses = [], []
    for stem, box in detections:
        own = boxes[stem]
        width = np.minimum(own[:, 2], box[2]) - np.maximum(own[:, 0], box[0]) + 1
        height = np.minimum(own[:, 3], box[3]) - np.maximum(own[:, 1], box[1]) + 1
        common = np.clip(width, 0, None) * np.clip(height, 0, None)
        area = (own[:, 2] - own[:, 0] + 1) * (own[:, 3] - own[:, 1] + 1)
        overlap = common / (area + (box[2] - box[0] + 1) * (box[3] - box[1] + 1) - common)
        # Of equal ones the first that is not taken: two objects may have one box.
        best = max(range(len(own)), key=lambda place: (overlap[place], not taken[stem][place]))
        if overlap[best] >= 0.5 and hard[stem][best]:
            continue
        is_hit = overlap[best] >= 0.5 and not taken[stem][best]
        taken[stem][best] |= is_hit
        hits.append(is_hit)
        misses.append(not is_hit)
    if not wanted:
        return 1.0
    recall = np.cumsum(hits) / wanted
    precision = np.cumsum(hits) / (np.cumsum(hits) + np.cumsum(misses))
    recall, precision = np.concatenate([[0], recall, [1]]), np.concatenate([[0], precision, [0]])
    precision = np.maximum.accumulate(precision[::-1])[::-1]
    steps = np.flatnonzero(recall[1:] != recall[:-1]) + 1
    return float(((recall[steps] - recall[steps - 1]) * precision[steps]).sum())


if __name__ == "__main__":
    main()
