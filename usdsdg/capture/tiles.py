"""The picture of a render product as the pictures of its cameras: one, or several in tiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Usd

from usdsdg.create.render_products import HydraTexture
from usdsdg.errors import Unsupported
from usdsdg.session.stage_context import current_stage
from usdsdg.stage.cameras.camera_view import CameraView, read_camera


class TiledView:
    """What takes the place of the camera of a tiled picture: its size, and nothing of which there are several.

    Any other attribute of a camera raises Unsupported.
    """

    def __init__(self, product: HydraTexture, views: Sequence[CameraView]) -> None:
        self.render_product = product.path
        self.views = tuple(views)
        self.prim_path = product.camera_path
        self.width, self.height = product.resolution
        assert product.tiles is not None
        self.columns = self.width // product.tiles.size[0]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise Unsupported(
            f"{self.render_product} shows {len(self.views)} cameras in tiles, and an annotator asks for the {name} of "
            "one. Attach that annotator to a render product of each camera (create.render_product)."
        )


def view_of(product: HydraTexture, time: Usd.TimeCode) -> Any:
    """The camera of a product as it is at `time`, or a `TiledView`."""
    if product.tiles is None:
        return read_camera(current_stage(), product.camera_path, product.resolution, time=time)
    size = product.tiles.size
    views = [read_camera(current_stage(), camera, size, time=time) for camera in product.tiles.cameras]
    return TiledView(product, views)


def views_of(view: Any) -> tuple[CameraView, ...]:
    """The cameras whose pictures make up that of `view`."""
    return view.views if isinstance(view, TiledView) else (view,)


def joined(view: Any, pictures: Sequence[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The arrays of `views_of(view)`, by name, as those of the whole picture.

    What no tile covers is what a ray gives that meets nothing, and 0 in colour pictures.
    """
    if not isinstance(view, TiledView):
        return dict(pictures[0])
    from usdsdg_render.labels.aov import AOVS

    whole = {}
    for name, first in pictures[0].items():
        nothing = AOVS[name].miss if name in AOVS else 0
        whole[name] = np.full((view.height, view.width, *first.shape[2:]), nothing, first.dtype)
        height, width = first.shape[:2]
        for index, picture in enumerate(pictures):
            row, column = divmod(index, view.columns)
            whole[name][row * height : (row + 1) * height, column * width : (column + 1) * width] = picture[name]
    return whole
