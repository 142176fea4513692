"""World poses of several prims, read and authored; scale and shear stay as they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Usd, UsdGeom

from usdsdg.stage.poses.rotations import compose, decompose
from usdsdg.stage.poses.transforms import as_array, inverses_of_parents
from usdsdg.stage.poses.xform_ops import author_pose, gf_quat

Array = NDArray[np.float64]


def world_poses(prims: Sequence[Usd.Prim]) -> tuple[Array, Array]:
    """Return positions (N, 3) [stage units] and unit quaternions (N, 4) xyzw."""
    cache = UsdGeom.XformCache()
    poses = decompose(np.array([as_array(cache.GetLocalToWorldTransform(prim)) for prim in prims]).reshape(-1, 4, 4))
    return poses.translate, poses.rotation


def author_world_pose(prim: Usd.Prim, position: ArrayLike, quat_xyzw: ArrayLike) -> None:
    """Place one prim in the world.

    Raises:
        BadPrim: the prim cannot be posed.
        DegenerateFrame: an ancestor is scaled to zero.
    """
    local = decompose(compose(position, quat_xyzw) @ inverses_of_parents([prim])[0])
    author_pose(prim, translate=Gf.Vec3d(*local.translate.tolist()), orient=gf_quat(local.rotation))
