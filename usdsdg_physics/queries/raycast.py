"""One ray against one shape, in the shape's own frame."""

from __future__ import annotations

import numpy as np

from usdsdg_physics.scene.records import Shape

Hit = tuple[float, np.ndarray]  # distance along the ray, outward normal (3,)


def ray_distance(shape: Shape, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    """First hit of a ray with unit direction; distance 0 when it starts inside a solid."""
    if shape.kind == "plane":
        return _half_spaces(np.array([[0.0, 0.0, 1.0]]), np.zeros(1), origin, direction)
    if shape.kind == "box":
        normals = np.concatenate([np.eye(3), -np.eye(3)])
        return _half_spaces(normals, np.tile(shape.size, 2), origin, direction)
    if shape.kind == "hull":
        return _half_spaces(*_planes(shape), origin, direction)
    if shape.kind == "mesh":
        return _triangles(shape, origin, direction)
    return _round(shape, origin, direction)


def _half_spaces(normals: np.ndarray, offsets: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    """The solid of all points with normal · p <= offset."""
    speed, height = normals @ direction, offsets - normals @ origin
    if (height[speed == 0.0] < 0.0).any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        at = height / speed
    entering = np.where(speed < 0.0, at, -np.inf)
    leaving = np.where(speed > 0.0, at, np.inf)
    enter = int(entering.argmax())
    if entering[enter] > leaving.min() or leaving.min() < 0.0:
        return None
    if entering[enter] < 0.0:
        return 0.0, -direction
    return float(entering[enter]), normals[enter]


def _planes(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    points = shape.solid.vertices.astype(np.float64) * shape.size
    a, b, c = (points[shape.solid.triangles[:, corner]] for corner in range(3))
    normals = np.cross(b - a, c - a)
    if np.prod(shape.size) < 0:
        normals = -normals
    length = np.linalg.norm(normals, axis=1)
    keep = length > 1e-12 * length.max()
    normals = normals[keep] / length[keep, None]
    return normals, np.einsum("ij,ij->i", normals, a[keep])


def _triangles(shape: Shape, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    points = shape.solid.vertices.astype(np.float64) * shape.size
    a, b, c = (points[shape.solid.triangles[:, corner]] for corner in range(3))
    along, across = b - a, c - a
    p = np.cross(direction, across)
    det = np.einsum("ij,ij->i", along, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - a
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, along)
        v = (q @ direction) / det
        t = np.einsum("ij,ij->i", across, q) / det
        good = (np.abs(det) > 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t >= 0.0)
    if not good.any():
        return None
    first = int(np.where(good, t, np.inf).argmin())
    normal = np.cross(along[first], across[first])
    normal /= np.linalg.norm(normal)
    return float(t[first]), -normal if normal @ direction > 0.0 else normal


def _round(shape: Shape, origin: np.ndarray, direction: np.ndarray) -> Hit | None:
    """Sphere, capsule, cylinder and cone: the nearest root of their surfaces."""
    if _inside(shape, origin):
        return 0.0, -direction
    found = [
        (float(t), np.asarray(normal(origin + t * direction)))
        for roots, normal, valid in _surfaces(shape, origin, direction)
        for t in roots
        if t >= 0.0 and valid(origin + t * direction)
    ]
    if not found:
        return None
    distance, normal = min(found, key=lambda hit: hit[0])
    return distance, normal / np.linalg.norm(normal)


def _inside(shape: Shape, p: np.ndarray) -> bool:
    radius, half, _ = shape.size
    across = float(np.hypot(p[0], p[1]))
    if shape.kind == "sphere":
        return float(np.linalg.norm(p)) < radius
    if shape.kind == "capsule":
        return float(np.hypot(across, max(abs(p[2]) - half, 0.0))) < radius
    if shape.kind == "cylinder":
        return across < radius and abs(p[2]) < half
    return abs(p[2]) < half and across < radius * (half - p[2]) / (2.0 * half)


def _surfaces(shape: Shape, o: np.ndarray, d: np.ndarray):
    """(roots along the ray, normal at a point, whether a point belongs) of each piece of the surface."""
    radius, half, _ = shape.size
    flat = np.array([1.0, 1.0, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    if shape.kind == "sphere":
        yield _sphere_roots(o, d, radius), lambda p: p, lambda p: True
    elif shape.kind == "capsule":
        yield _roots((d * flat) @ d, (o * flat) @ d, (o * flat) @ o - radius**2), lambda p: p * flat, _between(half)
        for end in (half, -half):
            yield _sphere_roots(o - end * up, d, radius), lambda p, e=end: p - e * up, lambda p: True
    elif shape.kind == "cylinder":
        yield _roots((d * flat) @ d, (o * flat) @ d, (o * flat) @ o - radius**2), lambda p: p * flat, _between(half)
        for end in (half, -half):
            yield _cap_root(o, d, end), lambda p, e=end: e * up, lambda p: np.hypot(p[0], p[1]) <= radius
    else:
        # x² + y² = k² (half - z)²
        k2 = (radius / (2.0 * half)) ** 2
        apex, metric = o - half * up, np.array([1.0, 1.0, -k2])
        roots = _roots((d * metric) @ d, (apex * metric) @ d, (apex * metric) @ apex)
        yield roots, lambda p: np.array([p[0], p[1], k2 * (half - p[2])]), _between(half)
        yield _cap_root(o, d, -half), lambda p: -up, lambda p: np.hypot(p[0], p[1]) <= radius


def _between(half: float):
    return lambda p: abs(p[2]) <= half


def _cap_root(o: np.ndarray, d: np.ndarray, height: float) -> list[float]:
    return [(height - o[2]) / d[2]] if d[2] != 0.0 else []


def _sphere_roots(o: np.ndarray, d: np.ndarray, radius: float) -> list[float]:
    return _roots(d @ d, o @ d, o @ o - radius**2)


def _roots(a: float, half_b: float, c: float) -> list[float]:
    """Real roots of a t² + 2 half_b t + c."""
    square = half_b * half_b - a * c
    if square < 0.0 or a == 0.0:
        return [] if a != 0.0 or half_b == 0.0 else [-c / (2.0 * half_b)]
    root = float(np.sqrt(square))
    return [(-half_b - root) / a, (-half_b + root) / a]
