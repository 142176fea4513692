"""Scene queries: the colliders that overlap a box or sphere, and the hits of a ray or of a moving box or sphere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.physics.instances import whole
from usdsdg.stage.poses.rotations import matrix_from_quat, quat_from_matrix
from usdsdg_physics.queries.raycast import ray_distance
from usdsdg_physics.scene.extents import bounding_sphere, local_box
from usdsdg_physics.scene.records import SHAPE_KINDS, Scene, Shape, ShapeKind

Vector = Sequence[float] | np.ndarray

if TYPE_CHECKING:
    import warp as wp

    from usdsdg_physics.queries.overlap_launch import OverlapLaunch


@dataclass(frozen=True)
class Overlap:
    """A collider that overlaps the volume of a query."""

    rigid_body: str  # path of the body that owns it; of the collider itself when it is static, as PhysX reports it
    collision: str  # path of the collider


@dataclass(frozen=True)
class RayHit:
    """Where a ray, or a shape that moves along it, meets a collider."""

    rigid_body: str  # as in `Overlap`
    collision: str
    distance: float  # stage units
    position: tuple[float, float, float]  # world, stage units
    normal: tuple[float, float, float]  # world, unit length, against the ray
    face: int = -1  # triangle of a mesh, -1 of other shapes

    def scaled(self, factor: float) -> RayHit:
        """Return the same hit with lengths times a factor."""
        x, y, z = self.position
        return replace(self, distance=self.distance * factor, position=(x * factor, y * factor, z * factor))


class SceneQueries:
    """Tables of one scene's colliders; every query takes the poses (N, 7) of its bodies. Lengths are in meters."""

    def __init__(self, scene: Scene) -> None:
        self._colliders = list(scene.colliders.values())
        rows = {path: row for row, path in enumerate(scene.bodies)}
        self._body = np.array([rows.get(c.body, -1) for c in self._colliders], np.int32)
        quats = np.array([c.shape.rotation for c in self._colliders], np.float64).reshape(-1, 4)
        self._rotation = matrix_from_quat(quats)
        self._position = np.array([c.shape.position for c in self._colliders], np.float64).reshape(-1, 3)
        self._frame = np.concatenate([self._position, quats], axis=1)
        self._enabled = np.array([c.enabled for c in self._colliders], bool)
        self._row = {c.path: row for row, c in enumerate(self._colliders)}
        self._bounds = np.array([bounding_sphere(c.shape) for c in self._colliders], np.float64).reshape(-1, 4)
        # In path order, so that a script's random numbers meet the same hits in every run.
        self._sorted = np.array(sorted(range(len(self._colliders)), key=lambda row: self._colliders[row].path), int)
        self._overlaps = [Overlap(c.body or whole(c.path), whole(c.path)) for c in self._colliders]
        self._has_parts = any(c.parts > 1 for c in self._colliders)
        self._box: tuple[np.ndarray, np.ndarray] | None = None  # lower and upper corners (N, 3), in the shape's frame
        self._tables: tuple[wp.array, ...] | None = None
        self._overlap_launch: OverlapLaunch | None = None
        self._placed: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None  # latest poses, and `_frames` of them

    def set_enabled(self, path: str, enabled: bool) -> None:
        """Switch a collider on or off."""
        self._enabled[self._row[path]] = enabled

    def set_pose(self, path: str, shape: Shape) -> None:
        """Set the pose of a collider from its shape, in its body's frame or the world."""
        row = self._row[path]
        self._rotation[row] = matrix_from_quat(shape.rotation)
        self._position[row] = shape.position
        self._frame[row] = *shape.position, *shape.rotation
        self._placed = None

    def overlap_box(self, poses: np.ndarray, half_extent: Vector, origin: Vector, rotation: Vector) -> list[Overlap]:
        """Return the enabled colliders that overlap a box, in path order."""
        return self._overlap(poses, "box", half_extent, origin, rotation)

    def overlap_sphere(self, poses: np.ndarray, radius: float, origin: Vector) -> list[Overlap]:
        """Return the enabled colliders that overlap a sphere, in path order."""
        return self._overlap(poses, "sphere", (radius, 0.0, 0.0), origin, (0.0, 0.0, 0.0, 1.0))

    def raycast(
        self, poses: np.ndarray, origin: Vector, direction: Vector, distance: float, *, both_sides: bool = True
    ) -> list[RayHit]:
        """Return the first hit of each enabled collider within `distance`, nearest first, then in path order.

        A ray that starts inside a solid hits it at distance 0. `both_sides` is that of `ray_distance`.
        """
        start = np.asarray(origin, np.float64)
        along_ray = np.asarray(direction, np.float64) / np.linalg.norm(direction)
        rotation, position = self._frames(poses)
        hits = []
        near = self._near_ray(rotation, position, start, along_ray, distance, 0.0)
        for row in near[self._ray_meets_box(near, rotation[near], position[near], start, along_ray, distance)]:
            shape, local_origin = self._colliders[row].shape, rotation[row] @ (start - position[row])
            found = ray_distance(shape, local_origin, rotation[row] @ along_ray, both_sides=both_sides)
            if found is not None and found[0] <= distance:
                point, normal = start + found[0] * along_ray, found[1] @ rotation[row]
                hits.append(self._ray_hit(row, found[0], point, normal, found[2]))
        return self._nearest_first(hits)

    def sweep(
        self,
        poses: np.ndarray,
        kind: ShapeKind,
        size: Vector,
        origin: Vector,
        rotation: Vector,
        direction: Vector,
        distance: float,
        *,
        both_sides: bool = True,
    ) -> list[RayHit]:
        """Return the first contact of each enabled collider with a moving box or sphere, nearest first, then by path.

        `size` is that of a `Shape`; a hit's distance is how far the shape moves, its position where the two touch. A
        shape that overlaps at the start has distance 0 and its own center as position.
        """
        if not self._colliders:
            return []
        import warp as wp

        from usdsdg_physics.queries import sweep_kernels

        start, along = np.asarray(origin, np.float64), np.asarray(direction, np.float64) / np.linalg.norm(direction)
        turned = np.asarray(rotation, np.float64) / np.linalg.norm(rotation)
        reach = float(np.linalg.norm(size)) if kind == "box" else float(size[0])
        rotations, positions = self._frames(poses)
        candidates = self._near_ray(rotations, positions, start, along, distance, reach).astype(np.int32)
        if not len(candidates):
            return []
        frames = np.concatenate([positions, quat_from_matrix(rotations)], axis=1)
        shape_kinds, sizes, first, counts, points = self._device_tables()
        distances = wp.zeros(len(candidates), dtype=wp.float64, device="cpu")
        normals, contacts = (wp.zeros(len(candidates), dtype=wp.vec3d, device="cpu") for _ in range(2))
        faces = wp.zeros(len(candidates), dtype=wp.int32, device="cpu")
        wp.launch(
            sweep_kernels.sweeps,
            dim=len(candidates),
            inputs=[
                shape_kinds,
                sizes,
                wp.array(frames, dtype=wp.transformd, device="cpu"),
                first,
                counts,
                points,
                wp.array(candidates, dtype=wp.int32, device="cpu"),
                SHAPE_KINDS.index(kind),
                wp.vec3d(*(float(x) for x in size)),
                wp.transformd(wp.vec3d(*start.tolist()), wp.quatd(*turned.tolist())),
                wp.vec3d(*along.tolist()),
                float(distance),
                int(both_sides),
            ],
            outputs=[distances, normals, contacts, faces],
            device="cpu",
        )
        hits = [
            self._ray_hit(row, float(length), contact, normal, int(face))
            for row, length, contact, normal, face in zip(
                candidates, distances.numpy(), contacts.numpy(), normals.numpy(), faces.numpy()
            )
            if length >= 0.0
        ]
        return self._nearest_first(hits)

    def overlapping_pairs(self, poses: np.ndarray, firsts: Sequence[str]) -> list[tuple[str, str]]:
        """Return the pairs of a convex collider among `firsts` and another enabled one, of another body, it overlaps.

        The pairs are in the order of `firsts` and then of paths; a disabled collider overlaps nothing.
        """
        rows = [self._row[path] for path in firsts if self._enabled[self._row[path]]]
        if not rows:
            return []
        import warp as wp

        from usdsdg_physics.queries import overlap_kernels

        rotation, position = self._frames(poses)
        centers = np.einsum("ni,nij->nj", self._bounds[:, :3], rotation) + position
        pairs = []
        for row in rows:
            reach = self._bounds[:, 3] + self._bounds[row, 3]
            near = self._enabled & (np.linalg.norm(centers - centers[row], axis=1) <= reach)
            near &= (self._body != self._body[row]) | (self._body < 0)
            near[row] = False
            others = self._sorted[near[self._sorted]]
            pairs.append(np.stack([np.full(len(others), row), others], axis=1))
        candidates = np.concatenate(pairs).astype(np.int32)
        if not len(candidates):
            return []
        frames = np.concatenate([position, quat_from_matrix(rotation)], axis=1)
        hit = wp.zeros(len(candidates), dtype=wp.int32, device="cpu")
        kinds, sizes, first, counts, points = self._device_tables()
        wp.launch(
            overlap_kernels.pairs_overlap,
            dim=len(candidates),
            inputs=[
                kinds,
                sizes,
                wp.array(frames, dtype=wp.transformd, device="cpu"),
                first,
                counts,
                points,
                wp.array(candidates, dtype=wp.int32, device="cpu"),
            ],
            outputs=[hit],
            device="cpu",
        )
        found = candidates[hit.numpy() != 0]
        return [(self._colliders[a].path, self._colliders[b].path) for a, b in found.tolist()]

    def _near_ray(
        self,
        rotation: np.ndarray,
        position: np.ndarray,
        start: np.ndarray,
        along_ray: np.ndarray,
        distance: float,
        radius: float,
    ) -> np.ndarray:
        """Return the rows, in path order, of enabled colliders whose bounding sphere is within `radius` of a ray."""
        centers = np.einsum("ni,nij->nj", self._bounds[:, :3], rotation) + position
        along = np.clip((centers - start) @ along_ray, 0.0, distance)
        gap = np.linalg.norm(start + along[:, None] * along_ray - centers, axis=1) - radius
        return self._sorted[(self._enabled & (gap <= self._bounds[:, 3]))[self._sorted]]

    def _ray_meets_box(
        self,
        rows: np.ndarray,
        rotation: np.ndarray,
        position: np.ndarray,
        start: np.ndarray,
        along_ray: np.ndarray,
        distance: float,
    ) -> np.ndarray:
        """Return which of the colliders in `rows`, with world frames, have a box around them that a ray meets."""
        if self._box is None:
            boxes = np.array([local_box(collider.shape) for collider in self._colliders]).reshape(-1, 2, 3)
            # A flat mesh has a box without a thickness.
            slack = 1e-9 + 1e-9 * np.nan_to_num(np.abs(boxes), posinf=0.0).max(axis=(1, 2))[:, None]
            self._box = boxes[:, 0] - slack, boxes[:, 1] + slack
        origin = np.einsum("nij,nj->ni", rotation, start - position)
        direction = rotation @ along_ray
        direction = np.where(np.abs(direction) < 1e-30, 1e-30, direction)
        with np.errstate(over="ignore"):
            one, other = (self._box[0][rows] - origin) / direction, (self._box[1][rows] - origin) / direction
        enters, leaves = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
        return (enters <= leaves) & (leaves >= 0.0) & (enters <= distance)

    def _nearest_first(self, hits: list[RayHit]) -> list[RayHit]:
        """Return hits by distance; of the parts of a collider the nearest."""
        hits = sorted(hits, key=lambda hit: hit.distance)
        if not self._has_parts:
            return hits
        first: dict[str, RayHit] = {}
        for hit in hits:
            first.setdefault(hit.collision, hit)
        return list(first.values())

    def _ray_hit(self, row: int, distance: float, position: np.ndarray, normal: np.ndarray, face: int) -> RayHit:
        hit = self._overlaps[row]
        return RayHit(hit.rigid_body, hit.collision, distance, tuple(position.tolist()), tuple(normal.tolist()), face)

    def _overlap(
        self, poses: np.ndarray, kind: ShapeKind, size: Vector, origin: Vector, rotation_xyzw: Vector
    ) -> list[Overlap]:
        if not self._colliders:
            return []
        if self._overlap_launch is None:
            from usdsdg_physics.queries.overlap_launch import OverlapLaunch

            self._overlap_launch = OverlapLaunch(
                self._enabled, self._body, self._frame, self._bounds, self._device_tables()
            )
        rotation = np.asarray(rotation_xyzw, np.float64)
        hits = self._overlap_launch.hits(
            np.asarray(poses),
            kind,
            np.asarray(size, np.float64),
            np.asarray(origin, np.float64),
            rotation / np.linalg.norm(rotation),
        )
        found = [self._overlaps[row] for row in self._sorted[hits[self._sorted] != 0].tolist()]
        return list(dict.fromkeys(found)) if self._has_parts else found

    def _frames(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return world rotations (N, 3, 3) and positions (N, 3) of all shapes, computed once for an array of poses."""
        if self._placed is not None and self._placed[0] is poses:
            return self._placed[1:]
        rotation, position = self._rotation.copy(), self._position.copy()
        owned = self._body >= 0
        if owned.any():
            body = np.asarray(poses, np.float64)[self._body[owned]]
            body_rotation = matrix_from_quat(body[:, 3:])
            position[owned] = np.einsum("ni,nij->nj", position[owned], body_rotation) + body[:, :3]
            rotation[owned] = rotation[owned] @ body_rotation
        self._placed = poses, rotation, position
        return rotation, position

    def _device_tables(self) -> tuple[wp.array, ...]:
        """Return shape kinds, sizes, and the range and coordinates of their vertices as Warp arrays."""
        if self._tables is None:
            import warp as wp

            kinds, sizes, first, counts, points = [], [], [], [], [np.zeros((1, 3))]
            start: dict[str, int] = {}
            total = 1
            for collider in self._colliders:
                shape = collider.shape
                kinds.append(SHAPE_KINDS.index(shape.kind))
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
    """Return the vertices of a hull, or the corners of a mesh's triangles, three in a row; none of other shapes."""
    if shape.solid is None:
        return np.zeros((0, 3))
    if shape.kind == "mesh":
        return shape.solid.vertices[shape.solid.triangles.ravel()]
    return shape.solid.vertices
