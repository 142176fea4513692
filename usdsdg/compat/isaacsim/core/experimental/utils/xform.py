"""`isaacsim.core.experimental.utils.xform`: the pose of one prim, as float32 Warp arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from usdsdg.compat.isaacsim.core.experimental.utils.transform import compute_relative_transform
from usdsdg.compat.wrappers import poses
from usdsdg.compat.wrappers.arrays import as_warp, known_device, pose_rows
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.stage.poses.transforms import as_array, local_to_world

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Values


def get_world_pose(prim: str | Usd.Prim, *, device: str | None = None) -> tuple[wp.array, wp.array]:
    """Return position (3,) and orientation (4,), w, x, y, z, in the world."""
    return _warp(poses.world_poses([existing_prim(prim)]), device)


def get_local_pose(prim: str | Usd.Prim, *, device: str | None = None) -> tuple[wp.array, wp.array]:
    """Return translation (3,) and orientation (4,), w, x, y, z, relative to the parent."""
    return _warp(poses.local_poses([existing_prim(prim)]), device)


def set_world_pose(prim: str | Usd.Prim, *, position: Values | None = None, orientation: Values | None = None) -> None:
    """Place a prim in the world; what is not given stays."""
    poses.set_world_poses([existing_prim(prim)], *pose_rows(position, orientation, 1), strict=False)


def set_local_pose(
    prim: str | Usd.Prim, *, translation: Values | None = None, orientation: Values | None = None
) -> None:
    """Place a prim relative to its parent; what is not given stays."""
    poses.set_local_poses([existing_prim(prim)], *pose_rows(translation, orientation, 1), strict=False)


def get_relative_transform(source_prim: str | Usd.Prim, target_prim: str | Usd.Prim) -> np.ndarray:
    """Return the matrix (4, 4) for column vectors from the source's to the target's space."""
    source, target = (as_array(local_to_world(existing_prim(prim))) for prim in (source_prim, target_prim))
    return compute_relative_transform(source, target)


def _warp(pose: tuple[np.ndarray, np.ndarray], device: str | None) -> tuple[wp.array, wp.array]:
    where = "cpu" if device is None else known_device(str(device))
    return as_warp(pose[0][0], where), as_warp(pose[1][0], where)
