"""How much of the light from beyond the scene, of its sky and distant lights, comes to what a camera sees."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import camera_ray
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.lights.light_sampling import sample_sky
from usdsdg_render.kernels.path.sampler import pixel_seed, sample_pair
from usdsdg_render.kernels.scene.surface import facing, surface_at
from usdsdg_render.kernels.scene.visibility import BY_THRESHOLD, FAR_AWAY, closest, transmitted
from usdsdg_render.scene.structs import LIGHT_DISTANT, Camera, SceneTables

# Points on each side of a grid over the picture, and from each directions to the sky, then to all distant lights.
POINTS = wp.constant(16)
SKY_RAYS = wp.constant(4)
ASKED = SKY_RAYS + 1


@wp.kernel(enable_backward=False, module=LABELS)
def ask_sky(
    tables: SceneTables,
    cameras: wp.array(dtype=Camera),
    first_view: int,
    # out, (views, POINTS * POINTS, ASKED): irradiance that would come if nothing were in the way, and that does
    light: wp.array3d(dtype=wp.vec2),
):
    v, point, k = wp.tid()
    v += first_view
    light[v, point, k] = wp.vec2(0.0)
    rays = wp.where(k < SKY_RAYS, 1, tables.light_count)
    if k < SKY_RAYS and tables.dome.strength <= 0.0:
        rays = 0
    if rays == 0:
        return
    camera = cameras[v]
    column = (float(point % POINTS) + 0.5) / float(POINTS) * float(camera.width)
    row = (float(point / POINTS) + 0.5) / float(POINTS) * float(camera.height)
    ray = camera_ray(camera, column, row, wp.vec2(0.0))
    hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, BY_THRESHOLD, 0.5)
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    normal = facing(surface.normal, surface.horizon, -ray.direction)
    origin = surface.position + surface.lift + surface.geometric * surface.gap
    offered = float(0.0)
    arrived = float(0.0)
    for each in range(rays):
        direction = wp.vec3(0.0)
        strength = float(0.0)
        if k < SKY_RAYS:
            seed = pixel_seed(wp.uint32(0), wp.uint32(0), point, 0)
            direction = sample_sky(tables.dome, sample_pair(seed, wp.uint32(k), 0), False).direction
            # A surface under an even sky, which meets its rays at a quarter on average, gets what `strength` says.
            strength = tables.dome.strength * 4.0 / float(SKY_RAYS)
        elif tables.lights[each].kind == LIGHT_DISTANT:
            direction = tables.lights[each].z_axis
            strength = tables.lights[each].strength
        strength *= wp.dot(normal, direction)
        if strength > 0.0 and wp.dot(surface.horizon, direction) > 0.0:
            offered += strength
            arrived += strength * transmitted(tables, origin, direction, FAR_AWAY)
    light[v, point, k] = wp.vec2(offered, arrived)
