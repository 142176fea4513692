"""A picture that fills the view: a plane far behind all objects, which shines as the picture does."""

from __future__ import annotations

import numpy as np
from pxr import Usd

from usdsdg.errors import ConfigError
from usdsdg.scenarios.shared.lighting import show
from usdsdg.scenarios.shared.pictures import Picture
from usdsdg.scenarios.shared.textured_plane import TexturedPlane
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.poses.xform_ops import author_pose

# The plane at distance 1 reaches so far at most: beyond 75 degrees off the axis it would be endless.
_WIDEST = np.tan(np.radians(75.0))
_MARGIN = 1.03


class Backdrop:
    """A plane below the prim of the view; it does not hide the sky from the objects in front of it."""

    def __init__(self, parent: Usd.Prim, view: CameraView, first: Picture) -> None:
        """
        Raises:
            ConfigError: the view is too wide for a plane.
        """
        self._root = parent.GetStage().DefinePrim(parent.GetPath().AppendChild("Backdrop"), "Xform")
        # A camera looks along its -Z. The texture is as in the picture where it is seen against +Z.
        self._plane = TexturedPlane(self._root, half_extent(view), height=-1.0, first=first, shines=True)

    def hide(self) -> None:
        """Show the sky."""
        show(self._root, False)

    def show(self, picture: Picture, distance: float, generator: np.random.Generator) -> None:
        """Show a part of a picture at a distance [stage units]."""
        show(self._root, True)
        author_pose(self._root, scale=(distance,) * 3)
        self._plane.show(picture, generator)


def half_extent(view: CameraView) -> tuple[float, float]:
    """Return how far a plane at distance 1 reaches to the sides, and up and down, to fill a view.

    Raises:
        ConfigError: the view is wider than a plane can fill.
    """
    x, y = (np.linspace(0.0, extent, 33) for extent in (view.width, view.height))
    edge = np.concatenate(
        [np.stack(np.broadcast_arrays(*each), -1) for each in ((x, 0.0), (x, y[-1]), (0.0, y), (x[-1], y))]
    )
    _, rays = view.rays(edge)
    rays = rays[np.isfinite(rays).all(axis=1)]  # beyond the lens is nothing to fill
    if not len(rays) or (rays[:, 2] >= 0.0).any() or np.abs(rays[:, :2] / rays[:, 2:]).max() > _WIDEST:
        raise ConfigError(
            "backgrounds: pictures fill views up to 150 degrees across; this camera's is wider. Set "
            "backgrounds.share_of_pictures to 0, which shows skies"
        )
    reach = np.abs(rays[:, :2] / rays[:, 2:]).max(axis=0) * _MARGIN
    return float(reach[0]), float(reach[1])
