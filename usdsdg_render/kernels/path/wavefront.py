"""CUDA's path tracer: a wavefront of paths advances segment by segment, so that neighboring threads do alike.

A wavefront holds some samples of some pixels. Queues hold path numbers, and `counts` how many there are of each segment
(`count_of`): RAYS paths wait for their ray, of these HITS hit a surface and MISSES hit none, and SHADOW_RAYS wait for
their shadow ray. The order in a queue differs from run to run, but each path has its own sums, and these are added to
the film in the order of the samples.
"""

import warp as wp

from usdsdg_render.kernels.cameras.camera import BAND, camera_ray
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path.direct_light import add_direct_light
from usdsdg_render.kernels.path.emission import add_emission
from usdsdg_render.kernels.path.film import FilmArrays, load_pixel, store_pixel, with_sample
from usdsdg_render.kernels.path.path_memory import (
    load_features,
    load_hit,
    load_path,
    load_shadow_ray,
    store_features,
    store_hit,
    store_path,
    store_radiance,
    store_shadow_ray,
)
from usdsdg_render.kernels.path.path_state import DenoiserFeatures, LightAovs, PathOptions, begin_path
from usdsdg_render.kernels.path.sampler import PAIR_LENS, PAIR_PIXEL, pixel_seed, sample_pair
from usdsdg_render.kernels.path.segment import next_hit, scatter_path
from usdsdg_render.kernels.scene.visibility import transmitted
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Hit, SceneTables

# On CUDA: approximate division, square root and powers, to an ulp or two, far below the noise.
wp.set_module_options({"fast_math": True})

BLOCK = 128  # threads of a CUDA block

# Counts of a segment.
RAYS, HITS, MISSES, SHADOW_RAYS = (wp.constant(count) for count in range(4))
COUNTS = wp.constant(4)

# Registers of a thread at most: with fewer, more threads hide the latency of loads, until spills cost more than that.
INTERSECTION_REGISTERS, MISS_REGISTERS, SHADING_REGISTERS = 80, 128, 168

# Append to a queue: one atomic for all threads of a warp. On a CPU, for tests, there is one thread.
_PUSH = """
#if defined(__CUDA_ARCH__)
    const unsigned mask = __activemask();
    const int lane = threadIdx.x & 31, leader = __ffs(mask) - 1;
    int first = 0;
    if (lane == leader)
        first = atomicAdd(counts.data + which, __popc(mask));
    return __shfl_sync(mask, first, leader) + __popc(mask & ((1u << lane) - 1u));
#else
    return counts.data[which]++;
#endif
"""


@wp.func_native(_PUSH)
def push(counts: wp.array(dtype=wp.int32), which: int) -> int: ...


@wp.struct
class Wavefront:
    """The paths in flight; path number k is sample k % samples of the pixel number first_pixel + k / samples.

    Rays of one pixel are the most alike, so they are neighbors. Pixels are numbered through all views, one after the
    other.
    """

    first_pixel: wp.int32
    pixels: wp.int32
    samples: wp.int32
    paths: wp.array2d(dtype=wp.vec4)  # planes of `Path`, as all such arrays see `path_memory`
    light_aovs: wp.array(dtype=LightAovs)  # empty unless allocated
    features: wp.array2d(dtype=wp.vec4)  # of `DenoiserFeatures`; empty unless allocated
    hits: wp.array2d(dtype=wp.vec4)  # of `Hit`
    shadow_rays: wp.array2d(dtype=wp.vec4)  # of `ShadowRay`
    ray_queue: wp.array2d(dtype=wp.int32)  # two queues: of even and of odd segments
    hit_queue: wp.array(dtype=wp.int32)  # paths that hit a surface, and from the end on those that did not
    shadow_queue: wp.array(dtype=wp.int32)
    counts: wp.array(dtype=wp.int32)


@wp.func
def count_of(segment: int, kind: int):
    """Return the index in `counts`."""
    return COUNTS * segment + kind


@wp.struct
class PathSample:
    """Pixel and sample index of a path, and the seed of its pixel."""

    view: wp.int32
    world: wp.int32
    x: wp.int32
    y: wp.int32
    seed: wp.uint32
    index: wp.uint32


@wp.func
def pixel_at(views: Views, index: int):
    """Return (view, x, y) of a pixel by its number, along columns of bands of four rows to keep warps coherent."""
    view = index // (views.width * views.height)
    in_view = index - view * views.width * views.height
    band = in_view // (BAND * views.width)
    rows = wp.min(BAND, views.height - BAND * band)
    in_band = in_view - BAND * band * views.width
    return wp.vec3i(view, in_band // rows, BAND * band + in_band % rows)


@wp.func
def sample_of(wavefront: Wavefront, options: PathOptions, views: Views, number: int):
    pixel = pixel_at(views, wavefront.first_pixel + number / wavefront.samples)
    sample = PathSample()
    sample.view = pixel[0]
    sample.x = pixel[1]
    sample.y = pixel[2]
    sample.world = views.cameras[sample.view].world
    sample.seed = pixel_seed(options.seed, options.frame + wp.uint32(sample.world), sample.x, sample.y)
    sample.index = wp.uint32(options.first_sample + number % wavefront.samples)
    return sample


@wp.func
def light_aovs_of(wavefront: Wavefront, number: int):
    if wavefront.light_aovs.shape[0] > 0:
        return wavefront.light_aovs[number]
    return LightAovs()


@wp.kernel(enable_backward=False)
def generate_camera_rays(options: PathOptions, views: Views, wavefront: Wavefront):
    number = wp.tid()
    sample = sample_of(wavefront, options, views, number)
    camera = views.cameras[sample.view]
    jitter = sample_pair(sample.seed, sample.index, PAIR_PIXEL)
    lens = wp.vec2(0.0)
    if camera.lens_radius > 0.0:
        lens = sample_pair(sample.seed, sample.index, PAIR_LENS)
    ray = camera_ray(camera, float(sample.x) + jitter[0], float(sample.y) + jitter[1], lens)
    path = begin_path(ray, camera.environment_weight)
    if wavefront.light_aovs.shape[0] > 0:
        wavefront.light_aovs[number] = LightAovs()
    if wavefront.features.shape[0] > 0:
        nothing = DenoiserFeatures(albedo=wp.vec3(1.0), normal=wp.vec3(0.0), depth=0.0, emission=wp.vec3(0.0))
        store_features(wavefront.features, number, nothing)
    if path.alive != 0:
        wavefront.ray_queue[0, push(wavefront.counts, RAYS)] = number
    else:
        path.bounces = -1
    store_path(wavefront.paths, number, path)


@wp.kernel(enable_backward=False, cuda_max_registers=INTERSECTION_REGISTERS)
def intersect_closest(tables: SceneTables, options: PathOptions, views: Views, wavefront: Wavefront, segment: int):
    i = wp.tid()
    if i >= wavefront.counts[count_of(segment, RAYS)]:
        return
    number = wavefront.ray_queue[segment % 2, i]
    sample = sample_of(wavefront, options, views, number)
    tables = in_world(tables, sample.world)
    path = load_path(wavefront.paths, number)
    hit = next_hit(tables, path, segment, sample.seed, sample.index)
    if hit.instance >= 0:
        store_hit(wavefront.hits, number, hit)
        wavefront.hit_queue[push(wavefront.counts, count_of(segment, HITS))] = number
    else:
        place = push(wavefront.counts, count_of(segment, MISSES))
        wavefront.hit_queue[wavefront.hit_queue.shape[0] - 1 - place] = number


@wp.kernel(enable_backward=False, cuda_max_registers=MISS_REGISTERS)
def shade_misses(tables: SceneTables, options: PathOptions, views: Views, wavefront: Wavefront, segment: int):
    """Add what paths see that hit no surface; they end."""
    i = wp.tid()
    if i >= wavefront.counts[count_of(segment, MISSES)]:
        return
    number = wavefront.hit_queue[wavefront.hit_queue.shape[0] - 1 - i]
    if tables.worlds.shape[0] > 0:
        tables = in_world(tables, sample_of(wavefront, options, views, number).world)
    path = load_path(wavefront.paths, number)
    nothing = Hit()
    nothing.instance = -1
    update = add_emission(tables, options, path, light_aovs_of(wavefront, number), nothing, segment)
    store_radiance(wavefront.paths, number, update.path)
    if wavefront.light_aovs.shape[0] > 0:
        wavefront.light_aovs[number] = update.light_aovs


@wp.kernel(enable_backward=False, cuda_max_registers=SHADING_REGISTERS)
def shade(tables: SceneTables, options: PathOptions, views: Views, wavefront: Wavefront, segment: int):
    """Scatter the paths that hit a surface."""
    i = wp.tid()
    if i >= wavefront.counts[count_of(segment, HITS)]:
        return
    number = wavefront.hit_queue[i]
    hit = load_hit(wavefront.hits, number)
    sample = sample_of(wavefront, options, views, number)
    tables = in_world(tables, sample.world)
    arriving = load_path(wavefront.paths, number)
    update = add_emission(tables, options, arriving, light_aovs_of(wavefront, number), hit, segment)
    path = update.path
    light_aovs = update.light_aovs
    if path.alive != 0:
        scattering = scatter_path(tables, options, path, light_aovs, hit, segment, sample.seed, sample.index)
        path = scattering.path
        light_aovs = scattering.light_aovs
        if segment == 0 and wavefront.features.shape[0] > 0:
            store_features(wavefront.features, number, scattering.features)
        radiance = scattering.shadow_ray.radiance
        if radiance[0] + radiance[1] + radiance[2] > 0.0:
            store_shadow_ray(wavefront.shadow_rays, number, scattering.shadow_ray)
            wavefront.shadow_queue[push(wavefront.counts, count_of(segment, SHADOW_RAYS))] = number
        if path.alive != 0:
            wavefront.ray_queue[(segment + 1) % 2, push(wavefront.counts, count_of(segment + 1, RAYS))] = number
    # A shadow ray starts at the origin of a path that ended.
    store_path(wavefront.paths, number, path)
    if wavefront.light_aovs.shape[0] > 0:
        wavefront.light_aovs[number] = light_aovs


@wp.kernel(enable_backward=False, cuda_max_registers=INTERSECTION_REGISTERS)
def intersect_shadow(tables: SceneTables, options: PathOptions, views: Views, wavefront: Wavefront, segment: int):
    i = wp.tid()
    if i >= wavefront.counts[count_of(segment, SHADOW_RAYS)]:
        return
    number = wavefront.shadow_queue[i]
    if tables.worlds.shape[0] > 0:
        tables = in_world(tables, sample_of(wavefront, options, views, number).world)
    path = load_path(wavefront.paths, number)
    shadow_ray = load_shadow_ray(wavefront.shadow_rays, number)
    visibility = transmitted(tables, path.origin, shadow_ray.direction, shadow_ray.distance)
    if visibility > 0.0:
        update = add_direct_light(path, light_aovs_of(wavefront, number), shadow_ray, visibility, segment)
        store_radiance(wavefront.paths, number, update.path)
        if wavefront.light_aovs.shape[0] > 0:
            wavefront.light_aovs[number] = update.light_aovs


@wp.kernel(enable_backward=False)
def update_film(options: PathOptions, views: Views, wavefront: Wavefront, films: wp.array(dtype=FilmArrays)):
    i = wp.tid()
    pixel = pixel_at(views, wavefront.first_pixel + i)
    film = films[pixel[0]]
    x = pixel[1]
    y = pixel[2]
    sums = load_pixel(film, options, y, x)
    for k in range(wavefront.samples):
        number = i * wavefront.samples + k
        path = load_path(wavefront.paths, number)
        if path.bounces >= 0:
            features = DenoiserFeatures()
            if wavefront.features.shape[0] > 0:
                features = load_features(wavefront.features, number)
            sums = with_sample(sums, options, path.radiance, features, light_aovs_of(wavefront, number))
    store_pixel(film, options, y, x, sums)
