"""`rep.randomizer.color` and `rotation` in many worlds at once."""

from __future__ import annotations

import numpy as np

from usdsdg.distribution import draw_worlds
from usdsdg.errors import Unsupported
from usdsdg.graph.node import Node
from usdsdg.graph.sampling import get_global_seed, uniforms
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.attribute_worlds import set_in_worlds
from usdsdg.modify.posed_prims import PosedPrim
from usdsdg.modify.prims import target_prims
from usdsdg.randomizer.appearance import meshes_of
from usdsdg.randomizer.rotations import uniform_quaternions
from usdsdg.stage.geometry.instancers import is_instancer
from usdsdg.stage.poses.rotations import euler_xyz_from_quat
from usdsdg.stage.world_values import Targets, WorldValues


@in_worlds("OgnColor")
def _colors_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    if node.inputs.get("perSubMesh"):
        node = meshes_of(node).node
    drawn = draw_worlds(node.inputs["diffuse_color_constant"], node, executions, "diffuse_color_constant")
    if _color_together(node, drawn, values):
        return
    for index, path in enumerate(node.prims):
        shader = node.state["shaders"][path].GetPrim()
        preview = shader.GetParent().GetChild("PreviewSurface")
        for attribute in (
            shader.GetAttribute("inputs:diffuse_color_constant"), preview.GetAttribute("inputs:diffuseColor"),
        ):  # fmt: skip
            set_in_worlds(attribute, drawn[:, index], values, node.describe())


def _color_together(node: Node, drawn: np.ndarray, values: WorldValues) -> bool:
    """Set the colors of all prims at once; return False, setting nothing, for other inputs."""
    shaders = [node.state["shaders"].get(path) for path in node.prims]
    if drawn.ndim != 3 or drawn.shape[2] != 3 or not all(shaders):
        return False
    known = node.state.get("in worlds")
    if known is None or known[0] != shaders:
        prims = [shader.GetPrim() for shader in shaders]
        constants = Targets([prim.GetAttribute("inputs:diffuse_color_constant") for prim in prims])
        previews = [prim.GetParent().GetChild("PreviewSurface").GetAttribute("inputs:diffuseColor") for prim in prims]
        known = node.state["in worlds"] = (shaders, constants, Targets(previews))
    for targets in known[1:]:
        values.set_block(targets, drawn, node.describe())
    return True


@in_worlds("OgnRotation")
def _rotations_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    lower, upper = (np.asarray(node.inputs[name], float) for name in ("minAngle", "maxAngle"))
    u = uniforms(node.inputs.get("seed", get_global_seed()), node.key, executions, node.prims, 3)
    if (lower == -180.0).all() and (upper == 180.0).all():
        angles = euler_xyz_from_quat(uniform_quaternions(u.reshape(-1, 3))).reshape(u.shape)
    else:
        angles = lower + u * (upper - lower)
    for index, prim in enumerate(target_prims(node)):
        if is_instancer(prim):
            raise Unsupported(f"the point instances of {prim.GetPath()} cannot be rotated in worlds")
        PosedPrim(prim, values, node.describe()).set_rotation(angles[:, index])
