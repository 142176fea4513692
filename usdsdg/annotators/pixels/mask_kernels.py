"""Kernels over the words of masks: where their runs begin and end in columns, and what hides their pixels."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false

import warp as wp

from usdsdg.stage.geometry import pixel_masks

WORD_PIXELS = wp.constant(pixel_masks.WORD_PIXELS)
NO_BITS = wp.constant(wp.uint64(0))
LOWEST = wp.constant(wp.uint64(1))


@wp.func
def lowest_bit(bits: wp.uint64):
    """Return the index of the lowest bit of a word that is not 0."""
    return int(wp.bit_count((bits & (~bits + LOWEST)) - LOWEST))


@wp.kernel(enable_backward=False, module="unique")
def find_edges(
    group: wp.array(dtype=wp.int32),  # of each word; words are ordered by group, row and column
    row: wp.array(dtype=wp.int32),
    column: wp.array(dtype=wp.int32),  # in words
    covered: wp.array(dtype=wp.uint64),
    after: wp.array(dtype=wp.int32),  # running sums of counts; empty while edges are only counted
    height: int,
    first: int,
    # out
    counts: wp.array(dtype=wp.int32),
    edges: wp.array(dtype=wp.int64),  # group in the high half, and the pixel, by columns, where a run begins or is over
):
    """Find where the runs of each group's pixels begin and are over, down the columns; called first to count them."""
    i = wp.tid() + first
    above = NO_BITS
    k = int(i) - 1
    while k >= 0 and group[k] == group[i] and row[k] >= row[i] - 1:
        if row[k] == row[i] - 1 and column[k] == column[i]:
            above = covered[k]
        k -= 1
    below = NO_BITS
    k = int(i) + 1
    while k < group.shape[0] and group[k] == group[i] and row[k] <= row[i] + 1:
        if row[k] == row[i] + 1 and column[k] == column[i]:
            below = covered[k]
        k += 1
    begins = covered[i] & ~above
    ends = covered[i] & ~below
    if after.shape[0] == 0:
        counts[i] = int(wp.bit_count(begins) + wp.bit_count(ends))
        return
    slot = after[i] - counts[i]
    high = wp.int64(group[i]) << wp.int64(32)
    while begins != NO_BITS:
        x = column[i] * WORD_PIXELS + lowest_bit(begins)
        edges[slot] = high | wp.int64(x * height + row[i])
        slot += 1
        begins = begins & (begins - LOWEST)
    while ends != NO_BITS:
        x = column[i] * WORD_PIXELS + lowest_bit(ends)
        edges[slot] = high | wp.int64(x * height + row[i] + 1)
        slot += 1
        ends = ends & (ends - LOWEST)


@wp.kernel(enable_backward=False, module="unique")
def find_hiders(
    row: wp.array(dtype=wp.int32),  # of each word
    column: wp.array(dtype=wp.int32),
    behind: wp.array(dtype=wp.uint64),  # pixels that are covered and not visible
    instance: wp.array2d(dtype=wp.int32),
    after: wp.array(dtype=wp.int32),  # running sums of counts; empty while runs are only counted
    first: int,
    # out: of each run of pixels that one gprim hides
    counts: wp.array(dtype=wp.int32),  # of each word
    words: wp.array(dtype=wp.int32),
    hiders: wp.array(dtype=wp.int32),
    pixels: wp.array(dtype=wp.int32),
):
    """Find which gprims hide the pixels of each word, in runs; called first to count these."""
    i = wp.tid() + first
    bits = behind[i]
    count = int(0)
    slot = int(0)
    if after.shape[0] > 0:
        slot = after[i] - counts[i] - 1
    hider = int(-2)
    while bits != NO_BITS:
        here = instance[row[i], column[i] * WORD_PIXELS + lowest_bit(bits)]
        bits = bits & (bits - LOWEST)
        if here != hider:
            hider = here
            count += 1
            slot += 1
            if after.shape[0] > 0:
                words[slot] = i
                hiders[slot] = here
                pixels[slot] = 0
        if after.shape[0] > 0:
            pixels[slot] += 1
    if after.shape[0] == 0:
        counts[i] = count
