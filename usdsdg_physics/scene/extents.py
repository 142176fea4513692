"""Extents of collision shapes: bounding spheres, world boxes, thickness."""

from collections.abc import Iterable, Mapping
from itertools import product

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.scene.records import Collider, Shape


def bounding_sphere(shape: Shape) -> tuple[float, float, float, float]:
    """Return center and radius of a sphere around a shape, in the shape's own frame; a plane's radius is inf."""
    a, b, c = shape.size
    if shape.kind == "plane":
        return 0.0, 0.0, 0.0, float("inf")
    if shape.solid is not None:
        assert shape.solid is not None  # a hull or mesh has one
        points = shape.solid.vertices.astype(np.float64) * shape.size
        center = (points.min(axis=0) + points.max(axis=0)) / 2.0
        return (*center.tolist(), float(np.linalg.norm(points - center, axis=1).max()) * (1 + 1e-9))
    radius = {
        "box": np.sqrt(a * a + b * b + c * c),
        "sphere": a,
        "capsule": a + b,
        "cylinder": np.hypot(a, b),
        "cone": np.hypot(a, b),
    }[shape.kind]
    return 0.0, 0.0, 0.0, float(radius) * (1 + 1e-9)


def local_box(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner of the box around a shape, in the shape's own frame; a plane's are infinite."""
    a, b, c = shape.size
    if shape.kind == "plane":
        return np.full(3, -np.inf), np.full(3, np.inf)
    if shape.solid is not None:
        points = shape.solid.vertices.astype(np.float64) * shape.size
        return points.min(axis=0), points.max(axis=0)
    half = {
        "box": (a, b, c),
        "sphere": (a, a, a),
        "capsule": (a, a, a + b),
        "cylinder": (a, a, b),
        "cone": (a, a, b),
    }[shape.kind]
    return -np.array(half), np.array(half)


def half_thickness(shape: Shape) -> float:
    """Return half of the smallest extent along the shape's own axes [m]."""
    a, b, c = shape.size
    if shape.solid is not None:
        assert shape.solid is not None  # a hull or mesh has one
        points = shape.solid.vertices * shape.size
        return float((points.max(axis=0) - points.min(axis=0)).min()) / 2.0
    if shape.kind == "box":
        return min(a, b, c)
    return a if shape.kind in ("sphere", "capsule") else min(a, b)


def half_thicknesses(
    colliders: Iterable[Collider], shape_index: Mapping[str, int], count: int, *, least: float = 0.0
) -> np.ndarray:
    """Return (count,) float32 [m]: `half_thickness` by shape index, at least `least`; zero of shapes that are none."""
    found = np.zeros(count, np.float32)
    for collider in colliders:
        found[shape_index[collider.path]] = max(half_thickness(collider.shape), least)
    return found


def length(shape: Shape) -> float:
    """Return the largest extent along the shape's own axes [m]."""
    a, b, c = shape.size
    if shape.kind == "plane":
        return float("inf")
    if shape.solid is not None:
        points = shape.solid.vertices * shape.size
        return float((points.max(axis=0) - points.min(axis=0)).max())
    return 2.0 * float(a + b if shape.kind == "capsule" else max(a, b, c))


def world_box(shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner of the box around a hull or mesh [m], in the world or its body's frame."""
    assert shape.solid is not None  # a hull or mesh has one
    points = shape.solid.vertices.astype(np.float64) * shape.size @ matrix_from_quat(shape.rotation) + shape.position
    return points.min(axis=0), points.max(axis=0)


def body_boxes(bodies: Iterable[str], colliders: Iterable[Collider]) -> np.ndarray:
    """Return (N, 2, 3) [m]: lower and upper corner of the box around the solid colliders of each body, in its frame.

    Bodies without any have their origin.
    """
    corners: dict[str, list[np.ndarray]] = {path: [] for path in bodies}
    for collider in colliders:
        if collider.body in corners and not collider.trigger:
            shape = collider.shape
            found = np.array(list(product(*zip(*local_box(shape)))))
            corners[collider.body].append(found @ matrix_from_quat(shape.rotation) + shape.position)
    points = [np.concatenate(found) if found else np.zeros((1, 3)) for found in corners.values()]
    return np.array([(each.min(axis=0), each.max(axis=0)) for each in points]).reshape(-1, 2, 3)
