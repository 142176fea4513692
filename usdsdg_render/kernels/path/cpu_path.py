"""The CPU's path tracer: adds samples to a film, one thread a pixel, all samples of a call in a loop."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import camera_ray
from usdsdg_render.kernels.path.film import FilmArrays, PixelSums, load_pixel, store_pixel, with_sample
from usdsdg_render.kernels.path.path_state import Feature, LightAovs, PathOptions, begin_path
from usdsdg_render.kernels.path.sampler import PAIR_LENS, PAIR_PIXEL, pixel_seed, sample_pair
from usdsdg_render.kernels.path.segment import arrive, connected, depart, next_hit
from usdsdg_render.kernels.scene.visibility import transmitted
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
    """The sums of a pixel with the light that arrives through one point of it."""
    lens = wp.vec2(0.0)
    if camera.lens_radius > 0.0:
        lens = sample_pair(seed, index, PAIR_LENS)
    path = begin_path(camera_ray(camera, column, row, lens), camera.sky_share)
    if path.alive == 0:
        return sums
    light_aovs = LightAovs()
    feature = Feature(albedo=wp.vec3(1.0), normal=wp.vec3(0.0), depth=0.0)
    # The last surface may need a segment more, on which only lights count.
    for bounce in range(options.bounces + options.glass_bounces + 1):
        if path.alive == 0:
            break
        hit = next_hit(tables, path, bounce, seed, index)
        arrival = arrive(tables, options, path, light_aovs, hit, bounce)
        path = arrival.path
        light_aovs = arrival.light_aovs
        if path.alive != 0:
            left = depart(tables, options, path, light_aovs, hit, bounce, seed, index)
            path = left.path
            light_aovs = left.light_aovs
            if bounce == 0:
                feature = left.feature
            light = left.connection.light
            if light[0] + light[1] + light[2] > 0.0:
                share = transmitted(tables, path.origin, left.connection.direction, left.connection.distance)
                if share > 0.0:
                    arrival = connected(path, light_aovs, left.connection, share, bounce)
                    path = arrival.path
                    light_aovs = arrival.light_aovs
    return with_sample(sums, options, path.radiance, feature, light_aovs)


@wp.kernel(enable_backward=False)
def add_samples(
    tables: SceneTables,
    options: PathOptions,
    camera: Camera,
    first_row: int,
    # in and out
    film: FilmArrays,
):
    y, x = wp.tid()
    y += first_row
    seed = pixel_seed(options.seed, options.frame, x, y)
    sums = load_pixel(film, options, y, x)
    for k in range(options.samples):
        index = wp.uint32(options.first_sample + k)
        jitter = sample_pair(seed, index, PAIR_PIXEL)
        sums = trace_path(tables, options, camera, float(x) + jitter[0], float(y) + jitter[1], index, seed, sums)
    store_pixel(film, options, y, x, sums)
