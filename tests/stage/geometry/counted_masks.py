"""Bit-packed masks made by hand, with pixels counted one by one."""

import numpy as np

from usdsdg.stage.geometry.pixel_masks import WORD_PIXELS, PixelMasks


def counted_masks(shape: tuple[int, int], count: int, words: np.ndarray) -> PixelMasks:
    """Make masks of the given words, with coverage counted from them."""
    coverage, visible = PixelMasks.nothing(shape, count).coverage, np.zeros(count, np.int64)
    for word in words:
        group, row = word["group"], word["row"]
        columns = [
            int(word["word"]) * WORD_PIXELS + bit for bit in range(WORD_PIXELS) if int(word["covered"]) >> bit & 1
        ]
        box = [columns[0], row, columns[-1], row]
        if coverage[group, 0]:
            box = [*np.minimum(coverage[group, 1:3], box[:2]), *np.maximum(coverage[group, 3:], box[2:])]
        coverage[group, 1:] = box
        coverage[group, 0] += len(columns)
        visible[group] += int(word["visible"]).bit_count()
    return PixelMasks(shape, count, lambda: words, coverage=coverage, visible=visible)
