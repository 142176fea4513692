"""`rep.modify.pose_orbit` in many worlds at once."""

import numpy as np

from usdsdg.distribution import Distribution, draw_worlds
from usdsdg.graph.node import Node
from usdsdg.graph.worlds import in_worlds
from usdsdg.modify.camera_relative import orbit_directions
from usdsdg.modify.posed_prims import PosedPrim, points_in_worlds
from usdsdg.modify.prims import target_prims
from usdsdg.stage.world_values import WorldValues


@in_worlds("OgnOrbitPose")
def _orbit_in_worlds(node: Node, executions: np.ndarray, values: WorldValues) -> None:
    distance, azimuth, elevation = (_numbers(role, node, executions) for role in ("distance", "azimuth", "elevation"))
    offsets = orbit_directions(azimuth, elevation) * distance[..., None]
    for index, prim in enumerate(target_prims(node)):
        centers, posed = (
            points_in_worlds("barycentre", node, executions, index, values),
            PosedPrim(prim, values, node.describe()),
        )
        posed.set_world_position(centers + offsets[:, index])
        if node.inputs["lookAtBarycentre"]:
            posed.look_at(centers)


def _numbers(role: str, node: Node, executions: np.ndarray) -> np.ndarray:
    """(worlds, prims) numbers of an input."""
    value = node.inputs[role]
    drawn = (
        draw_worlds(value, node, executions, role) if isinstance(value, Distribution) else np.asarray(value, np.float64)
    )
    return np.broadcast_to(drawn, (len(executions), len(node.prims)))
