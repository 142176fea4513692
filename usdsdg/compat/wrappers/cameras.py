"""Cameras of viewports, which scripts aim."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import BadPrim
from usdsdg.session import stage_context
from usdsdg.stage.cameras.viewport_cameras import PERSPECTIVE
from usdsdg.stage.poses.look_at import author_look_at
from usdsdg.stage.poses.xform_ops import author_world_position


def camera_at(path: str | Usd.Prim) -> Usd.Prim:
    """Return the camera at a path; `/OmniverseKit_Persp` is defined if the stage has none.

    Raises:
        BadPrim: there is no such camera.
    """
    prim = prim_of(path)
    if not prim and str(path) == PERSPECTIVE:
        return UsdGeom.Camera.Define(stage_context.current_stage(), PERSPECTIVE).GetPrim()
    if not prim or not prim.IsA(UsdGeom.Camera):
        raise BadPrim(f"there is no camera at {path}")
    return prim


def aim(
    camera: str | Usd.Prim,
    eye: Sequence[float] | np.ndarray | None = None,
    target: Sequence[float] | np.ndarray | None = None,
) -> None:
    """Move a camera to `eye` and point it at `target`, both (3,) in the world [stage units]; what is None stays.

    Raises:
        BadPrim: there is no such camera.
        DegenerateFrame: eye and target coincide.
    """
    prim = camera_at(camera)
    with Usd.EditContext(prim.GetStage(), editable_layer(prim)):
        if eye is not None:
            author_world_position(prim, Gf.Vec3d(*np.asarray(eye, np.float64).ravel().tolist()))
        if target is not None:
            author_look_at(prim, Gf.Vec3d(*np.asarray(target, np.float64).ravel().tolist()))


def editable_layer(prim: Usd.Prim) -> Sdf.Layer:
    """Return the layer in which an edit of a prim has an effect: the session layer if it has the prim, as the cameras
    of the viewport, else the stage's edit target.
    """
    stage = prim.GetStage()
    session = stage.GetSessionLayer()
    return session if session and session.GetPrimAtPath(prim.GetPath()) else stage.GetEditTarget().GetLayer()
