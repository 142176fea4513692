"""KITTI: lines of objects, ids and colors of classes, and numbers of objects."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen, packed, unpacked
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import differs, of_pixels, text
from usdsdg.verify.checks.poses import truncation

NAME, BOXES, CLASSES, INSTANCES = (
    "KittiWriter", "bounding_box_2d_tight_fast", "semantic_segmentation", "instance_segmentation_fast",
)  # fmt: skip
_FIELDS = 15
_DIGITS = 5e-5  # six digits of numbers in meters
_ANGLE = 2e-3
# To the camera's frame of KITTI: x right, y down, z ahead.
_AXES = np.array([1.0, -1.0, -1.0])


class Kitti:
    """Checks of all images of a dataset; colors of classes are compared among them."""

    def __init__(self) -> None:
        self._colors: dict[int, tuple[int, str]] = {}  # by id of the class: color and the frame that had it first

    def check(self, seen: Seen) -> Faults:
        """Check one image."""
        if seen.format != NAME:
            return
        for file, lines in seen.lines:
            yield from _lines(seen, file, lines)
        if seen.truth is not None:
            yield from _classes(seen, seen.truth)
            yield from _instances(seen, seen.truth)
        yield from self._colors_of_classes(seen)

    def _colors_of_classes(self, seen: Seen) -> Faults:
        if "ids" not in seen.extra or "colors" not in seen.extra:
            return
        (_, ids), (file, colors) = seen.extra["ids"], seen.extra["colors"]
        if ids.shape != colors.shape[:2]:
            yield Fault(file, seen.name, "has another size than the ids", str(ids.shape), str(colors.shape))
            return
        keys = packed(colors)
        for number in np.unique(ids).tolist():
            found = np.unique(keys[ids == number])
            first, frame = self._colors.setdefault(number, (int(found[0]), seen.name))
            if len(found) > 1:
                yield Fault(file, seen.name, f"class {number} has {len(found)} colors")
            elif int(found[0]) != first:
                yield Fault(
                    file,
                    seen.name,
                    f"class {number} has another color than in frame {frame}",
                    str(unpacked(first)),
                    str(unpacked(int(found[0]))),
                )


def _class_table(seen: Seen) -> dict[str, int]:
    return {
        _plain(name): int(number) for name, number in (seen.extra.get("metadata") or {}).get("semantic_ids", {}).items()
    }


def _plain(name: str) -> str:
    return name.lower().replace("_", " ")


def _class_of(labels: Mapping[str, str], table: Mapping[str, int]) -> int:
    """Return the id of the class of labels: that of the last known one, or of "unlabelled"."""
    names = [_plain(f"{kind}:{name}") for kind, own in labels.items() for name in (own, *own.split(","))]
    return next((table[name] for name in reversed(names) if name in table), table.get("class:unlabelled", 0))


def _classes(seen: Seen, truth: Truth) -> Faults:
    table, key = _class_table(seen), truth.filter_of(CLASSES)
    members = truth.members(key)
    if not table or members is None or "ids" not in seen.extra:
        return
    file, ids = seen.extra["ids"]
    things = truth.things(key)
    expected = np.array(
        [
            *(_class_of(each.labels, table) for each in things),
            table.get("class:background", 0),
            table.get("class:unlabelled", 0),
        ]
    )
    if ids.shape != members.shape:
        yield Fault(file, seen.name, "has another size", str(members.shape), str(ids.shape))
        return
    wrong = ids != expected[members]
    if wrong.any():
        row, column = np.argwhere(wrong)[0]
        yield Fault(
            file,
            seen.name,
            f"ids of classes differ in {of_pixels(wrong)}",
            str(expected[members][row, column]),
            str(ids[row, column]),
        )
    if "colors" in seen.extra:
        yield from _chosen_colors(seen, truth, members, things)


def _chosen_colors(seen: Seen, truth: Truth, members: np.ndarray, things: list[Thing]) -> Faults:
    """Classes to which the user gave a color have it."""
    given = truth.record.parameters.get("mapping_dict") or {}
    named = {
        _plain(name if ":" in name else f"class:{name}"): value
        for name, value in given.items()
        if isinstance(value, list)
    }
    file, colors = seen.extra["colors"]
    for index, thing in enumerate(things):
        names = [_plain(f"{kind}:{name}") for kind, own in thing.labels.items() for name in (own, *own.split(","))]
        color = next((named[name] for name in reversed(names) if name in named), None)
        mine = colors[members == index] if colors.shape[:2] == members.shape else np.zeros((0, 4))
        if color is not None and (mine != np.array(color)[: mine.shape[1]]).any():
            yield Fault(
                file,
                seen.name,
                f"the color of {thing.path}, {thing.label}",
                str(color),
                str(np.unique(mine, axis=0)[:2].tolist()),
            )


def _instances(seen: Seen, truth: Truth) -> Faults:
    key = truth.filter_of(INSTANCES)
    members = truth.members(key)
    for kind in ("instances", "instance colors"):
        if members is None or kind not in seen.extra:
            continue
        file, image = seen.extra[kind]
        keys = packed(image) if image.ndim == 3 else image.astype(np.int64)
        if keys.shape != members.shape:
            yield Fault(file, seen.name, "has another size", str(members.shape), str(keys.shape))
            continue
        first: dict[int, str] = {}
        for index, thing in enumerate(truth.things(key)):
            found = np.unique(keys[members == index])
            if len(found) > 1:
                yield Fault(file, seen.name, f"{thing.path} has {len(found)} numbers")
            elif len(found) and (kind == "instance colors" or found[0] % 256):
                other = first.setdefault(int(found[0]), thing.path)
                if other != thing.path:
                    yield Fault(file, seen.name, f"{other} and {thing.path} share {int(found[0])}")
            if kind == "instances" and len(found) == 1:
                yield from _class_part(seen, file, thing, int(found[0]))
        nothing = np.unique(keys[members < 0] % 256) if kind == "instances" else np.zeros(0)
        if nothing.any():
            yield Fault(file, seen.name, "what has no label has no number", "0", str(nothing.tolist()))


def _class_part(seen: Seen, file: str, thing: Thing, value: int) -> Faults:
    expected = _class_of(thing.labels, _class_table(seen))
    if _class_table(seen) and value // 256 != expected:
        yield Fault(file, seen.name, f"the class of {thing.path}", str(expected), str(value // 256))
    if value % 256 == 0:
        yield Fault(file, seen.name, f"{thing.path} has a number", "1 to 255", "0")


def _lines(seen: Seen, file: str, lines: list[list[str]]) -> Faults:
    """Check the lines of objects."""
    parsed = []
    for number, fields in enumerate(lines, 1):
        if len(fields) != _FIELDS:
            yield Fault(file, seen.name, f"fields of line {number}", str(_FIELDS), str(len(fields)))
            continue
        try:
            parsed.append((fields[0], np.array(fields[1:], np.float64)))
        except ValueError:
            yield Fault(file, seen.name, f"line {number} has fields that are no numbers")
    for name, values in parsed:
        alpha, (x, _, z), rotation = values[2], values[10:13], values[13]
        if abs(math.remainder(rotation - math.atan2(x, z) - alpha, math.tau)) > _ANGLE:
            yield Fault(
                file,
                seen.name,
                f"alpha of {name} is rotation_y as seen along the ray",
                f"{math.remainder(rotation - math.atan2(x, z), math.tau):.4f}",
                f"{alpha:g}",
            )
    if seen.truth is not None and seen.truth.camera is not None:
        yield from _match(seen, file, parsed, seen.truth)


def _match(seen: Seen, file: str, parsed: list[tuple[str, np.ndarray]], truth: Truth) -> Faults:
    """Every visible object of sufficient height has one line."""
    things = [each for each in truth.things(truth.filter_of(BOXES)) if _is_listed(each, truth)]
    left = list(things)
    for name, values in parsed:
        box = tuple(values[3:7].astype(int).tolist())
        known = [each for each in left if each.box == box]
        alike = [each for each in left if _name(each, truth) == name]
        # Two things may have one box: the name decides, then the place.
        near = [each for each in known if each in alike] or known or alike
        if not near:
            yield Fault(file, seen.name, f"a line of {name} is of nothing that is visible", "", str(box))
            continue
        thing = min(near, key=lambda each: float(np.abs(_location(each, truth)[0] - values[10:13]).max()))
        left.remove(thing)
        yield from _line(seen, file, name, values, thing, truth)
    for thing in left:
        yield Fault(file, seen.name, f"{thing.path} is visible and has no line", _name(thing, truth))


def _is_listed(thing: Thing, truth: Truth) -> bool:
    lowest = int(truth.record.parameters.get("bbox_height_threshold", 25))
    return thing.box is not None and thing.box[3] - thing.box[1] + 1 >= lowest


def _name(thing: Thing, truth: Truth) -> str:
    if truth.record.parameters.get("omit_semantic_type"):
        name = thing.labels.get("class", next(iter(thing.labels.values())))
    else:
        name = ";".join(f"{kind}:{label}" for kind, label in thing.labels.items())
    return "_".join(name.split())


def _line(seen: Seen, file: str, name: str, values: np.ndarray, thing: Thing, truth: Truth) -> Faults:
    what = f"of {thing.path}"
    if name != _name(thing, truth):
        yield Fault(file, seen.name, f"the name {what}", _name(thing, truth), name)
    if tuple(values[3:7].tolist()) != tuple(map(float, thing.box or ())):
        yield Fault(file, seen.name, f"the box {what}", str(thing.box), text(values[3:7]))
    if not 0.0 <= values[0] <= 1.0:
        yield Fault(file, seen.name, f"truncated {what}", "0 to 1", f"{values[0]:g}")
    truncated = truncation(thing, truth.camera) if truth.camera else None
    if truncated is not None and differs(values[0], truncated, relative=0.0, absolute=1e-4):
        yield Fault(file, seen.name, f"truncated {what}", f"{truncated:.4f}", f"{values[0]:g}")
    if thing.occlusion is not None:
        levels = {_level(1.0 - thing.occlusion + off, truth.record.parameters) for off in (-1e-6, 1e-6)}
        if int(values[1]) not in levels:
            yield Fault(file, seen.name, f"occluded {what}", str(min(levels)), f"{values[1]:g}")
    location, sizes, rotation = _location(thing, truth)
    if differs(values[7:10], sizes, relative=_DIGITS):
        yield Fault(file, seen.name, f"height, width and length {what} [m]", text(sizes), text(values[7:10]))
    if differs(values[10:13], location, relative=_DIGITS):
        yield Fault(file, seen.name, f"the location {what} [m]", text(location), text(values[10:13]))
    if abs(math.remainder(values[13] - rotation, math.tau)) > _ANGLE:
        yield Fault(file, seen.name, f"rotation_y {what}", f"{rotation:.4f}", f"{values[13]:.4f}")


def _level(visible: float, parameters: Mapping[str, Any]) -> int:
    fully, partly = (
        float(parameters.get(f"{name}_threshold", own))
        for name, own in (("fully_visible", 0.95), ("partly_occluded", 0.5))
    )
    return 0 if visible >= fully else 1 if visible >= partly else 2


def _location(thing: Thing, truth: Truth) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the center of the bottom [m], height, width and length [m], and rotation_y of a thing."""
    camera = truth.camera
    assert isinstance(camera, CameraView)
    pose = thing.local_to_world
    axes = (pose[:3, :3] @ camera.world_to_camera[:3, :3]) * _AXES
    sizes = (thing.bounds[1] - thing.bounds[0]) * np.linalg.norm(axes, axis=1) * camera.meters_per_unit
    center = np.append(thing.bounds.mean(axis=0), 1.0) @ pose @ camera.world_to_camera
    up = np.abs(pose[:3, "XYZ".index(truth.record.up_axis)]) / np.linalg.norm(pose[:3, :3], axis=1)
    upright = int(up.argmax())
    ahead, beside = (axis for axis in range(3) if axis != upright)
    bottom = center[:3] * _AXES * camera.meters_per_unit + (0.0, sizes[upright] / 2, 0.0)
    return bottom, sizes[[upright, beside, ahead]], math.atan2(-axes[ahead, 2], axes[ahead, 0])
