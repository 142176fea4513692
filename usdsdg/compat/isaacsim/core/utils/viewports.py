"""`isaacsim.core.utils.viewports`: the pose of cameras that a viewport would show; there are no windows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdsdg.compat.omni.kit.viewport.utility import Viewport, get_active_viewport
from usdsdg.compat.wrappers.cameras import aim
from usdsdg.compat.wrappers.unsupported import refused_function

_NO_WINDOW = "there are no viewport windows; make a render product with rep.create.render_product"


def set_camera_view(
    eye: Sequence[float] | np.ndarray,
    target: Sequence[float] | np.ndarray,
    camera_prim_path: str = "/OmniverseKit_Persp",
    viewport_api: Viewport | None = None,
) -> None:
    """Move a camera to `eye` and point it at `target`, both (3,) in the world [stage units].

    `/OmniverseKit_Persp` is defined if the stage has none.

    Raises:
        BadPrim: there is no such camera.
        DegenerateFrame: eye and target coincide.
    """
    aim(camera_prim_path, eye, target)


def set_active_viewport_camera(camera_prim_path: str) -> None:
    """Name the camera of the viewport, which shows nothing."""
    get_active_viewport().set_active_camera(camera_prim_path)


def get_viewport_names(usd_context_name: str | None = None) -> list[str]:
    """Return []: there are no windows."""
    return []


create_viewport_for_camera = refused_function("create_viewport_for_camera", _NO_WINDOW)
add_aov_to_viewport = refused_function("add_aov_to_viewport", _NO_WINDOW)
