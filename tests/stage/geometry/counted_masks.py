"""Outlines of strips that are made by hand, with pixels counted one by one."""

import numpy as np

from usdsdg.stage.geometry.pixel_masks import WORD, Outlines


def outlines_of(shape: tuple[int, int], count: int, strips: np.ndarray) -> Outlines:
    """Outlines that know no more than their strips."""
    coverage, visible = Outlines.nothing(shape, count).coverage, np.zeros(count, np.int64)
    for strip in strips:
        group, row = strip["group"], strip["row"]
        columns = [int(strip["word"]) * WORD + bit for bit in range(WORD) if int(strip["covered"]) >> bit & 1]
        box = [columns[0], row, columns[-1], row]
        if coverage[group, 0]:
            box = [*np.minimum(coverage[group, 1:3], box[:2]), *np.maximum(coverage[group, 3:], box[2:])]
        coverage[group, 1:] = box
        coverage[group, 0] += len(columns)
        visible[group] += int(strip["visible"]).bit_count()
    return Outlines(shape, count, lambda: strips, coverage=coverage, visible=visible)
