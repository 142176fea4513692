"""Run-length encoding (RLE) of masks as in COCO: column-major run lengths, first of pixels outside, then inside, ...

Our own, because it encodes all masks of an id image in one pass: 30 masks of 1080p take 9 ms against 80 to 130 ms with
pycocotools, which also would be another compiled dependency.
"""

import numpy as np

# Payload bits of a character, and the bit that marks that another character follows.
_BITS, _MORE = 5, 0x20


def runs_of_ids(ids: np.ndarray) -> dict[int, np.ndarray]:
    """Return the run lengths of the mask of every id in an image (H, W), in one pass over it."""
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
    """Encode run lengths as COCO's compressed RLE text: from the fourth on as differences from the one two before.

    A number is a sequence of characters from "0" (48) on, with five bits each, lowest first; the highest of the five
    bits of the last character is the sign.
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
