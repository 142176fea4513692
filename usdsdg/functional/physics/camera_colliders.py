"""Meshes that keep objects away from a camera and out of its view."""

from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.arguments.prims import one_prim
from usdsdg.errors import BadPrim, Unsupported
from usdsdg.functional import create_batch
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.poses.transforms import meters_per_unit, up_axis

# Any resolution will do: lenses are calibrated for a nominal size, or for the image's width.
_RESOLUTION = (1024, 768)
_MAX_HALF_ANGLE = 80.0  # degrees from the axis


def create_camera_collision_prims(
    camera_prim: Any, camera_coll_radius: float = 0.02, camera_coll_view_dist: float = 0.4
) -> list[Usd.Prim]:
    """Create invisible meshes below a camera's parent that keep objects away from the camera and out of its view.

    "cameraSphere" of `camera_coll_radius` meters around the camera, and "cameraCone" from the camera along its view,
    `camera_coll_view_dist` meters long and as wide there as the image. They have no collider yet. Calling it again
    replaces them.

    Raises:
        BadPrim: it is no camera, nor the parent of one.
        Unsupported: its field of view is wider than a cone can be.
    """
    camera = _camera(one_prim("camera_prim", camera_prim))
    half_width = _half_width(camera)
    stage, unit = camera.GetStage(), 1.0 / meters_per_unit(camera.GetStage())
    parent = camera.GetParent()
    for name in ("cameraSphere", "cameraCone"):
        if stage.GetPrimAtPath(parent.GetPath().AppendChild(name)):
            stage.RemovePrim(parent.GetPath().AppendChild(name))
    length, diameter = camera_coll_view_dist, 2.0 * half_width * camera_coll_view_dist
    up_is_y = up_axis(stage) == "Y"
    # The apex of the cone is at the camera, its base in front of it.
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


def _half_width(camera: Usd.Prim) -> float:
    """Return half the width of the camera's field of view at distance one."""
    view = read_camera(camera.GetStage(), camera.GetPath(), _RESOLUTION)
    if view.lens is None:
        return 0.5 * view.horizontal_aperture / view.focal_length
    columns = np.linspace(0.0, _RESOLUTION[0], 2049)
    _, directions = view.rays(np.stack([columns, np.full(2049, _RESOLUTION[1] / 2)], axis=1))
    directions = directions[np.isfinite(directions).all(axis=1)]
    if (-directions[:, 2] < np.cos(np.radians(_MAX_HALF_ANGLE))).any():
        raise Unsupported(
            f"create_camera_collision_prims: {camera.GetPath()} sees more than {_MAX_HALF_ANGLE:g} degrees to a side, "
            "and no cone is that wide; give it a longer lens, or colliders of your own"
        )
    return float(np.abs(directions[:, 0] / directions[:, 2]).max(initial=0.0))
