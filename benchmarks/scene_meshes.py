"""The benchmark scene in the forms that other renderers take: one flattened mesh, or welded ones, and poses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from usdsdg_render.scene.scene import Prototype, Scene


class FlatMesh(NamedTuple):
    """All instances in the world as one mesh."""

    points: np.ndarray  # (V, 3) float32
    triangles: np.ndarray  # (T, 3) int32
    instance: np.ndarray  # (T,) int32: instance of each triangle
    first: np.ndarray  # (instances,) int32: first triangle of each instance


class WeldedMesh(NamedTuple):
    """A prototype with one normal and UV per point; corners that differ have points of their own."""

    points: np.ndarray  # (V, 3) float32
    normals: np.ndarray  # (V, 3) float32
    uvs: np.ndarray  # (V, 2) float32
    triangles: np.ndarray  # (T, 3) int32


def flattened(scene: Scene) -> FlatMesh:
    """Return the triangles of all instances in the world, in the order of instances."""
    points, triangles, counts, base = [], [], [], 0
    for which, matrix in zip(scene.instances.prototype, scene.instances.local_to_world, strict=True):
        prototype = scene.prototypes[which]
        points.append(transformed(prototype.points, matrix))
        triangles.append(prototype.triangles + base)
        counts.append(len(prototype.triangles))
        base += len(prototype.points)
    instance = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    first = np.append(0, np.cumsum(counts)[:-1]).astype(np.int32)
    return FlatMesh(np.concatenate(points), np.concatenate(triangles).astype(np.int32), instance, first)


def transformed(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Return points (V, 3) float32 transformed by a row-vector 4x4 matrix."""
    return (points @ matrix[:3, :3] + matrix[3, :3]).astype(np.float32)


def welded(prototype: Prototype) -> WeldedMesh:
    """Weld the corners that share point, normal and UV."""
    corners = np.concatenate(
        [
            prototype.triangles.reshape(-1, 1).astype(np.float32),
            prototype.normals.reshape(-1, 3),
            prototype.uvs.reshape(-1, 2),
        ],
        axis=1,
    )
    kept, triangles = np.unique(corners, axis=0, return_inverse=True)
    points = prototype.points[kept[:, 0].astype(int)]
    return WeldedMesh(points, kept[:, 1:4].copy(), kept[:, 4:].copy(), triangles.reshape(-1, 3).astype(np.int32))


def is_flat(prototype: Prototype) -> bool:
    """Return whether every triangle has one normal."""
    return bool(np.allclose(prototype.normals, prototype.normals[:, :1]))


def scale_and_rotation(matrix: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the uniform scale, and the rotation for column vectors, of a row-vector matrix."""
    scale = float(np.linalg.norm(matrix[0, :3]))
    return scale, matrix[:3, :3].T / scale


def material_of(scene: Scene, instance: int) -> int:
    """Return the row of an instance's first material."""
    return int(scene.material_slots[scene.instances.slot_offset[instance]])


def turned_sky(radiance: np.ndarray) -> np.ndarray:
    """Return a dome's image for renderers whose u falls from 1/2 as the direction turns from +x to +y."""
    return np.ascontiguousarray(np.roll(radiance[:, ::-1], radiance.shape[1] // 2, 1))
