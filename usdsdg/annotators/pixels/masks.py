"""What annotators read from the words of all masks together: run lengths, and who hides how many pixels of whom."""

from typing import NamedTuple

import numpy as np

from usdsdg.annotators.pixels.launch import run
from usdsdg.stage.geometry.pixel_masks import PixelMasks

# Words that a thread takes at a time.
WORDS = 1 << 14
_NOT_YET = np.zeros(0, np.int32)


class Hidden(NamedTuple):
    """Runs of hidden pixels."""

    group: np.ndarray  # (R,) whose pixels they are
    hider: np.ndarray  # (R,) the gprim that is visible instead, -1 for none
    pixels: np.ndarray  # (R,)


def run_lengths(masks: PixelMasks) -> list[list[int]]:
    """Return the covered pixels of each group as run lengths by columns, beginning with pixels outside (COCO's RLE)."""
    from usdsdg.annotators.pixels import mask_kernels as kernels  # imports Warp

    height, width = masks.shape
    words = masks.words
    inputs = [*(words[name] for name in ("group", "row", "word", "covered"))]
    counts, edges = np.zeros(len(words), np.int32), np.zeros(0, np.int64)
    run(kernels.find_edges, (len(words),), [*inputs, _NOT_YET, height], [counts, edges], band=WORDS)
    after = np.cumsum(counts, dtype=np.int32)
    edges = np.zeros(int(counts.sum()), np.int64)
    if len(edges):
        run(kernels.find_edges, (len(words),), [*inputs, after, height], [counts, edges], band=WORDS)
    edges.sort()
    # A run that goes on at the top of the next column is one.
    joined = np.flatnonzero(edges[1:] == edges[:-1])
    edges = np.delete(edges, np.concatenate([joined, joined + 1]))
    group = edges >> 32
    # The edges of each group, between the first pixel and one after the last.
    begins = np.searchsorted(group, np.arange(masks.count + 1)) + 2 * np.arange(masks.count + 1)
    at = np.zeros(len(edges) + 2 * masks.count, np.int64)
    at[begins[1:] - 1] = height * width
    at[np.arange(len(edges)) + 2 * group + 1] = edges & 0xFFFFFFFF
    lengths = np.diff(at).tolist()
    found = [lengths[first : last - 1] for first, last in zip(begins[:-1].tolist(), begins[1:].tolist())]
    return [each if each[-1] else each[:-1] for each in found]


def hidden_runs(masks: PixelMasks, instance: np.ndarray) -> Hidden:
    """Return all hidden pixels of all groups, in runs that one gprim hides; instance: the AOV."""
    from usdsdg.annotators.pixels import mask_kernels as kernels

    behind = masks.words["covered"] & ~masks.words["visible"]
    some = np.flatnonzero(behind)
    words = masks.words[some]
    inputs = [words["row"], words["word"], behind[some], instance]
    counts, none = np.zeros(len(words), np.int32), [np.zeros(0, np.int32)] * 3
    run(kernels.find_hiders, (len(words),), [*inputs, _NOT_YET], [counts, *none], band=WORDS)
    after = np.cumsum(counts, dtype=np.int32)
    word, hider, pixels = (np.zeros(int(counts.sum()), np.int32) for _ in range(3))
    if len(word):
        run(kernels.find_hiders, (len(words),), [*inputs, after], [counts, word, hider, pixels], band=WORDS)
    return Hidden(words["group"][word], hider, pixels)
