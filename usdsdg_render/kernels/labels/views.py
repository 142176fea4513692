"""Which pixel of which picture a thread draws, and what the ray through its center meets."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import BAND, pixel_ray
from usdsdg_render.kernels.scene.visibility import closest
from usdsdg_render.scene.structs import Camera, SceneTables


@wp.struct
class Views:
    """Pictures of one size that are drawn in one launch, one below the other, each in whole bands of rows."""

    cameras: wp.array(dtype=Camera)
    width: wp.int32
    height: wp.int32
    bands: wp.int32  # of one picture


@wp.func
def picture_row(views: Views, band: int, row_of_band: int):
    """(picture, row) of a thread; the last band of a picture may reach below its last row."""
    picture = band / views.bands
    return picture, BAND * (band - picture * views.bands) + row_of_band


@wp.func
def meet_center(tables: SceneTables, camera: Camera, x: int, y: int, mode: int):
    """(ray through the center of a pixel, what it meets first); `mode` as for `closest`."""
    ray = pixel_ray(camera, x, y)
    return ray, closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
