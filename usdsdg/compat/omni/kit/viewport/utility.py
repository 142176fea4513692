"""`omni.kit.viewport.utility`: the settings of the viewport, which has no window."""

from usdsdg.session.session import current


class Viewport:
    """Updates, camera and resolution of the viewport, which scripts set; they have no effect."""

    updates_enabled = True
    camera_path = "/OmniverseKit_Persp"
    resolution = (1280, 720)

    def set_active_camera(self, path: str) -> None:
        self.camera_path = str(path)


def get_active_viewport(usd_context_name: str = "") -> Viewport:
    return current().viewport


def get_active_viewport_window(*_: object, **__: object) -> None:
    """Return None: there is no window."""
    return None
