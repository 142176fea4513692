"""Selection weight of environment light: indoors, an occluded sky would otherwise take most of the light samples."""

import numpy as np
import warp as wp

from usdsdg.parallel import launch_rows
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.path.environment_weight import GRID_SIZE, GROUPS, sample_environment_visibility
from usdsdg_render.scene.struct_rows import uploaded
from usdsdg_render.scene.structs import Camera

# Minimum weight: keeps sampling light through windows that no point of the grid sees.
MIN_WEIGHT = 1.0 / 32.0


def environment_weights(scene: DeviceScene, cameras: np.ndarray, *, threads: int | None) -> np.ndarray:
    """Estimate the visible fraction of dome and distant light at what cameras see.

    It scales selection weights of lights, so images converge to the same result with any value.

    Args:
        cameras: camera records.

    Returns:
        (cameras,) float32 powers of two from MIN_WEIGHT to 1, so that devices with different rounding agree.
    """
    if not scene.has_local_and_environment_light:
        return np.ones(len(cameras), np.float32)
    shape = (len(cameras), GRID_SIZE * GRID_SIZE, GROUPS)
    irradiance = wp.empty(shape, dtype=wp.vec2, device=scene.device)
    inputs = [scene.tables, uploaded(cameras, Camera, scene.device)]
    launch_rows(
        sample_environment_visibility, shape, inputs, [irradiance], device=scene.device, threads=threads, band_rows=1
    )
    unoccluded, visible = irradiance.numpy().astype(np.float64).sum((1, 2)).T
    weight = np.divide(visible, unoccluded, out=np.ones_like(unoccluded), where=unoccluded > 0.0)
    return np.exp2(np.ceil(np.log2(np.clip(weight, MIN_WEIGHT, 1.0)))).astype(np.float32)
