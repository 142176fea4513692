"""Keypoints of COCO: names, skeleton and sigmas of each category, and the numbers of each object."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd

from usdsdg.annotators.ownership import LabeledStage, Owner, lower, output_labels, parse_filter
from usdsdg.errors import WriterError, counted
from usdsdg.stage.keypoints import get_keypoints, has_keypoints
from usdsdg.writers.formats.coco.coco_categories import Category

SIGMA = 0.05  # of COCO's own between 0.025 (eyes) and 0.107 (hips)
Rows = Mapping[int, Mapping[str, tuple[float, float, int]]]  # by instance and name: column, row, visibility


@dataclass(frozen=True)
class Skeleton:
    """The keypoints of one category."""

    names: tuple[str, ...]
    bones: tuple[tuple[int, int], ...]  # positions of the names, from 1
    sigmas: tuple[float, ...]

    def described(self) -> dict[str, Any]:
        """Return what the category has."""
        return {"keypoints": list(self.names), "skeleton": [list(bone) for bone in self.bones]}

    def numbers(self, seen: Mapping[str, tuple[float, float, int]]) -> dict[str, Any]:
        """Return what an annotation has: x, y and v of each keypoint, and how many are in the picture."""
        flat: list[float] = []
        for name in self.names:
            x, y, visible = seen.get(name, (0.0, 0.0, 0))
            flat += [x, y, visible] if visible else [0, 0, 0]
        return {"keypoints": flat, "num_keypoints": sum(1 for v in flat[2::3] if v)}


def read(label: str, given: Any) -> Skeleton:
    """Return the skeleton that a user gives for a category.

    given: names in their order, or {"keypoints": names, "skeleton": pairs of names, "sigmas": one number for each}.

    Raises:
        WriterError: it is none of these.
    """
    values = given if isinstance(given, Mapping) else {"keypoints": given}
    names, bones, sigmas = (values.get(key) for key in ("keypoints", "skeleton", "sigmas"))
    where = f"CocoWriter: keypoints[{label!r}]"
    if unknown := set(values) - {"keypoints", "skeleton", "sigmas"}:
        raise WriterError(f"{where} has {', '.join(map(repr, unknown))}; expected keypoints, skeleton and sigmas.")
    if not _is_list(names) or not names or not all(isinstance(each, str) for each in names):
        raise WriterError(f"{where} names {names!r}; expected a list of names of keypoints.")
    if len(set(names)) < len(names):
        raise WriterError(f"{where} names a keypoint twice: {', '.join(names)}.")
    bones = [] if bones is None else bones
    if not _is_list(bones) or not all(_is_list(bone) and len(bone) == 2 and set(bone) <= set(names) for bone in bones):
        raise WriterError(f"{where}['skeleton'] is {bones!r}; expected pairs of its keypoints, {', '.join(names)}.")
    sigmas = [SIGMA] * len(names) if sigmas is None else sigmas
    fit = _is_list(sigmas) and len(sigmas) == len(names)
    if not fit or not all(isinstance(each, (int, float)) and each > 0 for each in sigmas):
        raise WriterError(f"{where}['sigmas'] is {sigmas!r}; expected {counted(len(names), 'number')} above 0.")
    pairs = tuple((names.index(a) + 1, names.index(b) + 1) for a, b in bones)
    return Skeleton(tuple(names), pairs, tuple(map(float, sigmas)))


def on_stage(stage: Usd.Stage, label_filter: str | None) -> list[tuple[dict[str, str], tuple[str, ...]]]:
    """Return labels, as annotators output them, and names of keypoints of each prim that has any, hidden or not."""
    labeled, chosen = LabeledStage(stage), parse_filter(label_filter)
    found = []
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        if has_keypoints(prim):
            labels = output_labels(lower(labeled.all_labels(Owner(prim.GetPath()), [])), chosen)
            found += [(labels, tuple(get_keypoints(prim)))] if labels else []
    return found


class Keypoints:
    """The skeletons of a dataset by category id: those that the user gives, then those of the stage's keypoints."""

    def __init__(self, given: Mapping[str, Any]) -> None:
        """given: by label, see `read`; categories that it leaves out have the keypoints of the stage, by name."""
        self._given = {label: read(label, value) for label, value in given.items()}
        self._by_category: dict[int, Skeleton] | None = None

    def find(self, categories: Any, prims: Callable[[], Sequence[tuple[dict[str, str], tuple[str, ...]]]]) -> None:
        """Find the skeleton of each category, once. prims: returns those of `on_stage`.

        Raises:
            WriterError: a given label is not that of a category.
        """
        if self._by_category is not None:
            return
        by_label = {category["name"].lower(): category["id"] for category in categories.all()}
        found = {}
        for label, skeleton in self._given.items():
            if label.lower() not in by_label:
                raise WriterError(
                    f"CocoWriter: keypoints are given for {label!r}, which is no category; there are "
                    f"{', '.join(sorted(by_label))}. List a class that later frames bring in semantic_classes, or in "
                    "coco_categories."
                )
            found[by_label[label.lower()]] = skeleton
        names: dict[int, set[str]] = {}
        for labels, own in prims():
            category = categories.of(labels)
            if category["id"] not in found:
                names.setdefault(category["id"], set()).update(own)
        self._by_category = found | {number: read(str(number), sorted(own)) for number, own in names.items()}

    def described(self, category: Category) -> Category:
        """Return a category with its keypoints and skeleton."""
        skeleton = (self._by_category or {}).get(category["id"])
        return category if skeleton is None else {**category, **skeleton.described()}

    def sigmas(self, categories: Sequence[Category]) -> dict[str, list[float]]:
        """Return the sigmas of each category that has keypoints, by its name."""
        skeletons = self._by_category or {}
        return {each["name"]: list(skeletons[each["id"]].sigmas) for each in categories if each["id"] in skeletons}

    def numbers(self, category: Category, seen: Mapping[str, tuple[float, float, int]]) -> dict[str, Any]:
        """Return what an object's annotation has; nothing where its category has no keypoints.

        Raises:
            WriterError: there is a keypoint that the category has not.
        """
        skeleton = (self._by_category or {}).get(category["id"])
        new = [name for name in seen if skeleton is None or name not in skeleton.names]
        if new:
            raise WriterError(
                f"CocoWriter: the keypoints {', '.join(new)} of {category['name']} are new, and COCO has as many in "
                f"all pictures. Name all in the writer's option keypoints: {{{category['name']!r}: [...]}}. If the "
                "class is new, too, list it in semantic_classes."
            )
        return {} if skeleton is None else skeleton.numbers(seen)


def rows(payload: Mapping[str, Any]) -> Rows:
    """Return column, row [pixels] and visibility of each keypoint, by instance id and name, of `keypoints`.

    Of several of one name, which parts of an object may have, the last in the picture counts.
    """
    found: dict[int, dict[str, tuple[float, float, int]]] = {}
    names = payload["keypointNames"]
    for row in payload["data"]:
        x, y = (float(np.round(float(row[axis]), 3)) for axis in "xy")
        own = found.setdefault(int(row["instanceId"]), {})
        name = names[int(row["keypointId"])]
        if row["visibility"] or name not in own:
            own[name] = (x, y, int(row["visibility"]))
    return found


def _is_list(value: Any) -> bool:
    return isinstance(value, (list, tuple))
