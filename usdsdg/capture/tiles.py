"""The cameras of a render product, and the assembly of their images: one, or several in tiles."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pxr import Usd

from usdsdg.annotators.pixels.launch import on_host
from usdsdg.session.render_products import HydraTexture
from usdsdg.stage.cameras.camera_reader import CameraReader
from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.tiled_view import TiledView


def view_of(product: HydraTexture, cameras: CameraReader, time: Usd.TimeCode) -> CameraView | TiledView:
    """Return the camera of a product at `time`, or its cameras in tiles."""
    if product.tiles is None:
        return cameras.read_product(product.path, product.shown, time=time)
    size = product.tiles.size
    views = tuple(cameras.read(camera, size, time=time) for camera in product.tiles.cameras)
    return TiledView(product.camera_path, product.width, product.height, product.width // size[0], views)


def views_of(view: CameraView | TiledView) -> tuple[CameraView, ...]:
    """Return the cameras whose images `view` is assembled from."""
    return view.views if isinstance(view, TiledView) else (view,)


def assembled(view: CameraView | TiledView, images: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Assemble the arrays of `views_of(view)`, by name, into those of the whole image.

    The image of one camera is where it was rendered, tiles come to the host. Pixels outside all tiles have the AOV's
    miss value, and 0 in color images.
    """
    if not isinstance(view, TiledView):
        return dict(images[0])
    images = [{name: on_host(array) for name, array in image.items()} for image in images]
    from usdsdg_render.labels.aov import AOVS  # imports Warp

    whole = {}
    for name, first in images[0].items():
        miss = AOVS[name].miss if name in AOVS else 0
        whole[name] = np.full((view.height, view.width, *first.shape[2:]), miss, first.dtype)
        height, width = first.shape[:2]
        for index, image in enumerate(images):
            row, column = divmod(index, view.columns)
            whole[name][row * height : (row + 1) * height, column * width : (column + 1) * width] = image[name]
    return whole
