"""COCO: masks are a partition, boxes and areas are those of the masks, and categories are complete and right."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Mask, Masks, Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.verify.checks.compare import of_pixels
from usdsdg.writers.formats.shapes.polygons import without_holes

_OTHER = "other"
_OPTIONAL = ("supercategory", "isthing")  # of a category that the user gives
_BLACK_IS_FINE = ("unlabelled", "background")


class Coco:
    """Checks of all images of COCO files; the categories of each file are looked at once."""

    def __init__(self, classes: Mapping[str, Any] | None) -> None:
        self._seen: set[str] = set()
        self.pictures: set[str] = set()  # of the images that the files list
        self._classes = classes
        self._nothing: dict[int, list[int]] = {}  # color of what has no label, and of the background

    def check(self, seen: Seen) -> Faults:
        """Check one image and its annotations."""
        if seen.masks:
            self.pictures.add(seen.picture)
        for masks in seen.masks:
            if masks.file not in self._seen:
                self._seen.add(masks.file)
                yield from _categories(masks.file, masks.categories, masks, things_only=masks.things_only)
            for segments in seen.segments:
                if segments.file not in self._seen:
                    self._seen.add(segments.file)
                    yield from _categories(segments.file, segments.categories, masks, things_only=False)
            yield from _image(seen, masks)
            yield from _masks(seen, masks)
            yield from _things(seen, masks)
            yield from _panoptic(seen, masks)
            yield from self._rest_of_panoptic(seen, masks)

    def _rest_of_panoptic(self, seen: Seen, masks: Masks) -> Faults:
        """What has no label has one color in all images, and so has what was not hit."""
        members = seen.truth.members(masks.filter) if seen.truth else None
        if members is None or "panoptic" not in seen.extra:
            return
        file, image = seen.extra["panoptic"]
        for kind, name in ((-1, "what has no label"), (-2, "the background")):
            if image.ndim != 3 or image.shape[:2] != members.shape or not (members == kind).any():
                continue
            colors = np.unique(image[members == kind][:, :3], axis=0).tolist()
            first = self._nothing.setdefault(kind, colors[0])
            if colors != [first]:
                yield Fault(file, seen.name, f"{name} has one color", str(first), ", ".join(map(str, colors[:3])))


def _categories(file: str, categories: Mapping[int, Mapping[str, Any]], masks: Masks, *, things_only: bool) -> Faults:
    """Categories of a file are those that it must have, of things alone or all."""
    for number, category in categories.items():
        if list(category.get("color", ())) == [0, 0, 0] and category["name"] not in _BLACK_IS_FINE:
            yield Fault(file, "all", f"category {number}, {category['name']}, is black, as the background is")
    for label, each in masks.own.items():
        if things_only and not each.get("isthing", 1):
            continue
        found = categories.get(int(each["id"]))
        if found is None or found["name"] != each["name"]:
            yield Fault(
                file,
                "all",
                f"the category of {label}",
                f"{each['id']}: {each['name']}",
                "none" if found is None else str(found["name"]),
            )
            continue
        expected = {"supercategory": each["name"], "isthing": 1} | {key: each[key] for key in _OPTIONAL if key in each}
        if "color" in each:
            expected["color"] = [int(channel) for channel in each["color"]]
        for key, value in expected.items():
            if found.get(key) != value:
                yield Fault(file, "all", f"{key} of the category {found['name']}", str(value), str(found.get(key)))


def _image(seen: Seen, masks: Masks) -> Faults:
    for color in seen.colors:
        size = (color.image.shape[1], color.image.shape[0])
        if size != seen.size:
            yield Fault(masks.file, seen.name, f"width and height of {color.file}", str(size), str(seen.size))


def _masks(seen: Seen, masks: Masks) -> Faults:
    assert seen.size is not None
    covered = np.zeros((seen.size[1], seen.size[0]), np.int32)
    for each in masks.masks:
        name = f"annotation {each.number}"
        if each.category not in masks.categories:
            yield Fault(masks.file, seen.name, f"{name} is of category {each.category}, which is not listed")
        if each.crowd != 0:
            yield Fault(masks.file, seen.name, f"iscrowd of {name}", "0", str(each.crowd))
        if each.mask is None or each.mask.shape != covered.shape:
            size = "none" if each.mask is None else str(each.mask.shape[::-1])
            yield Fault(masks.file, seen.name, f"{name} has a mask of the image's size", str(seen.size), size)
            continue
        covered += each.mask & each.has_holes
        rows, columns = np.nonzero(each.mask)
        if not len(rows):
            yield Fault(masks.file, seen.name, f"{name} has an empty mask")
            continue
        box = (float(columns.min()), float(rows.min()), float(np.ptp(columns) + 1), float(np.ptp(rows) + 1))
        if each.box != box:
            yield Fault(masks.file, seen.name, f"the box of {name} is the extent of its mask", str(box), str(each.box))
        # A polygon also has what is in its holes.
        if each.area != len(rows) and (each.has_holes or not 0 < each.area <= len(rows)):
            yield Fault(
                masks.file, seen.name, f"the area of {name} is the pixels of its mask", str(len(rows)), f"{each.area:g}"
            )
    if (covered > 1).any():
        yield Fault(masks.file, seen.name, f"masks overlap in {of_pixels(covered > 1)}")


def _things(seen: Seen, masks: Masks) -> Faults:
    """Every visible thing that has a category is one annotation, with its pixels."""
    members = seen.truth.members(masks.filter) if seen.truth else None
    if seen.truth is None or members is None or (members.shape[1], members.shape[0]) != seen.size:
        return
    things = seen.truth.things(masks.filter)
    taken: dict[int, Mask] = {}
    for each in masks.masks:
        if each.mask is None or each.mask.shape != members.shape or not each.mask.any():
            continue
        index = index_of(each, members)
        if index < 0:
            yield Fault(masks.file, seen.name, f"annotation {each.number} is where nothing labeled is")
            continue
        thing = things[index]
        if index in taken:
            yield Fault(
                masks.file,
                seen.name,
                f"{thing.path} is annotated twice",
                "",
                f"{taken[index].number} and {each.number}",
            )
        taken[index] = each
        own = members == index
        if each.area != thing.visible:
            yield Fault(masks.file, seen.name, f"the area of {thing.path}", str(thing.visible), f"{each.area:g}")
        wrong = each.mask != (own if each.has_holes else without_holes(own))
        if wrong.any():
            yield Fault(
                masks.file,
                seen.name,
                f"the mask of annotation {each.number} is not that of {thing.path} in {of_pixels(wrong)}",
            )
        category = category_of(thing, masks)
        if category != each.category:
            yield Fault(
                masks.file, seen.name, f"the category of {thing.path}, {thing.label}", str(category), str(each.category)
            )
    for index, thing in enumerate(things):
        if index not in taken and is_listed(thing, masks, seen.truth) and is_thing(thing, masks):
            yield Fault(masks.file, seen.name, f"{thing.path} is visible and has no annotation")
    for index, each in taken.items():
        if not is_listed(things[index], masks, seen.truth):
            what = f"{things[index].path} is less visible than min_visibility and min_pixels ask, and is annotated"
            yield Fault(masks.file, seen.name, what, "", str(each.number))


def index_of(mask: Mask, members: np.ndarray) -> int:
    """Return which member most pixels of a mask show that is not empty; of polygons those on the edge count too."""
    assert mask.mask is not None
    shown, counts = np.unique(members[mask.mask], return_counts=True)
    if mask.has_holes or len(shown) == 1:
        return int(shown[counts.argmax()])
    # What is in the holes may be larger: of those with this area, the one that fills the mask.
    exact = [index for index in shown.tolist() if index >= 0 and (without_holes(members == index) == mask.mask).all()]
    return exact[0] if exact else int(shown[counts.argmax()])


def is_listed(thing: Thing, masks: Masks, truth: Truth) -> bool:
    """Return whether a thing has a category and is as visible as the writer's options ask."""
    return category_of(thing, masks) is not None and truth.is_visible_enough(thing)


def is_thing(thing: Thing, masks: Masks) -> bool:
    """Return whether a thing of its category is annotated: in COCO's own files stuff is not."""
    number = category_of(thing, masks)
    own = next((each for each in masks.own.values() if int(each["id"]) == number), {})
    return not masks.things_only or bool(own.get("isthing", 1))


def category_of(thing: Thing, masks: Masks) -> int | None:
    """Return the id of a thing's category: of its last label that has one, else of "other"; None: it has none."""
    if masks.by_class:
        whole = masks.own.get(",".join(label for _, label in sorted(thing.labels.items())))
        return None if whole is None else int(whole["id"])
    by_label = {_plain(label): int(each["id"]) for label, each in masks.own.items()}
    names = [name for text in thing.labels.values() for name in (text, *text.split(","))]
    known = [by_label[_plain(name)] for name in names if _plain(name) in by_label]
    return known[-1] if known else by_label.get(_OTHER)


def _plain(label: str) -> str:
    return label.lower().replace("_", " ")


def _panoptic(seen: Seen, masks: Masks) -> Faults:
    """Every pixel of a thing has the color of its category."""
    members = seen.truth.members(masks.filter) if seen.truth else None
    if seen.truth is None or members is None or "panoptic" not in seen.extra:
        return
    file, image = seen.extra["panoptic"]
    if image.ndim != 3 or image.shape[:2] != members.shape:
        yield Fault(file, seen.name, "has another size", str(members.shape), str(image.shape))
        return
    colors = {number: tuple(each.get("color", ())) for number, each in masks.categories.items()}
    wrong = np.zeros(members.shape, bool)
    for index, thing in enumerate(seen.truth.things(masks.filter)):
        color = colors.get(category_of(thing, masks) or -1, ())
        if len(color) == 3:
            wrong |= (members == index) & (image[..., :3] != color).any(axis=2)
    listed = np.array([color for color in colors.values() if len(color) == 3 and any(color)]).reshape(-1, 1, 1, 3)
    if len(listed):
        nothing = members == -2
        wrong |= nothing & (image[None, ..., :3] == listed).all(axis=3).any(axis=0)
    if wrong.any():
        yield Fault(file, seen.name, f"pixels have the color of their category, but {of_pixels(wrong)}")
