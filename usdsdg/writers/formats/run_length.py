"""Masks as COCO stores them: lengths of runs down the columns, first of pixels outside, then inside, and so on."""

from __future__ import annotations

import numpy as np

# Bits of a length in one character, and the bit that says that another one follows.
_BITS, _MORE = 5, 0x20


def runs_of_ids(ids: np.ndarray) -> dict[int, np.ndarray]:
    """The run lengths of the mask of every id in a picture (H, W), from one pass over it."""
    flat = np.asarray(ids).ravel(order="F")
    starts = np.flatnonzero(np.concatenate(([True], flat[1:] != flat[:-1])))
    ends = np.append(starts[1:], flat.size)
    values = flat[starts]
    order = np.argsort(values, kind="stable")
    present, first = np.unique(values[order], return_index=True)
    found = {}
    for value, rows in zip(present.tolist(), np.split(order, first[1:])):
        edges = np.stack([starts[rows], ends[rows]], axis=1).ravel()
        lengths = np.diff(edges, prepend=0, append=flat.size)
        found[value] = lengths if lengths[-1] else lengths[:-1]
    return found


def encoded(lengths: np.ndarray) -> str:
    """Run lengths as COCO's compact text: from the fourth on as differences from the last but one.

    A number is a string of characters from "0" (48) on, of five bits each, the lowest first; the fifth bit of the last
    is its sign.
    """
    rest = np.array(lengths, np.int64)
    rest[3:] -= np.asarray(lengths, np.int64)[1:-2]
    columns, written = [], np.ones(len(rest), bool)
    used = []
    while written.any():
        digit = rest & (_MORE - 1)
        rest >>= _BITS
        follows = np.where(digit & (_MORE >> 1), rest != -1, rest != 0)
        columns.append((digit | np.where(follows, _MORE, 0)) + 48)
        used.append(written)
        written = written & follows
    text = np.stack(columns, axis=1)[np.stack(used, axis=1)]
    return text.astype(np.uint8).tobytes().decode("ascii")
