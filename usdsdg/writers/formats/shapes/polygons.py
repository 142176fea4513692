"""Outlines of masks as polygons along the edges of pixels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Steps along the edges of pixels, as (column, row), with the mask on the right: east, south, west, north.
_STEPS = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])


def outlines(mask: np.ndarray) -> list[np.ndarray]:
    """Return the outer outline of each part of a mask (H, W), largest first, as corners (N, 2) of x and y [pixels].

    A pixel at column x covers x to x + 1. Pixels that touch at a corner only are different parts; holes are left out,
    since formats of polygons have none. The corners are in clockwise order, and only those where the outline turns.
    """
    found = [loop for loop in _loops(np.asarray(mask, bool)) if _area(loop) > 0.0]
    return sorted(found, key=_area, reverse=True)


def joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """Return one polygon (N, 2) of several, with connections of no width between nearest corners, there and back.

    By the even-odd rule it covers what the parts cover if none is inside of another (see `without_holes`).
    """
    whole = parts[0]
    for part in parts[1:]:
        distances = ((whole[:, None] - part[None]) ** 2).sum(axis=2)
        here, there = np.unravel_index(distances.argmin(), distances.shape)
        around = np.concatenate([part[there:], part[: there + 1]])
        whole = np.concatenate([whole[: here + 1], around, whole[here:]])
    return whole


def without_holes(mask: np.ndarray) -> np.ndarray:
    """Return a mask (H, W) with its holes filled, as the outlines of its parts have it.

    Pixels that touch at a corner only are different parts, so that they close no hole.
    """
    from scipy import ndimage

    return np.asarray(ndimage.binary_fill_holes(mask, structure=np.ones((3, 3))), bool)


def _area(loop: np.ndarray) -> float:
    x, y = loop[:, 0].astype(float), loop[:, 1].astype(float)
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2.0


def _loops(mask: np.ndarray) -> list[np.ndarray]:
    """Return all closed outlines; those of holes run the other way round."""
    padded = np.pad(mask, 1)
    inside, above, left = padded[1:, 1:], padded[:-1, 1:], padded[1:, :-1]
    edges = [
        (*np.nonzero(inside & ~above), 0, (0, 0)),  # along the top of a pixel, to the east
        (*np.nonzero(left & ~inside), 1, (0, 0)),  # down its right side
        (*np.nonzero(above & ~inside), 2, (1, 0)),  # along its bottom, to the west
        (*np.nonzero(inside & ~left), 3, (0, 1)),  # up its left side
    ]
    leaving: dict[tuple[int, int], list[int]] = {}
    for rows, columns, direction, (dx, dy) in edges:
        for point in zip((columns + dx).tolist(), (rows + dy).tolist()):
            leaving.setdefault(point, []).append(direction)
    loops = []
    while leaving:
        start = next(iter(leaving))
        loops.append(_follow(leaving, start))
    return loops


def _follow(leaving: dict[tuple[int, int], list[int]], start: tuple[int, int]) -> np.ndarray:
    """Follow an outline from a corner until it is closed, and remove its edges."""
    point, corners, before = start, [], -1
    while True:
        directions = leaving[point]
        # Where two parts touch at a corner, the turn to the right stays with the same part.
        direction = directions[0] if len(directions) == 1 or before < 0 else (before + 1) % 4
        directions.remove(direction)
        if not directions:
            del leaving[point]
        if direction != before:
            corners.append(point)
        before = direction
        x, y = _STEPS[direction].tolist()
        point = (point[0] + x, point[1] + y)
        if point == start:
            break
    if len(corners) > 1 and _is_between(corners[-1], corners[0], corners[1]):
        corners = corners[1:]
    return np.array(corners)


def _is_between(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> bool:
    """Whether three corners are on one line."""
    return (b[0] - a[0]) * (c[1] - b[1]) == (b[1] - a[1]) * (c[0] - b[0])
