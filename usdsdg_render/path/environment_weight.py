"""How often light is looked for beyond the scene: in rooms, a sky that nobody sees would take most of the samples."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdsdg_render.device.device_scene import DeviceScene
from usdsdg_render.device.parallel import launch_rows
from usdsdg_render.kernels.path.environment_weight import ASKED, POINTS, ask_sky
from usdsdg_render.scene.struct_rows import uploaded
from usdsdg_render.scene.structs import Camera

# Of what would come if nothing were in the way: windows that no point of the grid sees are still looked for.
LEAST = 1.0 / 32.0


def sky_shares(scene: DeviceScene, cameras: np.ndarray, *, threads: int | None) -> np.ndarray:
    """How much of the light of sky and distant lights comes to what cameras see, roughly.

    It is a weight in the choice among lights, so pictures are right with any.

    Args:
        cameras: records of cameras.

    Returns:
        (cameras,) float32 powers of two from LEAST to 1, on which devices that round differently agree.
    """
    if not scene.lit_from_near_and_far:
        return np.ones(len(cameras), np.float32)
    shape = (len(cameras), POINTS * POINTS, ASKED)
    light = wp.empty(shape, dtype=wp.vec2, device=scene.device)
    inputs = [scene.tables, uploaded(cameras, Camera, scene.device)]
    launch_rows(ask_sky, shape, inputs, [light], device=scene.device, threads=threads, band_rows=1)
    offered, arrived = light.numpy().astype(np.float64).sum((1, 2)).T
    share = np.divide(arrived, offered, out=np.ones_like(offered), where=offered > 0.0)
    return np.exp2(np.ceil(np.log2(np.clip(share, LEAST, 1.0)))).astype(np.float32)
