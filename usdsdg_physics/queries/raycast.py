"""Intersect a ray with one shape, in the shape's own frame."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from usdsdg_physics.scene.records import Shape, Solid, Vec3

Scalar = Any  # a number; NumPy's stubs give `vector @ vector` the type of an array

Hit = tuple[float, np.ndarray, int]  # distance along the ray, outward normal (3,), triangle of a mesh or -1
# Roots along the ray, a function of a point that gives the normal, and one that tells whether it is on the surface.
Surface = tuple[list[float], Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], bool]]

# Part of a triangle's edges by which it is larger, so that rounding lets no ray through between two of them.
_SEAM = 1e-9
# Part of its length by which a ray may miss a round surface and touch it: rounding would let it in at a cone's apex.
_TOUCH = 1e-12
# Part of its height below the apex of a cone from which on rounding makes its normal.
_APEX = 1e-9


def ray_distance(shape: Shape, origin: np.ndarray, direction: np.ndarray, *, both_sides: bool = True) -> Hit | None:
    """Return the first hit of a ray with unit direction, None for none; distance 0 when it starts inside a solid.

    Triangles of a mesh that face along the ray are hit if `both_sides`; their normal is against the ray.
    """
    if shape.kind == "plane":
        return _half_spaces(np.array([[0.0, 0.0, 1.0]]), np.zeros(1), origin, direction)
    if shape.kind == "box":
        normals = np.concatenate([np.eye(3), -np.eye(3)])
        return _half_spaces(normals, np.tile(shape.size, 2), origin, direction)
    if shape.kind == "hull":
        assert shape.solid is not None  # a hull has one
        return _half_spaces(*_planes(shape.solid, shape.size), origin, direction)
    if shape.kind == "mesh":
        return _triangles(shape, origin, direction, both_sides)
    return _quadric(shape, origin, direction)


def _half_spaces(normals: np.ndarray, offsets: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    """Intersect the convex solid of all points p with normal · p <= offset."""
    slope, distance = normals @ direction, offsets - normals @ origin
    if (distance[slope == 0.0] < 0.0).any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        t = distance / slope
    entering = np.where(slope < 0.0, t, -np.inf)
    leaving = np.where(slope > 0.0, t, np.inf)
    enter = int(entering.argmax())
    if entering[enter] > leaving.min() or leaving.min() < 0.0:
        return None
    if entering[enter] < 0.0:
        return 0.0, -direction, -1
    return float(entering[enter]), normals[enter], -1


@lru_cache(maxsize=1024)
def _planes(solid: Solid, size: Vec3) -> tuple[np.ndarray, np.ndarray]:
    """Return outward normals (F, 3) and distances (F,) from the origin of the faces of a scaled hull."""
    points = solid.vertices.astype(np.float64) * size
    a, b, c = (points[solid.triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    if np.prod(size) < 0:
        normals = -normals
    length = np.linalg.norm(normals, axis=1)
    keep = length > 1e-12 * length.max()
    normals = normals[keep] / length[keep, None]
    return normals, np.einsum("ij,ij->i", normals, a[keep])


def _triangles(shape: Shape, origin: np.ndarray, direction: np.ndarray, both_sides: bool) -> Hit | None:
    assert shape.solid is not None  # a hull or mesh has one
    points = shape.solid.vertices.astype(np.float64) * shape.size
    a, b, c = (points[shape.solid.triangles[:, corner]] for corner in range(3))
    # Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
    edge1, edge2 = b - a, c - a
    p = np.cross(direction, edge2)
    det = np.einsum("ij,ij->i", edge1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - a
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, edge1)
        v = (q @ direction) / det
        t = np.einsum("ij,ij->i", edge2, q) / det
        # The determinant is positive where a triangle faces the ray.
        hit_sides = (np.abs(det) if both_sides else det * np.sign(np.prod(shape.size))) > 0.0
        valid = hit_sides & (np.minimum(u, v) >= -_SEAM) & (u + v <= 1.0 + _SEAM) & (t >= 0.0)
    if not valid.any():
        return None
    first = int(np.where(valid, t, np.inf).argmin())
    normal = np.cross(edge1[first], edge2[first])
    normal /= np.linalg.norm(normal)
    return float(t[first]), -normal if normal @ direction > 0.0 else normal, first


def _quadric(shape: Shape, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    """Intersect a sphere, capsule, cylinder or cone: the nearest valid root of its surfaces."""
    if _inside(shape, origin):
        return 0.0, -direction, -1
    found = [
        (float(t), np.asarray(normal(origin + t * direction)))
        for roots, normal, valid in _surfaces(shape, origin, direction)
        for t in roots
        if t >= 0.0 and valid(origin + t * direction)
    ]
    if not found:
        return None
    distance, normal = min(found, key=lambda hit: hit[0])
    return distance, normal / np.linalg.norm(normal), -1


def _inside(shape: Shape, p: np.ndarray) -> bool:
    radius, half, _ = shape.size
    radial = float(np.hypot(p[0], p[1]))
    if shape.kind == "sphere":
        return float(np.linalg.norm(p)) < radius
    if shape.kind == "capsule":
        return float(np.hypot(radial, max(abs(p[2]) - half, 0.0))) < radius
    if shape.kind == "cylinder":
        return radial < radius and abs(p[2]) < half
    return abs(p[2]) < half and radial < radius * (half - p[2]) / (2.0 * half)


def _surfaces(shape: Shape, o: np.ndarray, d: np.ndarray) -> Iterator[Surface]:
    """Yield the surfaces that bound a shape."""
    radius, half, _ = shape.size
    xy = np.array([1.0, 1.0, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    if shape.kind == "sphere":
        yield _sphere_roots(o, d, radius), lambda p: p, lambda p: True
    elif shape.kind == "capsule":
        yield _roots((d * xy) @ d, (o * xy) @ d, (o * xy) @ o - radius**2), lambda p: p * xy, _between(half)
        for end in (half, -half):
            yield _sphere_roots(o - end * up, d, radius), lambda p, e=end: p - e * up, lambda p: True
    elif shape.kind == "cylinder":
        yield _roots((d * xy) @ d, (o * xy) @ d, (o * xy) @ o - radius**2), lambda p: p * xy, _between(half)
        for end in (half, -half):
            yield _cap_root(o, d, end), lambda p, e=end: e * up, lambda p: np.hypot(p[0], p[1]) <= radius
    else:
        # x² + y² = k² (half - z)²
        k2 = (radius / (2.0 * half)) ** 2
        apex, metric = o - half * up, np.array([1.0, 1.0, -k2])
        roots = _roots((d * metric) @ d, (apex * metric) @ d, (apex * metric) @ apex)
        yield roots, lambda p: _cone_normal(p, k2, half, d), _between(half)
        yield _cap_root(o, d, -half), lambda p: -up, lambda p: np.hypot(p[0], p[1]) <= radius


def _cone_normal(p: np.ndarray, k2: float, half: float, direction: np.ndarray) -> np.ndarray:
    """Return a normal, of no particular length, at a point on the side of a cone; the apex has many."""
    if half - p[2] > _APEX * half:
        return np.array([p[0], p[1], k2 * (half - p[2])])
    return np.array([0.0, 0.0, 1.0]) if direction[2] < 0.0 else -direction


def _between(half: float) -> Callable[[np.ndarray], bool]:
    return lambda p: abs(p[2]) <= half * (1.0 + _TOUCH)


def _cap_root(o: np.ndarray, d: np.ndarray, height: float) -> list[float]:
    return [(height - o[2]) / d[2]] if d[2] != 0.0 else []


def _sphere_roots(o: np.ndarray, d: np.ndarray, radius: float) -> list[float]:
    return _roots(d @ d, o @ d, o @ o - radius**2)


def _roots(a: Scalar, half_b: Scalar, c: Scalar) -> list[float]:
    """Return the real roots of a t² + 2 half_b t + c."""
    discriminant = half_b * half_b - a * c
    if discriminant < -_TOUCH * half_b * half_b or a == 0.0:
        return [] if a != 0.0 or half_b == 0.0 else [-c / (2.0 * half_b)]
    root = float(np.sqrt(max(0.0, discriminant)))
    return [(-half_b - root) / a, (-half_b + root) / a]
