"""Poses of the single instances of a PointInstancer made by `randomizer.instantiate(mode="point_instance")`."""

from dataclasses import replace

import numpy as np
from pxr import Usd, UsdGeom, Vt

from usdsdg.arguments.values import vector
from usdsdg.distribution import draw
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.stage.geometry.instancers import author_orientations, author_positions, instance_names
from usdsdg.stage.poses.rotations import matrix_from_euler, quat_from_matrix

_ROLES = ("position", "rotation", "scale")


def pose_instances(prim: Usd.Prim, node: Node, execution: int, order: str) -> None:
    """Write the pose that `node` samples for each instance: position and scale in the instancer's space.

    Rotations are Euler angles [degrees] in the axis order `order`.

    Raises:
        Unsupported: the node has inputs other than position, rotation and scale.
    """
    given = [role for role in node.inputs if role not in ("attribute", "rotation_order")]
    if others := sorted(set(given) - set(_ROLES)):
        raise Unsupported(
            f"modify.pose: {', '.join(others)} cannot be given to point instances; use {', '.join(_ROLES)}, or "
            "instantiate with mode='scene_instance'"
        )
    keys = replace(node, prims=tuple(instance_names(prim)))
    columns = {
        role: np.array([vector(role, each) for each in draw(node.inputs[role], keys, execution, role)], np.float32)
        for role in given
    }
    if "position" in columns:
        author_positions(prim, columns["position"])
    if "scale" in columns:
        UsdGeom.PointInstancer(prim).CreateScalesAttr(Vt.Vec3fArray.FromNumpy(columns["scale"]))
    if "rotation" in columns:
        rotations = matrix_from_euler(columns["rotation"], order)
        author_orientations(prim, quat_from_matrix(rotations))
