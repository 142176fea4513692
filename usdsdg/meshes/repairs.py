"""Repairs of parts that renderers and simulators would stumble over; each is reported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from usdsdg.meshes.model import MeshFile, Part

# Cosine of the angle between faces above which an edge looks round, where a file has no normals: 35 degrees.
SMOOTH = 0.82
# Faces around which smoothing looks for neighbors at most; scans beyond have edges too fine to see.
MAX_SMOOTHED = 500_000
# Coordinates that USD, with 32 bits, cannot compute with.
LARGEST = 1e18


def repaired(mesh: MeshFile) -> tuple[MeshFile, list[str]]:
    """Return the mesh without what is broken, and what was done: one line for each kind of repair."""
    done: list[str] = []
    parts = mesh.parts
    for name, repair in _REPAIRS.items():
        counts = []
        for index, part in enumerate(parts):
            mended, count = repair(part)
            parts = (*parts[:index], mended, *parts[index + 1 :])
            counts.append(count)
        if sum(counts):
            done.append(name.format(sum(counts)))
    parts = tuple(part for part in parts if len(part.triangles))
    return replace(mesh, parts=parts), done


def _without_bad_triangles(part: Part) -> tuple[Part, int]:
    """Remove triangles with corners that are not there, or not finite."""
    inside = np.all((part.triangles >= 0) & (part.triangles < len(part.points)), axis=1)
    corners = part.points[np.where(inside[:, None], part.triangles, 0)]
    good = inside & (np.abs(corners) < LARGEST).reshape(-1, 9).all(axis=1)  # False for NaN
    return _kept(part, good), int((~good).sum())


def _without_degenerate_triangles(part: Part) -> tuple[Part, int]:
    """Remove triangles without area."""
    corners = part.points[part.triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    good = np.linalg.norm(cross, axis=1) > 1e-12 * np.maximum(longest, 1e-30) ** 2
    return _kept(part, good), int((~good).sum())


def _without_twins(part: Part) -> tuple[Part, int]:
    """Remove triangles that are there twice, the same way round."""
    turned = np.stack([np.roll(row, shift, axis=1) for shift, row in enumerate([part.triangles] * 3)])
    first = turned[turned[:, :, 0].argmin(axis=0), np.arange(len(part.triangles))]
    _, kept = np.unique(first, axis=0, return_index=True)
    good = np.zeros(len(part.triangles), bool)
    good[kept] = True
    return _kept(part, good), int((~good).sum())


def _turned_right_side_out(part: Part) -> tuple[Part, int]:
    """Flip a closed part whose triangles all face inward."""
    if not len(part.triangles):
        return part, 0
    corners = part.points[part.triangles]
    corners -= corners.mean(axis=(0, 1))
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum()
    if volume >= 0.0 or not _is_closed(part):
        return part, 0
    flipped = part.flipped()
    return replace(flipped, normals=None if flipped.normals is None else -flipped.normals), 1


def _with_usable_normals(part: Part) -> tuple[Part, int]:
    """Drop normals that are zero or not finite; others are made of the triangles."""
    if part.normals is None:
        return part, 0
    lengths = np.linalg.norm(part.normals, axis=1)
    if np.isfinite(lengths).all() and (lengths > 1e-6).all():
        return part, 0
    return replace(part, normals=None), 1


_REPAIRS: dict[str, Callable[[Part], tuple[Part, int]]] = {
    "removed {} triangles with missing or infinite corners": _without_bad_triangles,
    "removed {} triangles without area": _without_degenerate_triangles,
    "removed {} doubled triangles": _without_twins,
    "turned {} closed parts right side out": _turned_right_side_out,
    "replaced the normals of {} parts, which were zero or infinite": _with_usable_normals,
}


def with_normals(part: Part) -> Part:
    """Return the part with a normal for each corner: its own, or smooth across edges that are nearly flat.

    Without some, large parts get none either: a surface of polygons is drawn flat then.
    """
    if part.normals is not None or len(part.triangles) > MAX_SMOOTHED:
        return part
    corners = part.points[part.triangles]
    weighted = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])  # by twice the area
    unit = weighted / np.maximum(np.linalg.norm(weighted, axis=1, keepdims=True), 1e-30)
    # Points at one place are one point, whatever their UVs.
    _, place = np.unique(part.points, axis=0, return_inverse=True)
    corner_place = place.ravel()[part.triangles].ravel()
    order = np.argsort(corner_place, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(corner_place[order]) > 0])
    normals = np.empty((len(corner_place), 3))
    for begin, end in zip(starts, np.r_[starts[1:], len(order)]):
        around = order[begin:end]
        faces = around // 3
        near = unit[faces] @ unit[faces].T >= SMOOTH
        normals[around] = near @ weighted[faces]
    return replace(part, normals=normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30))


def _is_closed(part: Part) -> bool:
    """Whether each edge has one triangle on either side; points at one place count as one."""
    _, place = np.unique(part.points, axis=0, return_inverse=True)
    triangles = place.ravel()[part.triangles]
    start, end = triangles.astype(np.int64).T, np.roll(triangles, -1, axis=1).astype(np.int64).T
    count = int(place.max()) + 1
    # Each edge as one number: sorting these is ten times as fast as sorting pairs.
    return np.array_equal(np.sort((start * count + end).ravel()), np.sort((end * count + start).ravel()))


def _kept(part: Part, good: np.ndarray) -> Part:
    """Return the part with some of its triangles."""
    if good.all():
        return part
    corners = np.repeat(good, 3)

    def rows(values: np.ndarray | None) -> np.ndarray | None:
        is_per_corner = values is not None and len(values) == len(corners) != len(part.points)
        return values[corners] if values is not None and is_per_corner else values

    kept = {name: rows(getattr(part, name)) for name in ("normals", "uvs", "colors")}
    return replace(part, triangles=part.triangles[good], **kept)
