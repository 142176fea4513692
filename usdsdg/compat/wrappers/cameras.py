"""Cameras of viewports, which scripts aim."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from usdsdg.compat.wrappers.prim_paths import prim_of
from usdsdg.errors import BadPrim
from usdsdg.session import stage_context
from usdsdg.stage.cameras.viewport_cameras import PERSPECTIVE
from usdsdg.stage.poses.look_at import author_look_at
from usdsdg.stage.poses.transforms import local_to_world, up_vector
from usdsdg.stage.poses.xform_ops import author_world_position

# How far beside the up axis through a camera a point may be that is straight above or below it [stage units].
_VERTICAL = 1e-5


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
    *,
    top_of_vertical: Callable[[bool], Sequence[float]] | None = None,
) -> None:
    """Move a camera to `eye` and point it at `target`, both (3,) in the world [stage units]; what is None stays.

    top_of_vertical: gives the direction of the world at the top of the image where the camera looks along the up axis
        of the stage, which True says is upward; None for that of Replicator's `look_at`.

    Raises:
        BadPrim: there is no such camera.
        DegenerateFrame: eye and target coincide.
    """
    prim = camera_at(camera)
    with Usd.EditContext(prim.GetStage(), editable_layer(prim)):
        if eye is not None:
            author_world_position(prim, Gf.Vec3d(*np.asarray(eye, np.float64).ravel().tolist()))
        if target is not None:
            point = Gf.Vec3d(*np.asarray(target, np.float64).ravel().tolist())
            author_look_at(prim, point, _top(prim, point, top_of_vertical))


def _top(
    prim: Usd.Prim, point: Gf.Vec3d, of_vertical: Callable[[bool], Sequence[float]] | None
) -> Sequence[float] | None:
    """Return what is up in the image of a camera that looks at a point; None for the stage's up axis."""
    ahead = point - local_to_world(prim).ExtractTranslation()
    up = Gf.Vec3d(*up_vector(prim.GetStage()))
    if of_vertical is None or Gf.Cross(ahead, up).GetLength() > _VERTICAL:
        return None
    return of_vertical(Gf.Dot(ahead, up) > 0.0)


def editable_layer(prim: Usd.Prim) -> Sdf.Layer:
    """Return the layer in which an edit of a prim has an effect: the session layer if it has the prim, as the cameras
    of the viewport, else the stage's edit target.
    """
    stage = prim.GetStage()
    session = stage.GetSessionLayer()
    return session if session and session.GetPrimAtPath(prim.GetPath()) else stage.GetEditTarget().GetLayer()
