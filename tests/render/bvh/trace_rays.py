"""Kernel that traces an array of rays, for tests and benchmarks of BVH traversal."""

import warp as wp

from usdsdg_render.kernels.scene.visibility import BY_THRESHOLD, closest, transmitted
from usdsdg_render.scene.structs import Hit, SceneTables


@wp.kernel(enable_backward=False)
def trace_rays(
    tables: SceneTables,
    any_hit: int,
    first: int,
    origins: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),
    tmax: wp.array(dtype=wp.float32),
    # out
    hits: wp.array(dtype=Hit),
):
    i = first + wp.tid()
    hit = Hit()
    if any_hit != 0:
        hit.instance = -1
        if transmitted(tables, origins[i], directions[i], tmax[i]) < 1.0:
            hit.instance = 0
    else:
        hit = closest(tables, origins[i], directions[i], 0.0, tmax[i], BY_THRESHOLD, 0.5)
    hits[i] = hit
