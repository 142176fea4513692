"""Surfaces of revolution about the z axis: bottles, cans, cones, wheels."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdsdg.demo.shapes.surface import Surface, from_grid, joined, unit


def lathe(
    profile: Sequence[tuple[float, float]], material: str, *, segments: int = 40, crease: float = 35.0
) -> Surface:
    """Revolve a profile of (radius, z) pairs [m], listed from bottom to top along the outside.

    s goes once around, starting at -y and growing toward +x, so that the middle of a label (s = 0.5) faces +y;
    t is the height from 0 at the lowest to 1 at the highest point of the profile. Corners of the profile that turn
    by more than `crease` degrees stay sharp.
    """
    outline = np.asarray(profile, dtype=float)
    below, above = _outline_normals(outline, crease)
    # Every profile point occurs twice, once per adjacent segment, so that each side can have its own normal.
    doubled = np.repeat(outline, 2, axis=0)[1:-1]
    outward = np.stack([above[:-1], below[1:]], axis=1).reshape(-1, 2)
    around = np.linspace(0.0, 1.0, segments + 1)
    angle = -0.5 * np.pi + 2.0 * np.pi * around
    cos, sin = np.cos(angle), np.sin(angle)
    points = _turn(doubled, cos, sin)
    normals = _turn(outward, cos, sin)
    low, high = outline[:, 1].min(), outline[:, 1].max()
    height = (doubled[:, 1] - low) / max(high - low, 1e-9)
    st = np.stack(np.broadcast_arrays(around[None, :], height[:, None]), axis=-1)
    strips = [slice(row, row + 2) for row in range(0, len(doubled), 2)]
    return _strips(points, normals, st, strips, material)


def rounded_profile(corners: Sequence[tuple[float, float]], radius: float, steps: int = 4) -> list[tuple[float, float]]:
    """Round the inner corners of a profile by quadratic arcs that start `radius` [m] before each corner."""
    outline = np.asarray(corners, dtype=float)
    result = [outline[0]]
    for before, corner, after in zip(outline, outline[1:], outline[2:]):
        start = corner + (before - corner) * min(0.5, radius / max(np.linalg.norm(before - corner), 1e-9))
        end = corner + (after - corner) * min(0.5, radius / max(np.linalg.norm(after - corner), 1e-9))
        for weight in np.linspace(0.0, 1.0, steps + 1):
            result.append((1 - weight) ** 2 * start + 2 * weight * (1 - weight) * corner + weight**2 * end)
    return [tuple(point) for point in [*result, outline[-1]]]


def superellipse(surface: Surface, exponent: float) -> Surface:
    """Map the cross sections of a lathe of radius one to superellipses |x|^n + |y|^n = 1 with n = `exponent`."""
    radius = np.linalg.norm(surface.points[:, :2], axis=1, keepdims=True)
    flat = surface.points[:, :2] / np.where(radius > 0.0, radius, 1.0)
    power = (np.abs(flat) ** exponent).sum(axis=1, keepdims=True)
    stretch = np.where(radius > 0.0, power, 1.0) ** (-1.0 / exponent)
    points = np.concatenate([surface.points[:, :2] * stretch, surface.points[:, 2:]], axis=1)
    leaning = np.linalg.norm(surface.normals[:, :2], axis=1, keepdims=True)
    toward = surface.normals[:, :2] / np.where(leaning > 0.0, leaning, 1.0)
    outward = surface.points[surface.indices, :2]
    gradient = unit(np.sign(outward) * np.abs(outward) ** (exponent - 1.0))
    side = np.sign((toward * outward).sum(axis=1, keepdims=True))
    normals = unit(np.concatenate([leaning * side * gradient, surface.normals[:, 2:]], axis=1))
    return replace(surface, points=points, normals=normals)


def cylinder(radius: float, height: float, material: str, *, segments: int = 24, rim: float = 0.0) -> Surface:
    """A closed cylinder along z from z = 0, with rims rounded by `rim` [m]."""
    corners = [(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)]
    return lathe(rounded_profile(corners, rim) if rim > 0.0 else corners, material, segments=segments)


def _turn(pairs: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> np.ndarray:
    return np.stack(
        [
            pairs[:, :1] * cos[None, :],
            pairs[:, :1] * sin[None, :],
            np.broadcast_to(pairs[:, 1:], (len(pairs), len(cos))),
        ],
        axis=-1,
    )


def _outline_normals(outline: np.ndarray, crease: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the (radial, z) normals of every profile point for its lower and for its upper segment."""
    along = np.diff(outline, axis=0)
    outward = unit(np.stack([along[:, 1], -along[:, 0]], axis=1))
    below = np.concatenate([outward[:1], outward])
    above = np.concatenate([outward, outward[-1:]])
    smooth = (below * above).sum(axis=1) > np.cos(np.radians(crease))
    mean = unit(below + above)
    return np.where(smooth[:, None], mean, below), np.where(smooth[:, None], mean, above)


def _strips(points: np.ndarray, normals: np.ndarray, st: np.ndarray, strips: list[slice], material: str) -> Surface:
    return joined([from_grid(points[rows], normals[rows], st[rows], material) for rows in strips])
