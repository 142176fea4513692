"""CPU path tracer: adds samples to a film; one thread per pixel loops over the samples of a call."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import camera_ray
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path.direct_light import add_direct_light
from usdsdg_render.kernels.path.emission import add_emission
from usdsdg_render.kernels.path.film import FilmArrays, PixelSums, load_pixel, store_pixel, with_sample
from usdsdg_render.kernels.path.path_state import DenoiserFeatures, LightAovs, PathOptions, begin_path
from usdsdg_render.kernels.path.sampler import PAIR_LENS, PAIR_PIXEL, pixel_seed, sample_pair
from usdsdg_render.kernels.path.segment import next_hit, scatter_path
from usdsdg_render.kernels.scene.visibility import transmitted
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Camera, SceneTables


@wp.func
def trace_path(
    tables: SceneTables,
    options: PathOptions,
    camera: Camera,
    column: float,
    row: float,
    index: wp.uint32,
    seed: wp.uint32,
    sums: PixelSums,
):
    """Trace one path through a point of a pixel and add it to the pixel's sums."""
    lens = wp.vec2(0.0)
    if camera.lens_radius > 0.0:
        lens = sample_pair(seed, index, PAIR_LENS)
    path = begin_path(camera_ray(camera, column, row, lens), camera.environment_weight)
    if path.alive == 0:
        return sums
    light_aovs = LightAovs()
    features = DenoiserFeatures(albedo=wp.vec3(1.0), normal=wp.vec3(0.0), depth=0.0, emission=wp.vec3(0.0))
    # One segment more than surfaces: on the last one only lights count.
    for segment in range(options.bounces + options.glass_bounces + 1):
        if path.alive == 0:
            break
        hit = next_hit(tables, path, segment, seed, index)
        update = add_emission(tables, options, path, light_aovs, hit, segment)
        path = update.path
        light_aovs = update.light_aovs
        if path.alive != 0:
            scattering = scatter_path(tables, options, path, light_aovs, hit, segment, seed, index)
            path = scattering.path
            light_aovs = scattering.light_aovs
            if segment == 0:
                features = scattering.features
            ray = scattering.shadow_ray
            if ray.radiance[0] + ray.radiance[1] + ray.radiance[2] > 0.0:
                visibility = transmitted(tables, path.origin, ray.direction, ray.distance)
                if visibility > 0.0:
                    update = add_direct_light(path, light_aovs, ray, visibility, segment)
                    path = update.path
                    light_aovs = update.light_aovs
    return with_sample(sums, options, path.radiance, features, light_aovs)


@wp.kernel(enable_backward=False)
def add_samples(
    tables: SceneTables,
    options: PathOptions,
    views: Views,
    first_row: int,  # of all images, one below the other
    # in and out
    films: wp.array(dtype=FilmArrays),
):
    row, x = wp.tid()
    row += first_row
    view = row / views.height
    y = row - view * views.height
    camera = views.cameras[view]
    film = films[view]
    tables = in_world(tables, camera.world)
    seed = pixel_seed(options.seed, options.frame + wp.uint32(camera.world), x, y)
    sums = load_pixel(film, options, y, x)
    for k in range(options.samples):
        index = wp.uint32(options.first_sample + k)
        jitter = sample_pair(seed, index, PAIR_PIXEL)
        sums = trace_path(tables, options, camera, float(x) + jitter[0], float(y) + jitter[1], index, seed, sums)
    store_pixel(film, options, y, x, sums)
