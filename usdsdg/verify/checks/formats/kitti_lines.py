"""KITTI: lines of objects, with their boxes in pixels and in meters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen
from usdsdg.datasets.truth import Thing, Truth
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.verify.checks.compare import angles_differ, differs, text
from usdsdg.verify.checks.poses import truncation
from usdsdg.writers.formats.kitti import files

BOXES = "bounding_box_2d_tight_fast"
_FIELDS = 15
_DIGITS = 5e-5  # six digits of numbers in meters
_ANGLE = 2e-3
# To the camera's frame of KITTI: x right, y down, z ahead.
_AXES = np.array([1.0, -1.0, -1.0])


def check_lines(seen: Seen, file: str, lines: list[list[str]]) -> Faults:
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
        if angles_differ(rotation - math.atan2(x, z), alpha, absolute=_ANGLE):
            yield Fault(
                file,
                seen.name,
                f"alpha of {name} is rotation_y as seen along the ray",
                f"{rotation - math.atan2(x, z):.4f}",
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
    parameters = truth.record.parameters
    if parameters.get("omit_semantic_type") or files.layout_of(parameters) is files.PLAIN:
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
    if angles_differ(values[13], rotation, absolute=_ANGLE):
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
