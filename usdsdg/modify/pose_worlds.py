"""`rep.modify.pose` in many worlds at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from usdsdg.distribution import Distribution, draw_worlds
from usdsdg.errors import ArgumentError, Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.poses import is_paths, point_of
from usdsdg.modify.prims import target_prims
from usdsdg.stage.geometry.instancers import has_posable_instances
from usdsdg.stage.poses.look_at import look_at_rotations
from usdsdg.stage.poses.pose_batch import Rotations
from usdsdg.stage.poses.rotations import (
    ROTATION_ORDERS,
    decompose,
    euler_from_matrix,
    euler_xyz_from_quat,
    matrix_from_euler,
)
from usdsdg.stage.poses.transforms import as_array, up_axis, up_vector
from usdsdg.stage.poses.xform_ops import local_euler, local_translation
from usdsdg.stage.world_values import Targets, WorldValues

Array = NDArray[np.float64]
# Roles whose effect depends on the bounding box that a prim has at that time.
_BY_BOUNDS = ("pivot", "size")
# Ops that hold whole parts of a pose as they are given.
_OPS = {"position": "xformOp:translate", "rotation": "xformOp:rotateXYZ", "scale": "xformOp:scale"}
_ROTATIONS = {f"xformOp:rotate{order}": order for order in ROTATION_ORDERS}


@in_worlds("OgnWritePose")
def pose_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    """Set the poses that an "OgnWritePose" node writes."""
    drawn = {
        role: _column(role, value, node, executions)
        for role, value in node.inputs.items()
        if role not in ("attribute", "rotation_order", "look_at", *_BY_BOUNDS)
    }
    if given := [role for role in _BY_BOUNDS if role in node.inputs]:
        raise Unsupported(f"{given[0]} follows the bounds of the prim, which are not measured in worlds")
    order, source = node.inputs.get("rotation_order", "XYZ"), node.describe()
    if order == "XYZ" and _pose_together(node, drawn, values):
        return
    for index, prim in enumerate(target_prims(node)):
        if has_posable_instances(prim):
            raise Unsupported(f"the point instances of {prim.GetPath()} cannot be posed in worlds")
        own = {role: column[:, index] for role, column in drawn.items()}
        _pose(PosedPrim(prim, values, source), own, order)
        if "look_at" in node.inputs:
            _look_at(PosedPrim(prim, values, source), _targets(node, executions, index, values), own)


def _pose_together(node: Node, drawn: dict[str, np.ndarray], values: WorldValues) -> bool:
    """Set position, rotation and scale of all prims at once; return False, setting nothing, for other inputs."""
    if not drawn.keys() <= _OPS.keys() or "look_at" in node.inputs:
        return False
    prims = target_prims(node)
    orders = [prim.GetAttribute("xformOpOrder").Get() for prim in prims]
    known = node.state.get("in worlds")
    if known is None or known[0] != orders:
        known = node.state["in worlds"] = (orders, {role: _targets_of(prims, role) for role in drawn})
    targets = known[1]
    blocks = {role: _block(column) for role, column in drawn.items()}
    if any(block is None for block in blocks.values()) or any(targets.get(role) is None for role in drawn):
        return False
    for role, block in blocks.items():
        values.set_block(targets[role], np.broadcast_to(block, (values.count, *block.shape[1:])), node.describe())
    return True


def _targets_of(prims: list[Usd.Prim], role: str) -> Targets | None:
    """Return the ops of prims that hold a part of their poses; None where they are not all of one kind."""
    if any(has_posable_instances(prim) for prim in prims) or len(set(prims)) < len(prims):
        return None
    found = [{op.GetOpName(): op for op in UsdGeom.Xformable(prim).GetOrderedXformOps()} for prim in prims]
    if not all(_OPS[role] in ops for ops in found):
        return None
    try:
        return Targets([ops[_OPS[role]].GetAttr() for ops in found])
    except ValueError:
        return None


def _block(column: np.ndarray) -> Array | None:
    """(worlds, prims, 3) numbers, of which one may stand for all three; None for others."""
    if column.dtype.kind not in "fiu":
        return None
    numbers = np.asarray(column, np.float64)
    if numbers.ndim == 2:
        numbers = np.repeat(numbers[..., None], 3, axis=2)
    return numbers if numbers.ndim == 3 and numbers.shape[2] == 3 else None


def _column(role: str, value: Any, node: Node, executions: np.ndarray) -> np.ndarray:
    """(worlds, prims, ...) values of a role."""
    if role[-2:] in ("_x", "_y", "_z") and not isinstance(value, Distribution):
        return np.broadcast_to(np.asarray(value, np.float64), (len(executions), len(node.prims)))
    return draw_worlds(value, node, executions, role)


class PosedPrim:
    """The xform ops of one prim, by the part of the pose that they hold, in worlds."""

    def __init__(self, prim: Usd.Prim, values: WorldValues, source: str) -> None:
        self.prim, self._values, self._source = prim, values, source
        self._ops = {op.GetOpName(): op for op in UsdGeom.Xformable(prim).GetOrderedXformOps()}

    def translation(self) -> Array:
        """(worlds or 1, 3) translation in the parent's space."""
        held = self._values.of(self.prim.GetPath()).get("xformOp:translate")
        return np.asarray(local_translation(self.prim) if held is None else held, np.float64).reshape(-1, 3)

    def euler(self, order: str) -> Array:
        """(worlds or 1, 3) angles of the prim's own rotation, for a rotate op of `order` [degrees]."""
        held = self._values.of(self.prim.GetPath()).get(f"xformOp:rotate{order}")
        return np.asarray(local_euler(self.prim, order) if held is None else held, np.float64).reshape(-1, 3)

    def set_vectors(self, name: str, vectors: Array) -> None:
        """Set the op `xformOp:<name>` to (worlds, 3) numbers."""
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


def _pose(prim: PosedPrim, drawn: dict[str, Any], order: str) -> None:
    if "position" in drawn:
        prim.set_vectors("translate", _vectors(drawn["position"]))
    elif axes := _single_axes("position", drawn):
        prim.set_vectors("translate", _replaced(prim.translation(), axes))
    degrees = None
    if "rotation" in drawn:
        degrees = _vectors(drawn["rotation"])
    elif axes := _single_axes("rotation", drawn):
        degrees = _replaced(prim.euler(order), axes)
    if degrees is not None:
        prim.set_rotation(degrees if order == "XYZ" else euler_from_matrix(matrix_from_euler(degrees, order)))
    if "scale" in drawn:
        prim.set_vectors("scale", _vectors(drawn["scale"]))


def _vectors(column: np.ndarray) -> Array:
    """(worlds, 3) numbers, of which one may stand for all three."""
    numbers = np.asarray(column, np.float64)
    if numbers.ndim == 1:
        numbers = np.repeat(numbers[:, None], 3, axis=1)
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise ArgumentError(f"a pose needs three numbers, not {numbers.shape[1:]}")
    return numbers


def _single_axes(role: str, drawn: dict[str, np.ndarray]) -> dict[int, np.ndarray]:
    return {axis: drawn[f"{role}_{letter}"] for axis, letter in enumerate("xyz") if f"{role}_{letter}" in drawn}


def _replaced(vectors: Array, axes: dict[int, np.ndarray]) -> Array:
    count = max(len(vectors), *map(len, axes.values()))
    vectors = np.array(np.broadcast_to(vectors, (count, 3)))
    for axis, numbers in axes.items():
        vectors[:, axis] = numbers
    return vectors


def _targets(node: Node, executions: np.ndarray, index: int, values: WorldValues) -> Array:
    """(worlds or 1, 3) world points that a prim looks at."""
    target = node.inputs["look_at"]
    if isinstance(target, Distribution):
        drawn = draw_worlds(target, node, executions, "look_at")[:, index]
        if drawn.dtype.kind not in "fiu":
            raise Unsupported("a target prim of look_at cannot be drawn for worlds")
        return drawn.astype(np.float64)
    paths = [target] if isinstance(target, str) else target
    if is_paths(paths):
        stage = node.state["prims"][0].GetStage()
        origins = [values.local_to_world(stage.GetPrimAtPath(path))[:, 3, :3] for path in paths]
        return np.mean(np.broadcast_arrays(*origins), axis=0)
    if isinstance(target, list) and len(target) == len(node.prims) and not np.isscalar(target[0]):
        target = target[index]
    return np.array([tuple(point_of("look_at", target))])


def _look_at(prim: PosedPrim, targets: Array, drawn: dict[str, np.ndarray]) -> None:
    """Rotate a prim in place, as `author_look_at` does."""
    values, stage = prim._values, prim.prim.GetStage()
    to_world = values.parent_to_world(prim.prim)
    eyes = values.local_to_world(prim.prim)[:, 3, :3]
    up = drawn.get("look_at_up_axis")
    eyes, targets = np.broadcast_arrays(eyes, targets)
    upwards = np.array([up_vector(stage)], np.float64) if up is None else _vectors(up)
    turned = look_at_rotations(eyes, targets, np.broadcast_to(upwards, eyes.shape), stage_up_axis=up_axis(stage))
    matrices = np.zeros((len(eyes), 4, 4))
    matrices[:, :3, :3], matrices[:, 3, :3], matrices[:, 3, 3] = turned, eyes, 1.0
    cameras = [child for child in prim.prim.GetChildren() if child.IsA(UsdGeom.Camera)]
    if cameras:
        local = as_array(UsdGeom.Xformable(cameras[0]).GetLocalTransformation())
        matrices = np.linalg.inv(local) @ matrices
    rotation = decompose(matrices @ np.linalg.inv(to_world)).rotation
    prim.set_rotation(euler_xyz_from_quat(rotation))
