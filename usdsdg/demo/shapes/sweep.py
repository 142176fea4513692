"""Shapes swept along a path or a direction: tubes, handles, prisms."""

from collections.abc import Sequence

import numpy as np

from usdsdg.demo.shapes.surface import Surface, from_grid, joined, unit


def tube(
    path: Sequence[Sequence[float]] | np.ndarray,
    radius: float | Sequence[float] | np.ndarray,
    material: str,
    *,
    sides: int = 12,
    flatten: float = 1.0,
) -> Surface:
    """A closed round tube of `radius` [m] (one, or one per path point) along a path of points [m].

    s goes around, t along. `flatten` scales the cross section along its second axis.
    """
    spine = np.asarray(path, dtype=float)
    radii = np.broadcast_to(np.asarray(radius, dtype=float), (len(spine),))
    ahead = unit(np.gradient(spine, axis=0))
    across, over = _frames(ahead)
    around = np.linspace(0.0, 1.0, sides + 1)
    angle = 2.0 * np.pi * around
    outward = (
        np.cos(angle)[None, :, None] * across[:, None, :] + flatten * np.sin(angle)[None, :, None] * over[:, None, :]
    )
    points = spine[:, None, :] + radii[:, None, None] * outward
    normals = unit(
        np.cos(angle)[None, :, None] * across[:, None, :] + np.sin(angle)[None, :, None] * over[:, None, :] / flatten
    )
    along = np.linspace(0.0, 1.0, len(spine))
    st = np.stack(np.broadcast_arrays(around[None, :], along[:, None]), axis=-1)
    wall = from_grid(points, normals, st, material)
    caps = [_cap(points[0, :-1][::-1], -ahead[0], 0.0, material), _cap(points[-1, :-1], ahead[-1], 1.0, material)]
    return joined([wall, *caps])


def arc(
    center: Sequence[float], radius: float, start: float, end: float, *, plane: str = "xz", steps: int = 16
) -> np.ndarray:
    """Return (steps + 1, 3) points [m] on a circle from `start` to `end` [degrees] in the plane "xy", "xz" or "yz"."""
    angle = np.radians(np.linspace(start, end, steps + 1))
    points = np.tile(np.asarray(center, dtype=float), (steps + 1, 1))
    first, second = ("xyz".index(axis) for axis in plane)
    points[:, first] += radius * np.cos(angle)
    points[:, second] += radius * np.sin(angle)
    return points


def prism(outline: Sequence[tuple[float, float]], depth: float, material: str) -> Surface:
    """Extrude a convex outline in (x, z) [m], counter-clockwise seen from -y, over y = -depth/2 … depth/2.

    The texture covers the outline's bounding box on the front (-y) and the back; the rim shows its center.
    """
    corners = np.asarray(outline, dtype=float)
    low, extent = corners.min(axis=0), np.ptp(corners, axis=0)
    st = (corners - low) / extent
    front = np.insert(corners, 1, -depth / 2.0, axis=1)
    back = np.insert(corners, 1, depth / 2.0, axis=1)
    mirrored = st * (-1, 1) + (1, 0)
    parts = [
        _polygon(front, (0.0, -1.0, 0.0), st, material),
        _polygon(back[::-1], (0.0, 1.0, 0.0), mirrored[::-1], material),
    ]
    for near, far in zip(range(len(corners)), np.roll(np.arange(len(corners)), -1)):
        quad = np.stack([front[near], back[near], back[far], front[far]])
        along = corners[far] - corners[near]
        outward = unit(np.array([along[1], 0.0, -along[0]]))
        parts.append(_polygon(quad, outward, np.full((4, 2), 0.5), material))
    return joined(parts)


def _frames(ahead: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit normals per path point: a rotation-minimizing frame."""
    start = np.eye(3)[np.argmin(np.abs(ahead[0]))]
    across = [unit(np.cross(ahead[0], start))]
    for direction in ahead[1:]:
        across.append(unit(across[-1] - (across[-1] @ direction) * direction))
    carried = np.array(across)
    return carried, np.cross(ahead, carried)


def _cap(ring: np.ndarray, outward: np.ndarray, along: float, material: str) -> Surface:
    return _polygon(ring, outward, np.tile((0.5, along), (len(ring), 1)), material)


def _polygon(points: np.ndarray, outward: Sequence[float] | np.ndarray, st: np.ndarray, material: str) -> Surface:
    return Surface(
        points=np.asarray(points, dtype=float),
        counts=np.array([len(points)]),
        indices=np.arange(len(points)),
        normals=np.tile(np.asarray(outward, dtype=float), (len(points), 1)),
        st=np.asarray(st, dtype=float),
        material=material,
    )
