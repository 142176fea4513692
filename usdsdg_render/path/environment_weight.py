"""Selection weight of environment light: indoors, an occluded sky would otherwise take most of the light samples."""

import warp as wp

from usdsdg.parallel import CUDA_BLOCK, launch_rows
from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.kernels.path.environment_weight import (
    GRID_SIZE,
    GROUPS,
    sample_environment_visibility,
    weigh_environment,
)


def set_environment_weights(scene: DeviceScene, cameras: wp.array, *, threads: int | None) -> None:
    """Estimate the visible fraction of dome and distant light at what cameras see, and set their weights to it.

    The weight scales selection weights of lights, so images converge to the same result with any value. It is a power
    of two from `MIN_WEIGHT` to 1, and stays 1 where a scene does not have both local and environment light.

    Args:
        cameras: camera records on the device of the scene.
    """
    if not scene.has_local_and_environment_light:
        return
    count = len(cameras)
    shape = (count, GRID_SIZE * GRID_SIZE, GROUPS)
    irradiance = wp.empty(shape, dtype=wp.vec2, device=scene.device)
    launch_rows(
        sample_environment_visibility, shape, [scene.tables, cameras], [irradiance], device=scene.device,
        threads=threads, band_rows=1,
    )  # fmt: skip
    # On the device, which would otherwise have to finish all before it for the host to look.
    inputs, outputs = [irradiance], [cameras]
    wp.launch(weigh_environment, count, inputs, outputs, device=scene.device, block_dim=CUDA_BLOCK)
