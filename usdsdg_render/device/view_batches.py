"""Batches of views that are rendered in one launch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from usdsdg.stage.cameras.camera_view import CameraView
    from usdsdg_render.path.film import Film

# Maximum pixels of the label pass in one launch; all AOVs together take about 100 bytes a pixel.
LABEL_PIXELS = 1 << 24

# Maximum masks at once, each of one gprim in one image; a mask takes about 2 kB on average.
MASKS = 1 << 16


def same_size(views: Sequence[CameraView], films: Sequence[Film] = ()) -> list[list[int]]:
    """Group the indices of views that may share a launch: same size and units, and films with the same buffers."""
    groups: dict[tuple[float | bool, ...], list[int]] = {}
    for k, view in enumerate(views):
        buffers = (films[k].has_features, films[k].has_light_aovs) if films else ()
        groups.setdefault((view.width, view.height, view.meters_per_unit, *buffers), []).append(k)
    return list(groups.values())


def label_batches(views: Sequence[CameraView]) -> list[list[int]]:
    """Split the groups of `same_size` into batches of at most LABEL_PIXELS pixels."""
    batches = []
    for indices in same_size(views):
        size = max(1, LABEL_PIXELS // (views[indices[0]].width * views[indices[0]].height))
        batches += [indices[first : first + size] for first in range(0, len(indices), size)]
    return batches


def mask_batches(images: int, gprims: int) -> list[range]:
    """Split images into batches of at most MASKS masks."""
    size = max(1, MASKS // max(1, gprims))
    return [range(first, min(first + size, images)) for first in range(0, images, size)]
