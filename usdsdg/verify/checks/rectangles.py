"""The rectangles of least area around the pixels of masks."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.polygons import filled

_NEAR = 0.01  # pixels by which sides may be off
_SAME = 1e-5  # by so much of it an area may be larger than the least, as the writer's 32 bits find it


def problem_of(corners: np.ndarray, mask: np.ndarray) -> str:
    """Return what is wrong with a rectangle (4, 2) of least area around the pixels of a mask; "" if nothing is."""
    if (mask & ~filled(corners, mask.shape)).any():
        return "does not hold its pixels"
    (area, around), (least, _) = _measures(corners), _measures(least_rectangles(mask)[0])
    return f"has {area:.2f} pixels, and one of {least:.2f} holds them" if abs(area - least) > _NEAR * around else ""


def _measures(corners: np.ndarray) -> tuple[float, float]:
    """Return the area and half of the circumference."""
    first, second = (float(np.linalg.norm(corners[k + 1] - corners[k])) for k in (0, 1))
    return first * second, first + second


def least_rectangles(mask: np.ndarray) -> list[np.ndarray]:
    """Return the corners (4, 2) of all rectangles of least area around the pixels of a mask: a side is along the hull.

    There are several where areas are the same, as they are around a half of a square.
    """
    from scipy.spatial import ConvexHull

    rows, columns = np.nonzero(mask)
    corners = np.concatenate([np.stack([columns + x, rows + y], axis=1) for x in (0, 1) for y in (0, 1)]).astype(float)
    hull = corners[ConvexHull(corners).vertices]
    along = np.roll(hull, -1, axis=0) - hull
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    axes = np.stack([along, np.stack([-along[:, 1], along[:, 0]], axis=1)], axis=1)  # (sides, 2, 2)
    turned = np.einsum("skd,nd->snk", axes, hull)
    low, high = turned.min(axis=1), turned.max(axis=1)
    areas = (high - low).prod(axis=1)
    found: dict[tuple[float, ...], np.ndarray] = {}
    for best in np.flatnonzero(areas <= areas.min() * (1 + _SAME)):
        (left, top), (right, bottom) = low[best], high[best]
        rectangle = np.array([(left, top), (right, top), (right, bottom), (left, bottom)]) @ axes[best]
        found.setdefault(tuple(sorted(np.round(rectangle, 3).ravel().tolist())), rectangle)
    return list(found.values())
