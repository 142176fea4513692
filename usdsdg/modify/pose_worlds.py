"""`rep.modify.pose` in many worlds at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from usdsdg.distribution import Distribution, draw_worlds
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.posed_prims import PosedPrim, points_in_worlds, vectors_of
from usdsdg.modify.prims import target_prims
from usdsdg.stage.geometry.instancers import is_instancer
from usdsdg.stage.poses.rotations import euler_from_matrix, matrix_from_euler
from usdsdg.stage.world_values import Targets, WorldValues

Array = NDArray[np.float64]
# Roles whose effect depends on the bounding box that a prim has at that time.
_BY_BOUNDS = ("pivot", "size")
# Ops that hold whole parts of a pose as they are given.
_OPS = {"position": "xformOp:translate", "rotation": "xformOp:rotateXYZ", "scale": "xformOp:scale"}


@in_worlds("OgnWritePose")
def pose_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    """Set the poses that an "OgnWritePose" node writes."""
    prims = target_prims(node)
    for prim in filter(is_instancer, prims):
        raise Unsupported(f"the point instances of {prim.GetPath()} cannot be posed in worlds")
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
    for index, prim in enumerate(prims):
        own = {role: column[:, index] for role, column in drawn.items()}
        _pose(PosedPrim(prim, values, source), own, order)
        if "look_at" in node.inputs:
            up = vectors_of(own["look_at_up_axis"]) if "look_at_up_axis" in own else None
            targets = points_in_worlds("look_at", node, executions, index, values)
            PosedPrim(prim, values, source).look_at(targets, up)


def _pose_together(node: Node, drawn: dict[str, np.ndarray], values: WorldValues) -> bool:
    """Set position, rotation and scale of all prims at once; return False, setting nothing, for other inputs."""
    if not drawn.keys() <= _OPS.keys() or "look_at" in node.inputs:
        return False
    prims = target_prims(node)
    orders = [prim.GetAttribute("xformOpOrder").Get() for prim in prims]
    known = node.state.get("in worlds")
    if known is None or known[0] != orders:
        known = node.state["in worlds"] = (orders, {role: _targets_of(prims, role) for role in drawn})
    found = [(known[1].get(role), _block(column)) for role, column in drawn.items()]
    pairs = [(targets, block) for targets, block in found if targets is not None and block is not None]
    if len(pairs) < len(found):
        return False
    for targets, block in pairs:
        values.set_block(targets, np.broadcast_to(block, (values.count, *block.shape[1:])), node.describe())
    return True


def _targets_of(prims: list[Usd.Prim], role: str) -> Targets | None:
    """Return the ops of prims that hold a part of their poses; None where they are not all of one kind."""
    if len(set(prims)) < len(prims):
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


def _pose(prim: PosedPrim, drawn: dict[str, Any], order: str) -> None:
    if "position" in drawn:
        prim.set_vectors("translate", vectors_of(drawn["position"]))
    elif axes := _single_axes("position", drawn):
        prim.set_vectors("translate", _replaced(prim.translation(), axes))
    degrees = None
    if "rotation" in drawn:
        degrees = vectors_of(drawn["rotation"])
    elif axes := _single_axes("rotation", drawn):
        degrees = _replaced(prim.euler(order), axes)
    if degrees is not None:
        prim.set_rotation(degrees if order == "XYZ" else euler_from_matrix(matrix_from_euler(degrees, order)))
    if "scale" in drawn:
        prim.set_vectors("scale", vectors_of(drawn["scale"]))


def _single_axes(role: str, drawn: dict[str, np.ndarray]) -> dict[int, np.ndarray]:
    return {axis: drawn[f"{role}_{letter}"] for axis, letter in enumerate("xyz") if f"{role}_{letter}" in drawn}


def _replaced(vectors: Array, axes: dict[int, np.ndarray]) -> Array:
    count = max(len(vectors), *map(len, axes.values()))
    vectors = np.array(np.broadcast_to(vectors, (count, 3)))
    for axis, numbers in axes.items():
        vectors[:, axis] = numbers
    return vectors
