"""The view of a tiled render product: the views of its cameras, and the size of the whole image."""

from dataclasses import dataclass

from usdsdg.stage.cameras.camera_view import CameraView


@dataclass(frozen=True)
class TiledView:
    """Several cameras whose images are tiles of one image, row by row from the top left."""

    prim_path: str  # of the first camera
    width: int  # of all tiles [pixels]
    height: int
    columns: int
    views: tuple[CameraView, ...]  # all of one size
