"""Let bodies slide and roll over the seams of colliders that lie beside each other, such as tiles and belts."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.scene.records import STATIC, Collider, Scene, Shape, ShapeKind, Solid, Vec3
from usdsdg_physics.scene.triangles import is_closed

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Colliders that are no farther apart than this [m] are neighbors.
NEAR = 2e-3
# Faces of neighbors whose normals have this cosine, and which are no farther [m] from one plane, are level.
SAME_DIRECTION = 0.9999
LEVEL, LEVEL_BY_SIZE = 5e-4, 1e-5
# What has more faces than this is round, and no tile.
MOST_FACES = 64
MOST_TRIANGLES = 1024
_CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)


class ColliderSeams:
    """Turns contacts with the edges of static and kinematic colliders that continue the surface of another one.

    The narrow phase sees each collider alone: what lies on one of two boxes whose tops are level is in front of the
    side of the other, where it would stop.
    """

    def __init__(self, scene: Scene, model: newton.Model, shape_index: dict[str, int], contacts: ContactArrays) -> None:
        import warp as wp

        self._model, self._contacts = model, contacts
        # What passes through some others may pass through a neighbor too.
        filtered = {path for pair in scene.filtered for path in pair}
        colliders = [
            collider
            for collider in scene.colliders.values()
            if _may_have_seams(collider, scene) and collider.path not in filtered
        ]
        planes = [_face_planes(each.shape.kind, each.shape.size, each.shape.solid) for each in colliders]
        kept = [row for row, faces in enumerate(planes) if 0 < len(faces) <= MOST_FACES]
        colliders, planes = [colliders[row] for row in kept], [planes[row] for row in kept]
        poses = [scene.bodies[each.body].pose if each.body != STATIC else None for each in colliders]
        beside = neighbors_of([_bounds(each.shape, pose) for each, pose in zip(colliders, poses)])
        placed = [_in_world(faces, each.shape, pose) for faces, each, pose in zip(planes, colliders, poses)]
        neighbors = [
            # Nothing is in front of an edge of a plane.
            [other for other in rows if each.shape.kind != "plane" and _are_level(placed[row], placed[other])]
            for row, (each, rows) in enumerate(zip(colliders, beside))
        ]
        numbers = [shape_index[collider.path] for collider in colliders]
        self._any = any(map(len, neighbors))

        count = model.shape_count
        device = model.device
        # By shape: where its rows begin, and how many they are.
        face_rows, neighbor_rows = np.zeros((count, 2), np.int32), np.zeros((count, 2), np.int32)
        _set_rows(face_rows, numbers, map(len, planes))
        _set_rows(neighbor_rows, numbers, map(len, neighbors))
        self._face_rows = wp.array(face_rows, dtype=wp.vec2i, device=device)
        self._neighbor_rows = wp.array(neighbor_rows, dtype=wp.vec2i, device=device)
        faces = np.vstack(planes) if planes else np.zeros((0, 4))
        self._faces = wp.array(faces, dtype=wp.vec4, device=device)
        found = [numbers[row] for rows in neighbors for row in rows]
        self._neighbors = wp.array(found, dtype=wp.int32, device=device)

    def __bool__(self) -> bool:
        return self._any

    def turn_contacts(self, state: newton.State, visited: int) -> None:
        """Turn the contacts that were just found, of which there are at most `visited`."""
        import warp as wp

        from usdsdg_physics.guards.collider_seams_kernels import turn_to_surface

        model = self._model
        wp.launch(
            turn_to_surface,
            dim=visited,
            inputs=[
                self._face_rows,
                self._faces,
                self._neighbor_rows,
                self._neighbors,
                model.shape_transform,
                model.shape_body,
                model.shape_collision_group,
                state.body_q,
            ],
            outputs=[self._contacts],
            device=model.device,
        )


def neighbors_of(bounds: Sequence[np.ndarray]) -> list[list[int]]:
    """Return, for each of some boxes along the axes (2, 3) [m], which others are beside it."""
    found: list[list[int]] = [[] for _ in bounds]
    if len(bounds) < 2:
        return found
    low, high = np.array([each[0] for each in bounds]), np.array([each[1] for each in bounds]) + NEAR
    order = np.argsort(low[:, 0], kind="stable")
    ends = np.searchsorted(low[order, 0], high[:, 0], side="right")
    for place, row in enumerate(order.tolist()):
        others = order[place + 1 : ends[row]]
        touch = (low[others] <= high[row]).all(axis=1) & (low[row] <= high[others]).all(axis=1)
        for other in others[touch].tolist():
            found[row].append(other)
            found[other].append(row)
    return [sorted(rows) for rows in found]


def _may_have_seams(collider: Collider, scene: Scene) -> bool:
    """Return whether a collider has faces, and nothing pushes it."""
    stays = collider.body == STATIC or scene.bodies[collider.body].kinematic
    solid = collider.shape.solid
    has_faces = collider.shape.kind in ("box", "plane") or (
        solid is not None and len(solid.triangles) <= MOST_TRIANGLES
    )
    return stays and has_faces and not collider.trigger


@lru_cache(maxsize=8192)  # a scene is built again when something is added to it while it plays
def _face_planes(kind: ShapeKind, size: Vec3, solid: Solid | None) -> np.ndarray:
    """Return the planes (F, 4) of a shape's faces around its own origin: outward normal, and distance [m].

    There are none of triangles that enclose no convex solid.
    """
    if kind == "plane":
        return np.array([[0.0, 0.0, 1.0, 0.0]])
    if kind == "box":
        sides = np.vstack([np.eye(3), -np.eye(3)])
        return np.hstack([sides, np.tile(size, 2)[:, None]])
    assert solid is not None
    vertices = solid.vertices.astype(np.float64) * size
    corners = vertices[solid.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, normals = corners[lengths > 0.0], normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    middle = solid.centroid * size
    normals *= np.where(((corners[:, 0] - middle) * normals).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    planes = np.hstack([normals, (corners[:, 0] * normals).sum(axis=1, keepdims=True)])
    # Triangles of one face differ in their last digits.
    _, first = np.unique(np.round(planes, 4), axis=0, return_index=True)
    planes = planes[np.sort(first)][: MOST_FACES + 1]
    is_convex = kind == "hull" or is_solid(vertices, solid.triangles, planes)
    return planes if is_convex else np.zeros((0, 4))


def is_solid(vertices: np.ndarray, triangles: np.ndarray, planes: np.ndarray) -> bool:
    """Return whether triangles are all sides of a convex solid whose faces lie in these planes."""
    size = float(np.ptp(vertices, axis=0).max())
    behind = vertices @ planes[:, :3].T - planes[:, 3] < 1e-4 * size
    return is_closed(triangles) and bool(behind.all())


@lru_cache(maxsize=8192)
def _bounds(shape: Shape, pose: tuple[float, ...] | None) -> np.ndarray:
    """Return the lower and upper corner (2, 3) of a collider in the world [m]; a plane has neighbors everywhere.

    `pose` is that of its body; None for a static one.
    """
    if shape.kind == "plane":
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    corners = _CORNERS if shape.solid is None else shape.solid.vertices.astype(np.float64)
    points = (corners * shape.size) @ matrix_from_quat(np.asarray(shape.rotation)) + shape.position
    if pose is not None:
        points = points @ matrix_from_quat(np.asarray(pose[3:])) + pose[:3]
    return np.array([points.min(axis=0), points.max(axis=0)])


def _in_world(planes: np.ndarray, shape: Shape, pose: tuple[float, ...] | None) -> np.ndarray:
    """Return planes (F, 4) of a shape in the world; `pose` as in `_bounds`."""
    normals, distances = planes[:, :3], planes[:, 3]
    for frame in ((*shape.position, *shape.rotation), pose):
        if frame is not None:
            normals = normals @ matrix_from_quat(np.asarray(frame[3:]))
            distances = distances + normals @ np.asarray(frame[:3])
    return np.column_stack([normals, distances])


def _are_level(planes: np.ndarray, others: np.ndarray) -> bool:
    """Return whether a face of one collider continues one of another: that is where things slide over a seam."""
    alike = planes[:, :3] @ others[:, :3].T > SAME_DIRECTION
    apart = np.abs(planes[:, 3, None] - others[:, 3])
    return bool((alike & (apart < LEVEL + LEVEL_BY_SIZE * np.abs(others[:, 3]))).any())


def _set_rows(table: np.ndarray, numbers: Sequence[int], counts: Iterable[int]) -> None:
    """Set where the rows of shapes begin, which follow each other, and how many they are."""
    begin = 0
    for number, count in zip(numbers, counts):
        table[number] = begin, count
        begin += count
