"""How far files that another version or device makes may differ: what two files show, not their bytes."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

RELATIVE, ABSOLUTE = 1e-3, 1e-3
PIXEL = 1  # by which whole numbers may differ, such as edges of boxes
SHARE = 0.01  # of pixels, and of numbers in an array, that may differ by more
LEVELS = 8 / 255  # by which a color may differ
FEW_COLORS = 256  # an image with fewer has ids, which differ or not
_IMAGES, _TEXTS = (".png", ".jpg", ".jpeg"), (".txt", ".csv", ".xml", ".yaml")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


class Unknown(Exception):
    """No tolerance is known for files of a kind."""


def difference(one: Path, other: Path) -> str | None:
    """Return in which way two files differ by more than the tolerance; None if they do not.

    Raises:
        Unknown: no tolerance is known for files of this kind.
    """
    kind = one.suffix.lower()
    try:
        if kind in _IMAGES:
            return _of_images(np.asarray(Image.open(one)), np.asarray(Image.open(other)))
        if kind == ".npy":
            return _of_arrays(np.load(one), np.load(other))
        if kind == ".json":
            return _of_values(json.loads(one.read_bytes()), json.loads(other.read_bytes()), "")
        if kind in _TEXTS:
            return _of_texts(one.read_text(), other.read_text())
    except (ValueError, SyntaxError) as error:
        return f"it cannot be read: {error}"
    raise Unknown(kind)


def _of_images(one: np.ndarray, other: np.ndarray) -> str | None:
    if one.shape != other.shape or one.dtype != other.dtype:
        return f"{one.shape} {one.dtype} and {other.shape} {other.dtype}"
    pixels = one.reshape(one.shape[0] * one.shape[1], -1)
    apart = np.abs(pixels.astype(np.int64) - other.reshape(pixels.shape).astype(np.int64)).max(axis=1)
    is_of_ids = len(np.unique(pixels, axis=0)) < FEW_COLORS
    limit = 0 if is_of_ids or not np.issubdtype(one.dtype, np.integer) else LEVELS * np.iinfo(one.dtype).max
    share = float((apart > limit).mean())
    return None if share <= SHARE else f"{100 * share:.1f} % of the pixels"


def _of_arrays(one: np.ndarray, other: np.ndarray) -> str | None:
    if one.shape != other.shape or one.dtype != other.dtype:
        return f"{one.shape} {one.dtype} and {other.shape} {other.dtype}"
    if one.dtype.names:
        found = ((name, _of_arrays(one[name], other[name])) for name in one.dtype.names)
        return next((f"{name}: {said}" for name, said in found if said), None)
    if not np.issubdtype(one.dtype, np.number):
        return None if np.array_equal(one, other) else "values"
    if np.issubdtype(one.dtype, np.integer):
        close = np.abs(one.astype(np.float64) - other.astype(np.float64)) <= PIXEL
    else:
        close = np.isclose(one, other, RELATIVE, ABSOLUTE, equal_nan=True)
    share = 1.0 - float(close.mean()) if close.size else 0.0
    return None if share <= SHARE else f"{100 * share:.1f} % of the values"


def _of_values(one: Any, other: Any, place: str) -> str | None:
    if isinstance(one, dict) and isinstance(other, dict):
        if one.keys() != other.keys():
            return f"{place or 'the names'}: {sorted(one.keys() ^ other.keys())[:4]}"
        pairs = [(f"{place}.{name}" if place else name, one[name], other[name]) for name in one]
    elif isinstance(one, list) and isinstance(other, list):
        if len(one) != len(other):
            return f"{place}: {len(one)} and {len(other)} items"
        pairs = [(f"{place}[{number}]", *both) for number, both in enumerate(zip(one, other))]
    else:
        return None if _are_close(one, other) else f"{place}: {one!r} and {other!r}"
    return next((said for name, a, b in pairs if (said := _of_values(a, b, name))), None)


def _are_close(one: Any, other: Any) -> bool:
    if (
        isinstance(one, bool)
        or isinstance(other, bool)
        or not all(isinstance(each, (int, float)) for each in (one, other))
    ):
        return one == other
    if isinstance(one, int) and isinstance(other, int):
        return abs(one - other) <= PIXEL
    return math.isclose(one, other, rel_tol=RELATIVE, abs_tol=ABSOLUTE)


def _of_texts(one: str, other: str) -> str | None:
    if _NUMBER.sub("#", one) != _NUMBER.sub("#", other):
        return "words"
    pairs = zip(_NUMBER.findall(one), _NUMBER.findall(other))
    return next((f"{a} and {b}" for a, b in pairs if not _are_close(_number(a), _number(b))), None)


def _number(text: str) -> float:
    return float(text) if any(sign in text for sign in ".eE") else int(text)
