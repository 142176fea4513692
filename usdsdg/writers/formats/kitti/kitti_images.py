"""Images of classes, objects and depth in KITTI's formats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.colors import FIRST_LABELED
from usdsdg.errors import warn_once
from usdsdg.writers.formats.kitti.kitti_classes import KittiClasses

_DEPTH_SCALE = 256  # steps of a depth image per meter
_FARTHEST = 0xFFFF  # of them


def class_images(classes: Mapping[str, Any], known: KittiClasses) -> tuple[np.ndarray, np.ndarray]:
    """Return ids, uint8 (H, W), and colors, uint8 (H, W, 4), of the pixels' classes."""
    ids = classes["data"]
    palette = np.zeros((max(map(int, classes["idToLabels"])) + 1, 5), np.uint8)
    for number, labels in classes["idToLabels"].items():
        found = known.of(labels)
        palette[int(number)] = (found.id, *found.color)
    return palette[:, 0][ids], palette[:, 1:][ids]


def instance_image(instances: Mapping[str, Any], known: KittiClasses) -> np.ndarray:
    """Return uint16 (H, W): 256 * class + number; the number is 0 where there is no object."""
    ids = instances["data"]
    palette = np.zeros(max(instances["idToSemantics"]) + 1, np.uint16)
    counted: dict[int, int] = {}
    for number, labels in sorted(instances["idToSemantics"].items()):
        class_id = known.of(labels).id
        if number >= FIRST_LABELED:
            counted[class_id] = counted.get(class_id, 0) + 1
        palette[number] = class_id * 256 + _eight_bits(counted.get(class_id, 0) if number >= FIRST_LABELED else 0)
    return palette[ids]


def _eight_bits(number: int) -> int:
    if number > 255:
        warn_once(
            "KittiWriter: more than 255 objects of a class in an image: instance_segmentation has 0 for the rest."
        )
    return number if number <= 255 else 0


def depth_image(depth: np.ndarray) -> np.ndarray:
    """Encode depth [m] as uint16 (H, W) in steps of 1/256; 0 where nothing is hit or the depth is out of range."""
    steps = np.rint(np.where(np.isfinite(depth), depth, 0.0).astype(np.float64) * _DEPTH_SCALE)
    if steps.max(initial=0.0) > _FARTHEST or steps.min(initial=0.0) < 0.0:
        warn_once(
            f"KittiWriter: what is {(_FARTHEST + 1) // _DEPTH_SCALE} m or more ahead, or behind the camera as lenses "
            "beyond 180 degrees see it, has the depth 0, since the format cannot have it."
        )
    return np.where((steps >= 0.0) & (steps <= _FARTHEST), steps, 0.0).astype(np.uint16)
