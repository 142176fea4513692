"""Cosmos's clips: gray depth, shaded segments and their edges are of the recorded frame."""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.augmentations.filters import canny
from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.cosmos import NAME
from usdsdg.datasets.seen import Seen
from usdsdg.record import samples
from usdsdg.verify.checks.compare import of_pixels, shapes_agree

_NEAR, _FAR = 0.1, 100.0
# Of the share of each channel in a segment's color, which shading keeps; 8 bits lose some.
_HUE = 0.06


def check(seen: Seen) -> Faults:
    """Compare the images of a clip with the record, and with each other."""
    if seen.format != NAME:
        return
    truth = seen.truth
    if truth is not None:
        for file, image in seen.further_images().values():
            yield from shapes_agree(seen, file, image.shape, truth.product.shape)
    if truth is not None and "depth" in seen.extra and truth.product.depth is not None:
        file, image = seen.extra["depth"]
        gray = samples.grid(image if image.ndim == 2 else image[..., 0]).astype(int)
        fraction = np.log(np.clip(truth.product.depth, _NEAR, _FAR) / _NEAR) / np.log(_FAR / _NEAR)
        wrong = np.abs(gray - (1.0 - fraction) * 255) > 1.5
        if wrong.any():
            yield Fault(file, seen.name, f"gray levels are not those of the depth in {of_pixels(wrong)}")
    if truth is not None and "shaded_seg" in seen.extra:
        yield from _shaded(seen)
    if "edges" in seen.extra and "shaded_seg" in seen.extra:
        yield from _edges(seen)


def _shaded(seen: Seen) -> Faults:
    """A segment has one hue, and nothing is black."""
    assert seen.truth is not None
    file, image = seen.extra["shaded_seg"]
    known = seen.truth.gprim_names()
    if known is None or image.ndim != 3 or image.shape[:2] != known[0].shape:
        return
    shown, names = known
    color = image[..., :3].astype(float)
    total = color.sum(axis=2)
    empty = shown == len(names) - 1
    if (total[empty] > 0).any():
        yield Fault(file, seen.name, "where nothing was hit, pixels are black")
    for index in np.unique(shown[~empty]).tolist():
        mine = (shown == index) & (total > 90)
        hues = color[mine] / total[mine][:, None]
        if len(hues) and np.abs(hues - np.median(hues, axis=0)).max() > _HUE:
            yield Fault(file, seen.name, f"{names[index]} has several hues")


def _edges(seen: Seen) -> Faults:
    """Edges are those of the shaded segments."""
    (file, edges), (_, shaded) = seen.extra["edges"], seen.extra["shaded_seg"]
    parameters = seen.truth.record.parameters if seen.truth else {}
    if parameters.get("segmentation_mapping") or edges.shape[:2] != shaded.shape[:2]:
        return
    low, high = (float(parameters.get(f"canny_threshold_{end}", own)) for end, own in (("low", 10), ("high", 100)))
    expected = canny(shaded, thresholdLow=low, thresholdHigh=high)
    wrong = (edges[..., 0] if edges.ndim == 3 else edges) != (expected[..., 0] if expected.ndim == 3 else expected)
    if wrong.any():
        yield Fault(file, seen.name, f"edges are not those of shaded_seg in {of_pixels(wrong)}")
