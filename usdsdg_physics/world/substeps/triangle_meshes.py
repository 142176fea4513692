"""Substeps near triangle meshes, which bodies could pass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat, rotated
from usdsdg_physics.scene.extents import body_boxes, half_thickness, world_box
from usdsdg_physics.scene.records import STATIC, Scene

# A triangle mesh has no inside that would push a body back out, so near one no body may travel farther in a substep
# than this fraction of its half thickness, at up to this many substeps for each ordinary one.
MAX_TRAVEL = 0.5
MAX_SUBSTEP_FACTOR = 4
NEAR_DISTANCE = 0.5  # m


class TriangleMeshes:
    """The boxes of triangle meshes, static or of kinematic bodies, and how thin the bodies are that could pass them."""

    def __init__(self, scene: Scene, shape_index: Mapping[str, int]) -> None:
        meshes = [collider for collider in scene.colliders.values() if collider.shape.kind == "mesh"]
        self._shapes = {shape_index[each.path]: each.shape for each in meshes if each.body == STATIC}
        rows = {path: row for row, path in enumerate(scene.bodies)}
        moving = [each for each in meshes if each.body != STATIC]
        self._moving_rows = [rows[each.body] for each in moving]
        # (M, 8, 3) corners of a box around each, in its body's frame.
        self._moving_corners = np.array([_corners(*world_box(each.shape)) for each in moving]).reshape(-1, 8, 3)
        thickness = dict.fromkeys(scene.bodies, np.inf)
        for collider in scene.colliders.values():
            if collider.body and not scene.bodies[collider.body].kinematic:
                thickness[collider.body] = min(thickness[collider.body], half_thickness(collider.shape))
        self._half_thickness = np.array(list(thickness.values()))
        # Of spheres around bodies, in their frames: their origins may be far off.
        lower, upper = np.moveaxis(body_boxes(scene.bodies, scene.colliders.values()), 1, 0)
        self._centers, self._radii = (lower + upper) / 2.0, np.linalg.norm(upper - lower, axis=1) / 2.0
        self._update_boxes()

    def __len__(self) -> int:
        return len(self._shapes) + len(self._moving_rows)

    def set_poses(self, poses: Mapping[int, Sequence[float]]) -> None:
        """Move those of the shapes that are static meshes, by shape index (7 numbers, world)."""
        for index in poses.keys() & self._shapes.keys():
            x, y, z, *rotation = poses[index]
            self._shapes[index] = replace(self._shapes[index], position=(x, y, z), rotation=tuple(rotation))
        self._update_boxes()

    def substeps(
        self, dt: float, poses: np.ndarray, velocities: np.ndarray, targets: Mapping[int, np.ndarray], count: int
    ) -> int:
        """Return how many substeps bodies need with poses (N, 7) and velocities (N, 6): at least `count`.

        `targets` are the poses (7,) of kinematic bodies, by index, at the end of the step.
        """
        travel = np.linalg.norm(velocities[:, :3], axis=1)[:, None] * dt + np.zeros((1, len(self)))
        boxes = self._boxes
        if self._moving_rows:
            moving, moves = self._moving_boxes(poses, targets)
            boxes = np.concatenate([boxes, moving])
            travel[:, len(self._shapes) :] += moves
        near = _within(poses[:, :3], boxes, np.full_like(travel, NEAR_DISTANCE))
        centers = rotated(poses[:, 3:].astype(np.float64), self._centers) + poses[:, :3]
        near |= _within(centers, boxes, self._radii[:, None] + travel)
        needed = np.nan_to_num(travel / (MAX_TRAVEL * self._half_thickness)[:, None])
        return int(np.clip(np.ceil(np.where(near, needed, 0.0).max()), count, count * MAX_SUBSTEP_FACTOR))

    def _moving_boxes(self, poses: np.ndarray, targets: Mapping[int, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the boxes (M, 2, 3) that meshes of bodies pass through in a step, and how far (M,) a corner moves."""
        start = poses[self._moving_rows].astype(np.float64)
        end = np.array([targets.get(row, pose) for row, pose in zip(self._moving_rows, start)])
        first, last = (_placed(self._moving_corners, pose) for pose in (start, end))
        both = np.concatenate([first, last], axis=1)
        moves = np.linalg.norm(last - first, axis=2).max(axis=1)
        return np.stack([both.min(axis=1), both.max(axis=1)], axis=1), moves

    def _update_boxes(self) -> None:
        """Compute lower and upper corners (M, 2, 3) of static meshes."""
        self._boxes = np.array([world_box(shape) for shape in self._shapes.values()]).reshape(-1, 2, 3)


def _within(points: np.ndarray, boxes: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Return which points (N, 3) are within a distance (N, M) of boxes (M, 2, 3), along each axis: (N, M) bool."""
    at, far = points[:, None], distance[..., None]
    return np.all((at > boxes[:, 0] - far) & (at < boxes[:, 1] + far), axis=2)


def _corners(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Return the corners (8, 3) of a box."""
    return np.array(list(product(*zip(lower, upper))))


def _placed(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return points (M, 8, 3) in frames with poses (M, 7), in the world."""
    return points @ matrix_from_quat(poses[:, 3:]) + poses[:, None, :3]
