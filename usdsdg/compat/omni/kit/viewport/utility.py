"""`omni.kit.viewport.utility`: there is no window, so the viewport is only switched."""

from usdsdg.session.session import current


class Viewport:
    """What scripts switch: updates, camera and resolution of the window that is not there."""

    updates_enabled = True
    camera_path = "/OmniverseKit_Persp"
    resolution = (1280, 720)

    def set_active_camera(self, path: str) -> None:
        self.camera_path = str(path)


def get_active_viewport(usd_context_name: str = "") -> Viewport:
    return current().viewport


def get_active_viewport_window(*_: object, **__: object) -> None:
    """No window exists."""
    return None
