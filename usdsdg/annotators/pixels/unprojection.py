"""Points of depth images."""

from __future__ import annotations

import numpy as np

from usdsdg.annotators.pixels.launch import Pixels, new, run_over_pixels
from usdsdg.stage.cameras.camera_view import CameraView


def unproject(camera: CameraView, depth: Pixels) -> Pixels:
    """Return the point of each pixel of a linear camera in its optical frame [m], float32 (H * W, 3); inf for none.

    depth: (H, W) along the optical axis [m]. x is right, y down, z ahead.
    """
    from usdsdg.annotators.pixels import unprojection_kernels as kernels  # imports Warp

    points = new((*depth.shape, 3), np.float32, depth)
    pair = kernels.wp.vec2d
    lens = [pair(camera.cx, camera.cy), pair(camera.fx, camera.fy), int(camera.projection_type == "orthographic")]
    inputs = [depth, depth.shape[1], *lens, float(camera.meters_per_unit)]
    run_over_pixels(kernels.unproject, depth.size, inputs, [points])
    return points.reshape((-1, 3))
