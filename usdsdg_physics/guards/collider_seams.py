"""Let bodies slide and roll over the seams of colliders that lie beside each other, such as tiles and belts."""

# Warp structs are no classes to a type checker; Newton declares the arrays of models optional.
# pyright: reportGeneralTypeIssues=false, reportOptionalMemberAccess=false

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from usdsdg.stage.poses.rotations import matrix_from_quat
from usdsdg_physics.scene.records import STATIC, Collider, Scene, Shape
from usdsdg_physics.scene.triangles import is_closed

if TYPE_CHECKING:
    import newton

    from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Colliders that are no farther apart than this [m] are neighbors.
NEAR = 2e-3
# What has more faces than this is round, and no tile.
MOST_FACES = 64


class ColliderSeams:
    """Turns contacts with the edges of static and kinematic colliders that continue the surface of another one.

    The narrow phase sees each collider alone: what lies on one of two boxes whose tops are level is in front of the
    side of the other, where it would stop.
    """

    def __init__(self, scene: Scene, model: newton.Model, shape_index: dict[str, int], contacts: ContactArrays) -> None:
        import warp as wp

        self._model, self._contacts = model, contacts
        colliders = [collider for collider in scene.colliders.values() if _may_have_seams(collider, scene)]
        planes = [_face_planes(collider.shape) for collider in colliders]
        kept = [row for row, faces in enumerate(planes) if 0 < len(faces) <= MOST_FACES]
        colliders, planes = [colliders[row] for row in kept], [planes[row] for row in kept]
        neighbors = neighbors_of([_bounds(collider, scene) for collider in colliders])
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
    """Return whether a collider has faces, and nothing pushes it; of one that passes through others nobody knows."""
    stays = collider.body == STATIC or scene.bodies[collider.body].kinematic
    filtered = {path for pair in scene.filtered for path in pair}
    has_faces = collider.shape.kind in ("box", "hull", "mesh", "plane")
    return stays and has_faces and not collider.trigger and collider.path not in filtered


def _face_planes(shape: Shape) -> np.ndarray:
    """Return the planes (F, 4) of a shape's faces around its own origin: outward normal, and distance [m].

    There are none of triangles that enclose no convex solid.
    """
    if shape.kind == "plane":
        return np.array([[0.0, 0.0, 1.0, 0.0]])
    if shape.kind == "box":
        sides = np.vstack([np.eye(3), -np.eye(3)])
        return np.hstack([sides, np.tile(shape.size, 2)[:, None]])
    assert shape.solid is not None
    vertices = shape.solid.vertices.astype(np.float64) * shape.size
    corners = vertices[shape.solid.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    corners, normals = corners[lengths > 0.0], normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    middle = shape.solid.centroid * shape.size
    normals *= np.where(((corners[:, 0] - middle) * normals).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    planes = np.hstack([normals, (corners[:, 0] * normals).sum(axis=1, keepdims=True)])
    # Triangles of one face differ in their last digits.
    _, first = np.unique(np.round(planes, 4), axis=0, return_index=True)
    planes = planes[np.sort(first)][: MOST_FACES + 1]
    is_convex = shape.kind == "hull" or is_solid(vertices, shape.solid.triangles, planes)
    return planes if is_convex else np.zeros((0, 4))


def is_solid(vertices: np.ndarray, triangles: np.ndarray, planes: np.ndarray) -> bool:
    """Return whether triangles are all sides of a convex solid whose faces lie in these planes."""
    size = float(np.ptp(vertices, axis=0).max())
    behind = vertices @ planes[:, :3].T - planes[:, 3] < 1e-4 * size
    return is_closed(triangles) and bool(behind.all())


def _bounds(collider: Collider, scene: Scene) -> np.ndarray:
    """Return the lower and upper corner (2, 3) of a collider in the world [m]; a plane has neighbors everywhere."""
    shape = collider.shape
    if shape.kind == "plane":
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    if shape.kind == "box":
        points = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * shape.size
    else:
        assert shape.solid is not None
        points = shape.solid.vertices.astype(np.float64) * shape.size
    points = points @ matrix_from_quat(shape.rotation) + shape.position
    if collider.body != STATIC:
        pose = np.asarray(scene.bodies[collider.body].pose)
        points = points @ matrix_from_quat(pose[3:]) + pose[:3]
    return np.array([points.min(axis=0), points.max(axis=0)])


def _set_rows(table: np.ndarray, numbers: Sequence[int], counts: Iterable[int]) -> None:
    """Set where the rows of shapes begin, which follow each other, and how many they are."""
    begin = 0
    for number, count in zip(numbers, counts):
        table[number] = begin, count
        begin += count
