"""Poses of the instances of a population (`randomizer.instantiate(mode="point_instance")`), one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from usdsdg.distribution import draw
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.stage import transforms
from usdsdg.values import vector

# In the custom data of a PointInstancer whose instances are objects of their own.
POPULATION = "usdsdg:population"
_ROLES = ("position", "rotation", "scale")


def is_population(prim: Usd.Prim) -> bool:
    """Whether a prim stands for its instances."""
    return prim.IsA(UsdGeom.PointInstancer) and bool(prim.GetCustomDataByKey(POPULATION))


def pose_instances(prim: Usd.Prim, node: Node, execution: int, order: str) -> None:
    """Write what `node` draws for each instance: position and scale in the instancer's space, rotation in degrees.

    Raises:
        Unsupported: the node has something else than position, rotation and scale.
    """
    given = [role for role in node.inputs if role not in ("attribute", "rotation_order")]
    if others := sorted(set(given) - set(_ROLES)):
        raise Unsupported(
            f"modify.pose: {', '.join(others)} cannot be given to point instances; use {', '.join(_ROLES)}, or "
            "instantiate with mode='scene_instance'"
        )
    instancer = UsdGeom.PointInstancer(prim)
    count = len(instancer.GetProtoIndicesAttr().Get() or ())
    keys = replace(node, prims=tuple(f"{prim.GetPath()}[{index}]" for index in range(count)))
    columns = {
        role: np.array([vector(role, each) for each in draw(node.inputs[role], keys, execution, role)], np.float32)
        for role in given
    }
    if "position" in columns:
        instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(columns["position"]))
    if "scale" in columns:
        instancer.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(columns["scale"]))
    if "rotation" in columns:
        quats = transforms.quat_from_matrix(transforms.matrix_from_euler(columns["rotation"], order))
        instancer.CreateOrientationsAttr(Vt.QuathArray([Gf.Quath(transforms.gf_quat(quat)) for quat in quats]))
