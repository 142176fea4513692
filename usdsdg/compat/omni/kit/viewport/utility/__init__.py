"""`omni.kit.viewport.utility`: the viewport, which has no window; its image is rendered when a sensor is read."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Sdf, Usd

from usdsdg.app.app import get_app
from usdsdg.compat.omni.kit.viewport.utility.captures import capture_viewport_to_buffer as capture_viewport_to_buffer
from usdsdg.compat.omni.kit.viewport.utility.captures import capture_viewport_to_file as capture_viewport_to_file
from usdsdg.create.render_products import render_product
from usdsdg.errors import Unsupported
from usdsdg.listeners import weakly
from usdsdg.session import render_products
from usdsdg.session.render_products import HydraTexture
from usdsdg.session.session import current
from usdsdg.session.stage_context import current_stage, on_new_stage
from usdsdg.stage.cameras import viewport_cameras
from usdsdg.stage.cameras.viewport_cameras import PERSPECTIVE


class Viewport:
    """A camera and a resolution, and the render product of both, which is made when it is first asked for."""

    def __init__(self) -> None:
        self._updates_enabled = True
        self._camera = PERSPECTIVE
        self._resolution = (1280, 720)
        self._product: HydraTexture | None = None
        on_new_stage(weakly(self._leave_stage))

    @property
    def stage(self) -> Usd.Stage:
        """The current stage."""
        return current_stage()

    @property
    def updates_enabled(self) -> bool:
        """Whether images of the viewport follow the stage."""
        return self._updates_enabled

    @updates_enabled.setter
    def updates_enabled(self, enabled: bool) -> None:
        self._updates_enabled = bool(enabled)
        if (product := self._made()) is not None:
            product.set_updates_enabled(enabled)

    @property
    def camera_path(self) -> Sdf.Path:
        """Path of the camera; `/OmniverseKit_Persp` by default."""
        if (product := self._made()) is not None:
            self._camera = product.camera_path  # which a script may set on the prim
        return Sdf.Path(self._camera)

    @camera_path.setter
    def camera_path(self, path: Sdf.Path | str) -> None:
        self.set_active_camera(path)

    def get_active_camera(self) -> Sdf.Path:
        return self.camera_path

    def set_active_camera(self, path: Sdf.Path | str) -> None:
        """Look through the camera at `path`."""
        self._camera = str(path)
        if (product := self._made()) is not None:
            product.set_camera(self._camera)

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height [pixels]."""
        if (product := self._made()) is not None:
            self._resolution = product.resolution  # which a script may set on the prim
        return self._resolution

    @resolution.setter
    def resolution(self, size: Sequence[int]) -> None:
        self._resolution = int(size[0]), int(size[1])
        if (product := self._made()) is not None:
            product.set_resolution(self._resolution)

    def get_texture_resolution(self) -> tuple[int, int]:
        return self.resolution

    def set_texture_resolution(self, resolution: Sequence[int]) -> None:
        self.resolution = resolution

    @property
    def render_product_path(self) -> str:
        """Path of the viewport's render product, which is made when this is first asked for.

        Raises:
            BadPrim: the camera is not on the stage.
        """
        product = self._made()
        if product is None:
            if self._camera == PERSPECTIVE:
                viewport_cameras.author(current_stage())
            product = render_product(self._camera, self._resolution, force_new=True, name="omni_kit_widget_viewport")
            # Sensors of the viewport are computed when they are read.
            product.captured_on_play = False
            product.set_updates_enabled(self._updates_enabled)
            self._product = product
        return product.path

    @render_product_path.setter
    def render_product_path(self, path: str) -> None:
        product = render_products.product_at(str(path))
        self._product, self._camera, self._resolution = product, product.camera_path, product.resolution

    def get_render_product_path(self) -> str:
        return self.render_product_path

    def schedule_capture(self, *_: object) -> None:
        """Raise Unsupported: the objects that Kit schedules are not there."""
        raise Unsupported(
            "schedule_capture: use capture_viewport_to_file(viewport, path) or capture_viewport_to_buffer(viewport, "
            "function) of omni.kit.viewport.utility"
        )

    async def wait_for_rendered_frames(self, additional_frames: int = 0) -> bool:
        """Wait for one update of the application, and `additional_frames` more; return True."""
        await next_viewport_frame_async(self, additional_frames)
        return True

    def _made(self) -> HydraTexture | None:
        """Return its render product; None before it is made, and where it is destroyed."""
        return self._product if self._product in current().render_products.values() else None

    def _leave_stage(self, stage: Usd.Stage) -> None:
        """Look through the camera that every stage has, as the application's viewport does in a new one."""
        self._product, self._camera = None, PERSPECTIVE


class ViewportWindow:
    """A viewport under the name of its window, which is never shown."""

    def __init__(self, viewport: Viewport, name: str = "Viewport") -> None:
        self.viewport_api = viewport
        self.name = self.title = name
        self.visible = False

    def destroy(self) -> None:
        """Do nothing: there is no window."""


def get_active_viewport(usd_context_name: str = "") -> Viewport:
    """Return the viewport of the application."""
    return current().viewport


def get_active_viewport_window(*_: object, **__: object) -> ViewportWindow:
    """Return the window of the viewport, which is never shown."""
    return ViewportWindow(current().viewport)


def get_active_viewport_and_window(*_: object, **__: object) -> tuple[Viewport, ViewportWindow]:
    window = get_active_viewport_window()
    return window.viewport_api, window


def get_active_viewport_camera_path(usd_context_name: str = "") -> Sdf.Path:
    return current().viewport.camera_path


def get_active_viewport_camera_string(usd_context_name: str = "") -> str:
    """Return the path of the viewport's camera as text."""
    return str(current().viewport.camera_path)


def get_num_viewports(usd_context_name: str = "") -> int:
    """Return 1: further viewports are not counted."""
    return 1


async def next_viewport_frame_async(viewport: Viewport, n_frames: int = 0) -> None:
    """Wait for one update of the application, and `n_frames` more."""
    for _ in range(1 + n_frames):
        await get_app().next_update_async()


def frame_viewport_prims(viewport: Viewport | None = None, prims: Sequence[str] | None = None) -> bool:
    """Raise Unsupported: nothing moves the viewport's camera to frame prims."""
    raise Unsupported(
        "frame_viewport_prims: not available; place a camera with rep.create.camera(position=..., look_at=...)"
    )


def frame_viewport_selection(viewport_api: Viewport | None = None, *_: object, **__: object) -> bool:
    """Raise Unsupported: nothing moves the viewport's camera to frame prims."""
    return frame_viewport_prims(viewport_api)


def get_viewport_from_window_name(window_name: str = "") -> Viewport:
    """Return the viewport of the application, whatever the name of its window."""
    return current().viewport


def create_viewport_window(
    name: str | None = None,
    usd_context_name: str = "",
    width: int = 1280,
    height: int = 720,
    position_x: int = 0,
    position_y: int = 0,
    camera_path: Sdf.Path | str | None = None,
    **_: object,
) -> ViewportWindow:
    """Return a further viewport, whose camera is `camera_path` and whose images have the size of the window."""
    viewport = Viewport()
    viewport.resolution = width, height
    if camera_path is not None:
        viewport.set_active_camera(camera_path)
    return ViewportWindow(viewport, name or "Viewport")
