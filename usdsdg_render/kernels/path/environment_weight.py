"""Estimates how much of the light of the dome and of distant lights reaches what a camera sees."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import camera_ray
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.lights.light_sampling import sample_environment
from usdsdg_render.kernels.path.sampler import pixel_seed, sample_pair
from usdsdg_render.kernels.scene.surface import ensure_valid_reflection, surface_at
from usdsdg_render.kernels.scene.visibility import BY_THRESHOLD, FAR_AWAY, closest, transmitted
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import LIGHT_DISTANT, Camera, SceneTables

# Points per side of a grid over the image; from each point rays to the dome, then to all distant lights as one group.
GRID_SIZE = wp.constant(16)
DOME_RAYS = wp.constant(4)
GROUPS = DOME_RAYS + 1
# Minimum weight: keeps sampling light through windows that no point of the grid sees.
MIN_WEIGHT = 1.0 / 32.0


@wp.kernel(enable_backward=False, module=LABELS)
def sample_environment_visibility(
    tables: SceneTables,
    cameras: wp.array(dtype=Camera),
    first_view: int,
    # out, (views, GRID_SIZE^2, GROUPS): unoccluded irradiance, and the part of it that is visible
    irradiance: wp.array3d(dtype=wp.vec2),
):
    v, point, group = wp.tid()
    v += first_view
    camera = cameras[v]
    tables = in_world(tables, camera.world)
    irradiance[v, point, group] = wp.vec2(0.0)
    rays = wp.where(group < DOME_RAYS, 1, tables.light_count)
    if group < DOME_RAYS and tables.dome.strength <= 0.0:
        rays = 0
    if rays == 0:
        return
    column = (float(point % GRID_SIZE) + 0.5) / float(GRID_SIZE) * float(camera.width)
    row = (float(point / GRID_SIZE) + 0.5) / float(GRID_SIZE) * float(camera.height)
    ray = camera_ray(camera, column, row, wp.vec2(0.0))
    hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, BY_THRESHOLD, 0.5)
    if hit.instance < 0:
        return
    surface = surface_at(tables, hit, ray.direction)
    normal = ensure_valid_reflection(surface.normal, surface.horizon_normal, -ray.direction)
    origin = surface.position + surface.terminator_offset + surface.geometric * surface.ray_epsilon
    unoccluded = float(0.0)
    visible = float(0.0)
    for each in range(rays):
        direction = wp.vec3(0.0)
        strength = float(0.0)
        if group < DOME_RAYS:
            seed = pixel_seed(wp.uint32(0), wp.uint32(0), point, 0)
            direction = sample_environment(tables.dome, sample_pair(seed, wp.uint32(group), 0), False).direction
            # Scaled such that under a uniform sky the sum is `strength`: sampled cosines average a quarter.
            strength = tables.dome.strength * 4.0 / float(DOME_RAYS)
        elif tables.lights[each].kind == LIGHT_DISTANT:
            direction = tables.lights[each].z_axis
            strength = tables.lights[each].strength
        strength *= wp.dot(normal, direction)
        if strength > 0.0 and wp.dot(surface.horizon_normal, direction) > 0.0:
            unoccluded += strength
            visible += strength * transmitted(tables, origin, direction, FAR_AWAY)
    irradiance[v, point, group] = wp.vec2(unoccluded, visible)


@wp.kernel(enable_backward=False, module=LABELS)
def weigh_environment(
    irradiance: wp.array3d(dtype=wp.vec2),
    # out
    cameras: wp.array(dtype=Camera),
):
    # A power of two, so that devices with different rounding agree.
    v = wp.tid()
    unoccluded = wp.float64(0.0)
    visible = wp.float64(0.0)
    for point in range(irradiance.shape[1]):
        for group in range(irradiance.shape[2]):
            both = irradiance[v, point, group]
            unoccluded += wp.float64(both[0])
            visible += wp.float64(both[1])
    weight = float(1.0)
    while weight > MIN_WEIGHT and visible <= unoccluded * wp.float64(0.5 * weight) and unoccluded > wp.float64(0.0):
        weight = 0.5 * weight
    cameras[v].environment_weight = weight
