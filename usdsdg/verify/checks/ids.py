"""Images of ids: each pixel means what was there, and each object or class has one id."""

from __future__ import annotations

from collections import Counter

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Ids, Seen, unpacked
from usdsdg.datasets.truth import INVALID, UNLABELLED, Truth
from usdsdg.errors import counted
from usdsdg.verify.checks.compare import LISTED, shapes_agree


def check(seen: Seen) -> Faults:
    """Compare the images of ids with the record, and with their tables."""
    for ids in seen.ids:
        present = np.unique(ids.keys)
        if ids.meanings is not None:
            unknown = [int(key) for key in present if int(key) not in ids.meanings]
            if unknown:
                yield Fault(
                    ids.table,
                    seen.name,
                    f"does not list {len(unknown)} of the {_what(ids)} in {ids.file}",
                    "",
                    _keys(ids, unknown),
                )
            if ids.kind == "gprim" and not ids.chosen and ids.meanings.get(0, INVALID) != INVALID:
                yield Fault(ids.table, seen.name, f"what {_keys(ids, [0])} means", INVALID, ids.meanings[0])
        if seen.truth is None:
            continue
        shape = seen.truth.product.shape
        yield from shapes_agree(seen, ids.file, ids.keys.shape, shape)
        named = names_of(seen.truth, ids)
        if named is None or ids.keys.shape != shape:
            continue
        if ids.meanings is None or ids.chosen:
            yield from _one_key_each(seen, ids, *named)
        else:
            yield from _same_meaning(seen, ids, *named)


def names_of(truth: Truth, ids: Ids) -> tuple[np.ndarray, list[str]] | None:
    """Return (H, W) indices into names, and the names, of what each pixel shows."""
    if ids.kind == "gprim":
        return truth.gprim_names()
    if ids.kind == "instance":
        return truth.instance_names(ids.filter)
    return truth.class_names(ids.filter)


def _same_meaning(seen: Seen, ids: Ids, image: np.ndarray, names: list[str]) -> Faults:
    """Every pixel means what the record has there."""
    assert ids.meanings is not None
    known = {name: index for index, name in reversed(list(enumerate(names)))}
    present, inverse = np.unique(ids.keys, return_inverse=True)
    meanings = [ids.meanings.get(int(key), "nothing that is listed") for key in present]
    # Names that are listed twice are the same.
    canonical = np.array([known[name] for name in names])
    found = np.array([known.get(name, -1 - index) for index, name in enumerate(meanings)])
    wrong = found[inverse.reshape(image.shape)] != canonical[image]
    if wrong.any():
        pairs = Counter(zip(image[wrong].tolist(), inverse.reshape(image.shape)[wrong].tolist()))
        for (expected, index), count in pairs.most_common(LISTED):
            row, column = np.argwhere(wrong & (image == expected) & (ids.keys == present[index]))[0].tolist()
            yield Fault(
                ids.file,
                seen.name,
                f"{counted(count, 'pixel')}, first in column {column} of row {row}",
                names[expected],
                meanings[index],
            )


def _one_key_each(seen: Seen, ids: Ids, image: np.ndarray, names: list[str]) -> Faults:
    """All pixels of a thing have one id or color, and where the user chose none, no two things share it."""
    first: dict[int, str] = {}
    for index in np.unique(image).tolist():
        values, counts = np.unique(ids.keys[image == index], return_counts=True)
        if len(values) > 1:
            most = int(values[counts.argmax()])
            yield Fault(
                ids.file,
                seen.name,
                f"{names[index]} has {len(values)} {_what(ids)}",
                f"one, as {_keys(ids, [most])}",
                _keys(ids, values.tolist()[:LISTED]),
            )
        elif not ids.chosen and names[index] not in (UNLABELLED, INVALID):
            other = first.setdefault(int(values[0]), names[index])
            if other != names[index]:
                yield Fault(ids.file, seen.name, f"{other} and {names[index]} share {_keys(ids, values.tolist())}")


def _what(ids: Ids) -> str:
    return "colors" if ids.colored else "ids"


def _keys(ids: Ids, keys: list[int]) -> str:
    return ", ".join(str(unpacked(int(key)) if ids.colored else int(key)) for key in keys[:LISTED])
