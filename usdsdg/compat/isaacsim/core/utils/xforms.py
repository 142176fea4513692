"""`isaacsim.core.utils.xforms`: poses of one prim, and its xform ops."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Usd, UsdGeom

from usdsdg.compat.wrappers import poses
from usdsdg.compat.wrappers.prim_paths import existing_prim


def get_world_pose(prim_path: str, fabric: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return position (3,) and orientation (4,), w, x, y, z, in the world, float64."""
    return _pose(poses.world_poses([existing_prim(prim_path)]))


def get_local_pose(prim_path: str) -> tuple[np.ndarray, np.ndarray]:
    """Return translation (3,) and orientation (4,), w, x, y, z, relative to the parent, float64."""
    return _pose(poses.local_poses([existing_prim(prim_path)]))


def clear_xform_ops(prim: Usd.Prim) -> None:
    """Remove all xform ops."""
    UsdGeom.Xformable(prim).ClearXformOpOrder()
    for name in prim.GetAuthoredPropertyNames():
        if name.startswith("xformOp:"):
            prim.RemoveProperty(name)


def reset_and_set_xform_ops(
    prim: Usd.Prim,
    translation: Gf.Vec3d,
    orientation: Gf.Quatd,
    scale: Gf.Vec3d = Gf.Vec3d(1.0, 1.0, 1.0),  # noqa: B008
) -> None:
    """Replace the xform ops by translate, orient and scale with these values."""
    clear_xform_ops(prim)
    xformable, double = UsdGeom.Xformable(prim), UsdGeom.XformOp.PrecisionDouble
    xformable.AddTranslateOp(double).Set(Gf.Vec3d(translation))
    xformable.AddOrientOp(double).Set(Gf.Quatd(orientation))
    xformable.AddScaleOp(double).Set(Gf.Vec3d(scale))


def reset_xform_ops(prim: Usd.Prim) -> None:
    """Replace the xform ops by translate, orient and scale with the same position and rotation; the scale is 1."""
    translations, orientations = poses.local_poses([prim])
    reset_and_set_xform_ops(prim, Gf.Vec3d(*translations[0].tolist()), Gf.Quatd(*orientations[0].tolist()))


def _pose(pose: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    return pose[0][0].astype(np.float64), pose[1][0].astype(np.float64)
