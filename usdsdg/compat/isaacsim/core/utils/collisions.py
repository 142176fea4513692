"""`isaacsim.core.utils.collisions`: what a ray hits first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf

from usdsdg.compat.omni.physx import get_physx_scene_query_interface

# What a ray that hits nothing has gone.
_NOTHING = 10000.0


def ray_cast(
    position: np.ndarray | Sequence[float],
    orientation: np.ndarray | Sequence[float],
    offset: np.ndarray | Sequence[float],
    max_dist: float = 100.0,
) -> tuple[str | None, float]:
    """Return the body that a ray along +x of a frame hits first, or the collider of none, and the distance.

    The frame is at `position` (3,) [stage units] with `orientation` (4,), w first. The ray begins at `offset` (3,) in
    the frame and is `max_dist` long [stage units]. None and 10000 are returned where it hits nothing.
    """
    turn = Gf.Rotation(Gf.Quatd(*(float(component) for component in orientation)))
    begin = Gf.Vec3d(*map(float, position)) + turn.TransformDir(Gf.Vec3d(*map(float, offset)))
    ahead = turn.TransformDir(Gf.Vec3d(1.0, 0.0, 0.0))
    hit = get_physx_scene_query_interface().raycast_closest(tuple(begin), tuple(ahead), max_dist, True)
    return (str(hit["rigidBody"]), float(hit["distance"])) if hit["hit"] else (None, _NOTHING)
