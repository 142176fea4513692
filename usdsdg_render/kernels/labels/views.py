"""Images rendered in one launch: the pixel of each thread, and the hit of the ray through its center."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import BAND, pixel_ray
from usdsdg_render.kernels.scene.visibility import closest
from usdsdg_render.scene.structs import Camera, SceneTables


@wp.struct
class Views:
    """Cameras with images of one size, rendered in one launch; each image takes whole bands of rows."""

    cameras: wp.array(dtype=Camera)
    width: wp.int32
    height: wp.int32
    bands: wp.int32  # of one image
    are_pinholes: wp.int32  # 1 = the rays of each camera start at one point, and no lens bends them


@wp.func
def image_row(views: Views, band: int, row_of_band: int):
    """(image, row) of a thread; the last band of an image may end below its last row."""
    image = band / views.bands
    return image, BAND * (band - image * views.bands) + row_of_band


@wp.func
def trace_pixel_center(tables: SceneTables, camera: Camera, x: int, y: int, mode: int):
    """(ray through the center of a pixel, its closest hit); `mode` as for `closest`."""
    ray = pixel_ray(camera, x, y)
    return ray, closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
