"""Questions about where bodies are: overlap with a box or sphere, and the nearest hit of a ray."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdsdg.stage.poses.transforms import matrix_from_quat, quat_from_matrix
from usdsdg_physics.queries.raycast import ray_distance
from usdsdg_physics.scene.extents import bounding_sphere
from usdsdg_physics.scene.records import Scene, Shape


@dataclass(frozen=True)
class Overlap:
    """A collider that touches the asked volume.

    rigid_body: path of the body that owns it; of the collider itself when it is static, as PhysX reports it.
    """

    rigid_body: str
    collision: str


@dataclass(frozen=True)
class RayHit:
    rigid_body: str
    collision: str
    distance: float  # stage units
    position: tuple[float, float, float]  # world, stage units
    normal: tuple[float, float, float]  # world, unit length, against the ray

    def scaled(self, factor: float) -> RayHit:
        """The same hit with lengths in another unit."""
        x, y, z = self.position
        return replace(self, distance=self.distance * factor, position=(x * factor, y * factor, z * factor))


class Queries:
    """Tables of one scene's colliders; where its bodies are is given with each question. Lengths are in metres."""

    def __init__(self, scene: Scene) -> None:
        self._colliders = list(scene.colliders.values())
        rows = {path: row for row, path in enumerate(scene.bodies)}
        self._body = np.array([rows.get(c.body, -1) for c in self._colliders], np.int64)
        self._rotation = np.array([matrix_from_quat(c.shape.rotation) for c in self._colliders]).reshape(-1, 3, 3)
        self._position = np.array([c.shape.position for c in self._colliders], np.float64).reshape(-1, 3)
        self._enabled = np.array([c.enabled for c in self._colliders], bool)
        self._row = {c.path: row for row, c in enumerate(self._colliders)}
        self._bounds = np.array([bounding_sphere(c.shape) for c in self._colliders], np.float64).reshape(-1, 4)
        # In path order, so that a script's random numbers meet the same hits in every run.
        self._sorted = np.array(sorted(range(len(self._colliders)), key=lambda row: self._colliders[row].path), int)
        self._tables: tuple | None = None

    def set_enabled(self, path: str, enabled: bool) -> None:
        self._enabled[self._row[path]] = enabled

    def set_pose(self, path: str, shape: Shape) -> None:
        """Take over the pose of a collider's shape, in its body's frame or the world."""
        row = self._row[path]
        self._rotation[row] = matrix_from_quat(shape.rotation)
        self._position[row] = shape.position

    def overlap_box(
        self, poses: np.ndarray, half_extent: Sequence[float], origin: Sequence[float], rotation: Sequence[float]
    ) -> list[Overlap]:
        """Colliders that share a point with a box; `poses` (N, 7) are the bodies'."""
        return self._overlap(poses, 0, half_extent, float(np.linalg.norm(half_extent)), origin, rotation)

    def overlap_sphere(self, poses: np.ndarray, radius: float, origin: Sequence[float]) -> list[Overlap]:
        """Colliders that share a point with a sphere."""
        return self._overlap(poses, 1, (radius, 0.0, 0.0), radius, origin, (0.0, 0.0, 0.0, 1.0))

    def raycast(
        self, poses: np.ndarray, origin: Sequence[float], direction: Sequence[float], distance: float
    ) -> RayHit | None:
        """The nearest hit within `distance`, None for none. A ray that starts inside a shape hits it at distance 0."""
        start = np.asarray(origin, np.float64)
        along_ray = np.asarray(direction, np.float64) / np.linalg.norm(direction)
        rotation, position = self._frames(poses)
        centers = np.einsum("ni,nij->nj", self._bounds[:, :3], rotation) + position
        along = np.clip((centers - start) @ along_ray, 0.0, distance)
        gap = np.linalg.norm(start + along[:, None] * along_ray - centers, axis=1)
        best: tuple[float, int, np.ndarray] | None = None
        for row in self._sorted[(self._enabled & (gap <= self._bounds[:, 3]))[self._sorted]]:
            local_origin = rotation[row] @ (start - position[row])
            found = ray_distance(self._colliders[row].shape, local_origin, rotation[row] @ along_ray)
            if (
                found is not None
                and found[0] <= (best[0] if best else distance)
                and (best is None or found[0] < best[0])
            ):
                best = found[0], row, found[1] @ rotation[row]
        if best is None:
            return None
        length, row, normal = best
        hit = self._hit(row)
        point = start + length * along_ray
        return RayHit(hit.rigid_body, hit.collision, length, tuple(point.tolist()), tuple(normal.tolist()))

    def _overlap(
        self,
        poses: np.ndarray,
        kind: int,
        size: Sequence[float],
        reach: float,
        origin: Sequence[float],
        rotation_xyzw: Sequence[float],
    ) -> list[Overlap]:
        if not self._colliders:
            return []
        import warp as wp

        from usdsdg_physics.queries import overlap_kernels

        rotation, position = self._frames(poses)
        candidates = self._near_box(rotation, position, kind, np.asarray(size, float), reach, origin, rotation_xyzw)
        if not len(candidates):
            return []
        frames = np.concatenate([position, quat_from_matrix(rotation)], axis=1)
        hit = wp.zeros(len(candidates), dtype=wp.int32, device="cpu")
        kinds, sizes, first, counts, points = self._device_tables()
        wp.launch(
            overlap_kernels.overlaps,
            dim=len(candidates),
            inputs=[
                kinds,
                sizes,
                wp.array(frames, dtype=wp.transformd, device="cpu"),
                first,
                counts,
                points,
                wp.array(candidates, dtype=wp.int32, device="cpu"),
                kind,
                wp.vec3d(*(float(x) for x in size)),
                wp.transformd(wp.vec3d(*map(float, origin)), wp.quatd(*map(float, rotation_xyzw))),
            ],
            outputs=[hit],
            device="cpu",
        )
        return [self._hit(row) for row in candidates[hit.numpy() != 0]]

    def _near_box(
        self,
        rotation: np.ndarray,
        position: np.ndarray,
        kind: int,
        size: np.ndarray,
        reach: float,
        origin: Sequence[float],
        rotation_xyzw: Sequence[float],
    ) -> np.ndarray:
        """Rows, in path order, of switched-on colliders whose bounding sphere reaches the volume."""
        centers = np.einsum("ni,nij->nj", self._bounds[:, :3], rotation) + position - np.asarray(origin, float)
        if kind == 0:
            inside = centers @ matrix_from_quat(rotation_xyzw).T
            gap = np.linalg.norm(np.maximum(np.abs(inside) - size, 0.0), axis=1)
        else:
            gap = np.linalg.norm(centers, axis=1) - reach
        near = self._enabled & (gap <= self._bounds[:, 3])
        return self._sorted[near[self._sorted]].astype(np.int32)

    def _frames(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """World rotations (N, 3, 3) and positions (N, 3) of all shapes."""
        rotation, position = self._rotation.copy(), self._position.copy()
        owned = self._body >= 0
        if owned.any():
            body = np.asarray(poses, np.float64)[self._body[owned]]
            turn = matrix_from_quat(body[:, 3:])
            position[owned] = np.einsum("ni,nij->nj", position[owned], turn) + body[:, :3]
            rotation[owned] = rotation[owned] @ turn
        return rotation, position

    def _hit(self, row: int) -> Overlap:
        collider = self._colliders[row]
        return Overlap(collider.body or collider.path, collider.path)

    def _device_tables(self) -> tuple:
        if self._tables is None:
            import warp as wp

            from usdsdg_physics.queries.overlap_kernels import KINDS

            kinds, sizes, first, counts, points = [], [], [], [], [np.zeros((1, 3))]
            start: dict[str, int] = {}
            total = 1
            for collider in self._colliders:
                shape = collider.shape
                kinds.append(KINDS.index(shape.kind))
                sizes.append(shape.size)
                corners = _corners(shape)
                key = shape.solid.key if shape.solid else ""
                if key not in start:
                    start[key] = total
                    points.append(corners)
                    total += len(corners)
                first.append(start[key])
                counts.append(len(corners))
            self._tables = (
                wp.array(kinds, dtype=wp.int32, device="cpu"),
                wp.array(np.array(sizes, np.float64), dtype=wp.vec3d, device="cpu"),
                wp.array(first, dtype=wp.int32, device="cpu"),
                wp.array(counts, dtype=wp.int32, device="cpu"),
                wp.array(np.concatenate(points).astype(np.float64), dtype=wp.vec3d, device="cpu"),
            )
        return self._tables


def _corners(shape: Shape) -> np.ndarray:
    if shape.solid is None:
        return np.zeros((0, 3))
    if shape.kind == "mesh":
        return shape.solid.vertices[shape.solid.triangles.ravel()]
    return shape.solid.vertices
