"""Shapes that keep things away from a camera and out of its view."""

from __future__ import annotations

from typing import Any

from pxr import Usd, UsdGeom

from usdsdg.errors import BadPrim
from usdsdg.functional import create_batch
from usdsdg.functional.arguments import one_prim
from usdsdg.stage.transforms import meters_per_unit


def create_camera_collision_prims(
    camera_prim: Any, camera_coll_radius: float = 0.02, camera_coll_view_dist: float = 0.4
) -> list[Usd.Prim]:
    """Invisible meshes below a camera's parent that keep others away from the camera and out of its view.

    "cameraSphere" of `camera_coll_radius` metres around the camera, and "cameraCone" from the camera along its view,
    `camera_coll_view_dist` metres long and as wide there as the picture. They have no collider yet. Calling it again
    replaces them.

    Raises:
        BadPrim: it is no camera, nor the object of one.
    """
    camera = _camera(one_prim("camera_prim", camera_prim))
    stage, unit = camera.GetStage(), 1.0 / meters_per_unit(camera.GetStage())
    parent = camera.GetParent()
    for name in ("cameraSphere", "cameraCone"):
        if stage.GetPrimAtPath(parent.GetPath().AppendChild(name)):
            stage.RemovePrim(parent.GetPath().AppendChild(name))
    lens = UsdGeom.Camera(camera)
    half_width = 0.5 * lens.GetHorizontalApertureAttr().Get() / lens.GetFocalLengthAttr().Get()
    length, diameter = camera_coll_view_dist, 2.0 * half_width * camera_coll_view_dist
    up_is_y = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    # The apex, in the middle of the top of the cone, lies at the camera; the base in front of it.
    placed = {"parent": parent, "visible": False, "relative_to": camera}
    ball = create_batch.sphere(name="cameraSphere", scale=2.0 * camera_coll_radius, **placed)
    cone = create_batch.cone(
        name="cameraCone", position=(0.0, 0.0, -length / 2 * unit), rotation=(90.0, 0.0, 0.0) if up_is_y else 0.0,
        scale=(diameter, length, diameter) if up_is_y else (diameter, diameter, length), **placed,
    )  # fmt: skip
    return [*ball, *cone]


def _camera(prim: Usd.Prim) -> Usd.Prim:
    cameras = [each for each in (prim, *prim.GetChildren()) if each.IsA(UsdGeom.Camera)]
    if not cameras:
        raise BadPrim(f"{prim.GetPath()} is a {prim.GetTypeName() or 'prim without a type'}, not a camera")
    return cameras[0]
