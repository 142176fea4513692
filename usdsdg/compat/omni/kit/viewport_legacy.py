"""`omni.kit.viewport_legacy`, before 2022 `omni.kit.viewport`: the viewport by its interface of that time."""

from __future__ import annotations

from pxr import Gf, Sdf

from usdsdg.compat.omni.kit.viewport.utility import Viewport, get_active_viewport
from usdsdg.compat.omni.kit.viewport.utility.camera_state import ViewportCameraState

__all__ = [
    "IViewportWindow", "ViewportInterface", "acquire_viewport_interface", "get_default_viewport_window",
    "get_viewport_interface",
]  # fmt: skip

NAME = "Viewport"


class IViewportWindow:
    """The viewport; there is no window that could be placed or hidden."""

    def __init__(self, viewport: Viewport) -> None:
        self._viewport = viewport

    @property
    def render_product_path(self) -> str:
        """Path of its render product, by which sensors know it."""
        return self._viewport.render_product_path

    @property
    def camera_path(self) -> Sdf.Path:
        return self._viewport.camera_path

    @property
    def resolution(self) -> tuple[int, int]:
        return self._viewport.resolution

    def get_render_product_path(self) -> str:
        return self._viewport.render_product_path

    def get_active_camera(self) -> str:
        return str(self._viewport.camera_path)

    def set_active_camera(self, path: str) -> None:
        self._viewport.set_active_camera(path)

    def get_texture_resolution(self) -> tuple[int, int]:
        return self._viewport.resolution

    def set_texture_resolution(self, width: int, height: int) -> None:
        self._viewport.resolution = (width, height)

    def set_camera_position(self, path: str, x: float, y: float, z: float, rotate: bool) -> None:
        """Move a camera in the world; with `rotate` it looks at its target from there."""
        ViewportCameraState(path, self._viewport).set_position_world(Gf.Vec3d(x, y, z), rotate)

    def get_camera_position(self, path: str) -> tuple[bool, float, float, float]:
        """Return True and where a camera is in the world."""
        return (True, *ViewportCameraState(path, self._viewport).position_world)

    def set_camera_target(self, path: str, x: float, y: float, z: float, rotate: bool) -> None:
        """Turn a camera to a point of the world; without `rotate` it is moved along with its target instead."""
        ViewportCameraState(path, self._viewport).set_target_world(Gf.Vec3d(x, y, z), rotate)

    def get_camera_target(self, path: str) -> tuple[bool, float, float, float]:
        """Return True and the point of the world that a camera looks at."""
        return (True, *ViewportCameraState(path, self._viewport).target_world)

    def get_id(self) -> int:
        return 0

    def get_window_name(self) -> str:
        return NAME

    def is_visible(self) -> bool:
        return False

    def set_window_pos(self, x: int, y: int) -> None:
        """Do nothing: there is no window."""

    set_window_size = set_window_pos

    def set_visible(self, visible: bool) -> None:
        """Do nothing: there is no window."""

    show_hide_window = set_visible


class ViewportInterface:
    """Gives the one viewport."""

    def get_viewport_window(self, handle: int | None = None) -> IViewportWindow:
        return IViewportWindow(get_active_viewport())

    def get_instance(self, name: str = NAME) -> int:
        return 0

    def get_instance_list(self) -> list[int]:
        return [0]

    def get_viewport_window_name(self, handle: int = 0) -> str:
        return NAME


def get_viewport_interface() -> ViewportInterface:
    return ViewportInterface()


acquire_viewport_interface = get_viewport_interface


def get_default_viewport_window() -> IViewportWindow:
    """Return the viewport."""
    return get_viewport_interface().get_viewport_window()
