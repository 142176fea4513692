"""Parts of gprims, such as GeomSubsets of faces: which of them a hit is on, and which pixels one would cover alone.

The kernels have a module of their own, which is compiled only where scenes are divided into parts.
"""

import warp as wp

from usdsdg_render.bvh.query import unpack, wide_closest_in_part
from usdsdg_render.kernels.cameras.camera import pixel_ray
from usdsdg_render.kernels.labels.coverage import Parts, fill_kernel, hits_alone
from usdsdg_render.kernels.scene.visibility import MAX_LAYERS, opacity_of_hit
from usdsdg_render.scene.structs import Camera, SceneTables


@wp.func
def hits_part_alone(tables: SceneTables, parts: Parts, camera: Camera, x: int, y: int, entry: int, mode: int):
    """Return whether the ray through the center of a pixel would hit an entry if it were alone in the scene."""
    instance = parts.instance[entry]
    first = parts.first[instance]
    if first < 0:
        return hits_alone(tables, parts, camera, x, y, instance, mode)
    ray = pixel_ray(camera, x, y)
    t = ray.tmin
    for _layer in range(MAX_LAYERS):
        packed = wide_closest_in_part(
            tables.tlas,
            ray.origin,
            ray.direction,
            t,
            ray.tmax,
            tables.first_instance + instance,
            parts.entry,
            first,
            entry,
        )
        hit = unpack(packed)
        if hit.instance < 0:
            return False
        if opacity_of_hit(tables, hit, mode) > 0.5:
            return True
        t = hit.t
    return True


fill_words_of_parts = fill_kernel(hits_part_alone, wp.get_module(__name__))


@wp.kernel(enable_backward=False, module=wp.get_module(__name__))
def tell_parts_apart(
    parts: Parts,
    triangle: wp.array(dtype=wp.int32),
    # in and out
    entry: wp.array(dtype=wp.int32),  # of each pixel or hit: its instance, then its entry; -1 for no hit
):
    i = wp.tid()
    instance = entry[i]
    if instance >= 0 and parts.first[instance] >= 0:
        entry[i] = parts.entry[parts.first[instance] + triangle[i]]
