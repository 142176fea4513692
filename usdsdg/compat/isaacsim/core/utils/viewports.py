"""`isaacsim.core.utils.viewports`: the pose of cameras that a viewport would show; there are no windows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Usd, UsdGeom

from usdsdg.compat.carb import Float3
from usdsdg.compat.omni.kit.viewport.utility import Viewport, get_active_viewport
from usdsdg.compat.wrappers.cameras import aim, camera_at, editable_layer
from usdsdg.compat.wrappers.unsupported import refused_function
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.session.stage_context import current_stage
from usdsdg.session.timeline import stage_time
from usdsdg.stage.cameras.camera_view import read_camera
from usdsdg.stage.cameras.pixels import pixel_centers
from usdsdg.stage.cameras.viewport_cameras import PERSPECTIVE

_NO_WINDOW = "there are no viewport windows; make a render product with rep.create.render_product"


def set_camera_view(
    eye: Sequence[float] | np.ndarray,
    target: Sequence[float] | np.ndarray,
    camera_prim_path: str = PERSPECTIVE,
    viewport_api: Viewport | None = None,
) -> None:
    """Move a camera to `eye` and point it at `target`, both (3,) in the world [stage units].

    `/OmniverseKit_Persp` is defined if the stage has none. A camera of a stage with Z up that looks straight up or down
    has +Y at the top of the image, as in Isaac Sim.

    Raises:
        BadPrim: there is no such camera.
        DegenerateFrame: eye and target coincide.
    """
    top = (0.0, 1.0, 0.0)
    z_is_up = UsdGeom.GetStageUpAxis(current_stage()) == UsdGeom.Tokens.z
    aim(camera_prim_path, eye, target, top_of_vertical=(lambda _: top) if z_is_up else None)


def set_active_viewport_camera(camera_prim_path: str) -> None:
    """Name the camera of the viewport, which shows nothing."""
    get_active_viewport().set_active_camera(camera_prim_path)


def get_viewport_names(usd_context_name: str | None = None) -> list[str]:
    """Return []: there are no windows."""
    return []


def get_id_from_index(index: int) -> int | None:
    """Return None: no window has this index."""


def get_window_from_id(id: object, usd_context_name: str | None = None) -> None:
    """Return None: there are no windows."""


def destroy_all_viewports(usd_context_name: str | None = None, destroy_main_viewport: bool = True) -> None:
    """Close all windows, of which there are none; render products go on."""


def get_intrinsics_matrix(viewport_api: Viewport) -> np.ndarray:
    """Return the matrix (3, 3) from points in the camera (+x right, +y down, +z ahead) to pixels of a viewport.

    Pixels are square. Unlike in Isaac Sim, the offsets of the apertures count, as they do in images.

    Raises:
        BadPrim: the viewport's camera is not on the stage.
    """
    camera = UsdGeom.Camera(camera_at(str(viewport_api.get_active_camera())))
    width, height = viewport_api.get_texture_resolution()
    pixels = width / camera.GetHorizontalApertureAttr().Get()
    focal = camera.GetFocalLengthAttr().Get() * pixels
    right = width * 0.5 - camera.GetHorizontalApertureOffsetAttr().Get() * pixels
    down = height * 0.5 + camera.GetVerticalApertureOffsetAttr().Get() * pixels
    return np.array([[focal, 0.0, right], [0.0, focal, down], [0.0, 0.0, 1.0]])


def set_intrinsics_matrix(viewport_api: Viewport, intrinsics_matrix: np.ndarray, focal_length: float = 1.0) -> None:
    """Give the viewport's camera the apertures and offsets that make this matrix (3, 3) with a focal length.

    Raises:
        ArgumentError: the matrix has another shape.
        BadPrim: the viewport's camera is not on the stage.
    """
    matrix = np.asarray(intrinsics_matrix, np.float64)
    if matrix.shape != (3, 3):
        raise ArgumentError(f"set_intrinsics_matrix: the matrix is {matrix.shape}; expected (3, 3)")
    if not np.isclose(matrix[0, 0], matrix[1, 1], rtol=1e-3):
        warn_once(
            f"set_intrinsics_matrix: the focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} differ; pixels are square "
            "here, so that the first is used for both"
        )
    prim = camera_at(str(viewport_api.get_active_camera()))
    camera, (width, height) = UsdGeom.Camera(prim), viewport_api.get_texture_resolution()
    across, down = focal_length / matrix[0, 0], focal_length / matrix[1, 1]
    with Usd.EditContext(prim.GetStage(), editable_layer(prim)):
        camera.GetFocalLengthAttr().Set(float(focal_length))
        camera.GetHorizontalApertureAttr().Set(float(width * across))
        camera.GetVerticalApertureAttr().Set(float(height * down))
        # Isaac Sim writes other numbers, which nothing reads; these move the image to where the matrix says.
        camera.GetHorizontalApertureOffsetAttr().Set(float((matrix[0, 2] - width / 2) * -across))
        camera.GetVerticalApertureOffsetAttr().Set(float((matrix[1, 2] - height / 2) * down))


def backproject_depth(depth_image: np.ndarray, viewport_api: Viewport, max_clip_depth: float) -> np.ndarray:
    """Return the points (H * W, 3) of a depth image (H, W), in the camera: +x right, +y down, +z ahead.

    Pixels with a greater depth than `max_clip_depth` are at 0, 0, 0. Unlike in Isaac Sim, a depth is that of the center
    of its pixel.
    """
    matrix = get_intrinsics_matrix(viewport_api)
    depth = np.where(depth_image > max_clip_depth, 0.0, depth_image)
    rows, columns = np.mgrid[: depth.shape[0], : depth.shape[1]]
    across, down = np.moveaxis((pixel_centers(columns, rows) - matrix[:2, 2]) / matrix.diagonal()[:2], -1, 0)
    return np.stack([across * depth, down * depth, depth], axis=-1).reshape(-1, 3)


def project_depth_to_worldspace(depth_image: np.ndarray, viewport_api: Viewport, max_clip_depth: float) -> list[Float3]:
    """Return the points of a depth image (H, W) [m] in the world [stage units], row by row.

    Depths are clipped to `max_clip_depth` [stage units]. The camera is where images show it: at the time of the
    timeline, without the scale of prims above.
    """
    stage = current_stage()
    depth = np.clip(depth_image / UsdGeom.GetStageMetersPerUnit(stage), 0.0, max_clip_depth)
    points = backproject_depth(depth, viewport_api, max_clip_depth) * (1.0, -1.0, -1.0)
    camera, size = str(viewport_api.get_active_camera()), viewport_api.get_texture_resolution()
    to_world = read_camera(stage, camera, size, time=stage_time(stage)).local_to_world
    return [Float3(*point) for point in (points @ to_world[:3, :3] + to_world[3, :3]).tolist()]


create_viewport_for_camera = refused_function("create_viewport_for_camera", _NO_WINDOW)
add_aov_to_viewport = refused_function("add_aov_to_viewport", _NO_WINDOW)
