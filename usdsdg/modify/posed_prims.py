"""Poses of single prims in many worlds: reading and setting their xform ops, and looking at points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom

from usdsdg.distribution import Distribution, draw_worlds
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.graph.node import Node
from usdsdg.modify.poses import is_paths, point_of
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.poses.look_at import look_at_rotations
from usdsdg.stage.poses.pose_batch import Rotations
from usdsdg.stage.poses.rotations import ROTATION_ORDERS, decompose, euler_xyz_from_quat
from usdsdg.stage.poses.transforms import inverse_of_parent, up_axis, up_vector
from usdsdg.stage.poses.xform_ops import local_euler
from usdsdg.stage.world_values import WorldValues

Array = NDArray[np.float64]
_ROTATIONS = {f"xformOp:rotate{order}": order for order in ROTATION_ORDERS}


class PosedPrim:
    """The xform ops of one prim, by the part of the pose that they hold, in worlds."""

    def __init__(self, prim: Usd.Prim, values: WorldValues, source: str) -> None:
        self.prim, self._values, self._source = prim, values, source
        self._ops = {op.GetOpName(): op for op in UsdGeom.Xformable(prim).GetOrderedXformOps()}

    def translation(self) -> Array:
        """(worlds or 1, 3) translation in the parent's space."""
        return self._values.translation(self.prim)

    def euler(self, order: str) -> Array:
        """(worlds or 1, 3) angles of the prim's own rotation, for a rotate op of `order` [degrees]."""
        held = self._values.held(self.prim, f"xformOp:rotate{order}")
        return np.asarray(local_euler(self.prim, order) if held is None else held, np.float64).reshape(-1, 3)

    def set_vectors(self, name: str, vectors: Array) -> None:
        """Set the op `xformOp:<name>` to (worlds, 3) numbers."""
        if name == "translate" and next(iter(self._ops), None) != "xformOp:translate":
            self._refuse("a translation that is applied last")
        self._set(f"xformOp:{name}", np.broadcast_to(vectors, (self._values.count, 3)))

    def set_rotation(self, degrees: Array) -> None:
        """Rotate by (worlds, 3) Euler angles about x, y, z [degrees], in the form that the prim has."""
        degrees = np.broadcast_to(degrees, (self._values.count, 3))
        rotations = Rotations(degrees=degrees)
        if "xformOp:orient" in self._ops:
            self._set("xformOp:orient", rotations.quats())
            return
        for name, order in _ROTATIONS.items():
            if name in self._ops:
                self._set(name, rotations.euler(order))
                return
        self._refuse("a rotation")

    def _set(self, name: str, values: Array) -> None:
        if name not in self._ops:
            self._refuse(name)
        self._values.set(self._ops[name].GetAttr(), values, self._source)

    def _refuse(self, what: str) -> None:
        raise Unsupported(f"{self.prim.GetPath()} has no xform op for {what}, so its pose cannot differ between worlds")

    def set_world_position(self, points: Array) -> None:
        """Move to (worlds or 1, 3) points of the world."""
        to_world = self._values.parent_to_world(self.prim)
        if self._values.move(self.prim.GetParent()):
            rows = np.c_[points, np.ones(len(points))][:, None]
            self.set_vectors("translate", (rows @ np.linalg.inv(to_world))[:, 0, :3])
            return
        # With the rounding of what moves the prim on the stage.
        inverse = inverse_of_parent(self.prim, self._values.time)
        self.set_vectors("translate", np.array([inverse.Transform(Gf.Vec3d(*point)) for point in points.tolist()]))

    def look_at(self, targets: Array, upwards: Array | None = None) -> None:
        """Rotate in place, so that the camera child or the own -Z points at (worlds or 1, 3) points of the world.

        upwards: (worlds or 1, 3) directions of the world; None: the stage's up axis.
        """
        stage, to_world = self.prim.GetStage(), self._values.parent_to_world(self.prim)
        eyes = self._values.origin_to_world(self.prim)
        eyes, targets = np.broadcast_arrays(eyes, targets)
        upwards = np.array([up_vector(stage)], np.float64) if upwards is None else upwards
        turned = look_at_rotations(eyes, targets, np.broadcast_to(upwards, eyes.shape), stage_up_axis=up_axis(stage))
        matrices = np.zeros((len(eyes), 4, 4))
        matrices[:, :3, :3], matrices[:, 3, :3], matrices[:, 3, 3] = turned, eyes, 1.0
        cameras = [child for child in self.prim.GetChildren() if child.IsA(UsdGeom.Camera)]
        if cameras:
            # The child camera of a Replicator camera object is rotated against the object.
            local = self._values.local_matrices(cameras[0])
            matrices = np.linalg.inv(local) @ matrices
        self.set_rotation(euler_xyz_from_quat(decompose(matrices @ np.linalg.inv(to_world)).rotation))


def vectors_of(column: np.ndarray) -> Array:
    """(worlds, 3) numbers, of which one may stand for all three."""
    numbers = np.asarray(column, np.float64)
    if numbers.ndim == 1:
        numbers = np.repeat(numbers[:, None], 3, axis=1)
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise ArgumentError(f"a pose needs three numbers, not {numbers.shape[1:]}")
    return numbers


def points_in_worlds(role: str, node: Node, executions: np.ndarray, index: int, values: WorldValues) -> Array:
    """(worlds or 1, 3) world points of an input for one of the prims: as coordinates, or as prims."""
    target = node.inputs[role]
    if isinstance(target, Distribution):
        drawn = draw_worlds(target, node, executions, role)[:, index]
        if drawn.dtype.kind not in "fiu":
            raise Unsupported(f"a prim that is the {role} cannot be drawn for worlds")
        return drawn.astype(np.float64)
    paths = [target] if isinstance(target, str) else target
    if is_paths(paths):
        origins = [values.origin_to_world(current_stage().GetPrimAtPath(path)) for path in paths]
        return np.mean(np.broadcast_arrays(*origins), axis=0)
    if isinstance(target, list) and len(target) == len(node.prims) and not np.isscalar(target[0]):
        target = target[index]
    return np.array([tuple(point_of(role, target))])
