"""Reference implementation of `compress_tree.cpp` in NumPy, level by level."""

from __future__ import annotations

import numpy as np

SLOTS = 8
_SLACK, _SLACK_OF_POSITION = 2e-5, 1e-6


def compress(built: np.ndarray, members: np.ndarray, block: int) -> tuple[np.ndarray, np.ndarray]:
    """(N, 20) uint32 nodes and (M,) int32 order of (N, 64) float32 nodes and (B, block) members of `Builder`."""
    boxes = built[:, :48].reshape(-1, 2, 3, SLOTS).transpose(1, 0, 3, 2)
    lower, upper, child = boxes[0], boxes[1], built[:, 48:56].view(np.int32)
    used = lower[..., 0] <= upper[..., 0]
    corner = np.where(used[..., None], lower, np.inf).min(1).astype(np.float64)
    extent = np.where(used[..., None], upper, -np.inf).max(1) - corner
    slack = (_SLACK * extent + _SLACK_OF_POSITION * np.abs(corner))[:, None]
    lower, upper = lower - slack, upper + slack
    corner = np.nextafter(lower.min(1, where=used[..., None], initial=np.inf).astype(np.float32), np.float32(-np.inf))
    extent = upper.max(1, where=used[..., None], initial=-np.inf) - corner
    in_slot = np.take_along_axis
    slots = _slots(0.5 * (lower + upper) - (corner + 0.5 * extent)[:, None], used)
    used, child = in_slot(used, slots, 1), in_slot(child, slots, 1)
    lower, upper = (in_slot(each, slots[..., None], 1) for each in (lower, upper))

    inner = used & (child >= 0)
    levels, base = _by_level(child, inner)
    used, child, inner = used[levels], child[levels], inner[levels]
    leaves = ~child[used & ~inner]
    rows = leaves[:, None] if block == 1 else members[leaves >> 2]
    sizes = np.zeros(child.shape, np.int64)
    sizes[used & ~inner] = (rows >= 0).sum(1)

    exponent = np.ceil(np.log2(np.maximum(extent[levels], 1e-30) / 255.0)).astype(np.int64)
    step = 2.0**exponent
    corner = corner[levels]
    first = np.floor((lower[levels] - corner[:, None]) / step[:, None]).clip(0, 255)
    last = np.ceil((upper[levels] - corner[:, None]) / step[:, None]).clip(0, 255)
    first, last = (np.where(used[..., None], each, 0).astype(np.uint8) for each in (first, last))

    nodes = np.zeros((len(child), 20), np.uint32)
    octets = nodes.view(np.uint8)  # little-endian
    nodes[:, :3] = corner.astype(np.float32).view(np.uint32)
    octets[:, 12:15] = exponent + 127
    octets[:, 15] = np.packbits(inner, axis=1, bitorder="little")[:, 0]
    nodes[:, 4] = base
    nodes[:, 5] = np.cumsum(sizes.sum(1)) - sizes.sum(1)
    offset = np.cumsum(sizes, 1) - sizes
    ones = (1 << sizes) - 1
    octets[:, 24:32] = np.where(inner, 56 + np.arange(SLOTS), np.where(sizes > 0, ones << 5 | offset, 0))
    for axis in range(3):
        octets[:, 32 + 8 * axis : 40 + 8 * axis] = first[..., axis]
        octets[:, 56 + 8 * axis : 64 + 8 * axis] = last[..., axis]
    return nodes, rows[rows >= 0]


def _slots(middle: np.ndarray, used: np.ndarray) -> np.ndarray:
    """(N, 8): which child sits in each slot, an octant: bit 2 for +x, bit 1 for +y, bit 0 for +z."""
    bits = np.arange(SLOTS)[:, None] >> np.array([2, 1, 0]) & 1
    agreement = middle @ (2.0 * bits - 1.0).T
    agreement = np.where(used[..., None], agreement, -1e30)  # empty children take the remaining slots
    rows = np.arange(len(middle))
    slots = np.zeros((len(middle), SLOTS), np.int64)
    for _ in range(SLOTS):
        best = agreement.reshape(len(middle), -1).argmax(1)
        child, slot = best // SLOTS, best % SLOTS
        slots[rows, slot] = child
        agreement[rows, child] = -np.inf
        agreement[rows, :, slot] = -np.inf
    return slots


def _by_level(child: np.ndarray, inner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(node numbers in an order that keeps siblings together, index of each one's first child in that order)."""
    level, levels, firsts, end = np.zeros(1, np.int64), [], [], 1
    while len(level):
        counts = inner[level].sum(1)
        levels.append(level)
        firsts.append(end + np.cumsum(counts) - counts)
        end += int(counts.sum())
        level = child[level][inner[level]].astype(np.int64)
    return np.concatenate(levels), np.concatenate(firsts)
