"""CUDA's path tracer: many paths take each step together, so that neighbouring threads do alike.

A wave holds some samples of some pixels. Its paths wait in queues of numbers; counts[2 b] paths wait for their ray
number b, and counts[2 b + 1] of those for light that their surface number b scatters. The order in a queue differs from
run to run, but each path keeps its own sums, and they are added to the film in the order of the samples.
"""

import warp as wp

from usdsdg_render.kernels.cameras.camera import BAND, camera_ray
from usdsdg_render.kernels.labels.views import Views
from usdsdg_render.kernels.path.film import FilmArrays, load_pixel, store_pixel, with_sample
from usdsdg_render.kernels.path.path_state import Connection, Feature, LightAovs, Path, PathOptions, begin_path
from usdsdg_render.kernels.path.sampler import PAIR_LENS, PAIR_PIXEL, pixel_seed, sample_pair
from usdsdg_render.kernels.path.segment import arrive, connected, depart, next_hit
from usdsdg_render.kernels.scene.visibility import transmitted
from usdsdg_render.scene.structs import Hit, SceneTables

# The threads of a warp take their places together. On a CPU, for tests, there is one thread.
_TAKE_PLACE = """
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


@wp.func_native(_TAKE_PLACE)
def take_place(counts: wp.array(dtype=wp.int32), which: int) -> int: ...


@wp.struct
class Wave:
    """The paths of a wave; path number k is sample k / pixels of the pixel number first_pixel + k % pixels.

    Pixels are counted through all pictures, one after the other.
    """

    first_pixel: wp.int32
    pixels: wp.int32
    samples: wp.int32
    paths: wp.array(dtype=Path)
    light_aovs: wp.array(dtype=LightAovs)  # empty unless asked for
    features: wp.array(dtype=Feature)  # empty unless asked for
    hits: wp.array(dtype=Hit)
    connections: wp.array(dtype=Connection)
    rays: wp.array2d(dtype=wp.int32)  # two queues: of an even step, and of an odd one
    shadows: wp.array(dtype=wp.int32)
    counts: wp.array(dtype=wp.int32)


@wp.struct
class Place:
    """Where a path began."""

    picture: wp.int32
    x: wp.int32
    y: wp.int32
    seed: wp.uint32
    index: wp.uint32


@wp.func
def pixel_at(views: Views, number: int):
    """(picture, x, y) of a pixel by its number: along columns of bands of four rows, so that a warp looks one way."""
    picture = number // (views.width * views.height)
    of_picture = number - picture * views.width * views.height
    band = of_picture // (BAND * views.width)
    rows = wp.min(BAND, views.height - BAND * band)
    inside = of_picture - BAND * band * views.width
    return wp.vec3i(picture, inside // rows, BAND * band + inside % rows)


@wp.func
def place_of(wave: Wave, options: PathOptions, views: Views, number: int):
    pixel = pixel_at(views, wave.first_pixel + number % wave.pixels)
    place = Place()
    place.picture = pixel[0]
    place.x = pixel[1]
    place.y = pixel[2]
    place.seed = pixel_seed(options.seed, options.frame, place.x, place.y)
    place.index = wp.uint32(options.first_sample + number // wave.pixels)
    return place


@wp.func
def light_aovs_of(wave: Wave, number: int):
    if wave.light_aovs.shape[0] > 0:
        return wave.light_aovs[number]
    return LightAovs()


@wp.kernel(enable_backward=False)
def begin(options: PathOptions, views: Views, wave: Wave):
    number = wp.tid()
    place = place_of(wave, options, views, number)
    camera = views.cameras[place.picture]
    jitter = sample_pair(place.seed, place.index, PAIR_PIXEL)
    lens = wp.vec2(0.0)
    if camera.lens_radius > 0.0:
        lens = sample_pair(place.seed, place.index, PAIR_LENS)
    ray = camera_ray(camera, float(place.x) + jitter[0], float(place.y) + jitter[1], lens)
    path = begin_path(ray, camera.sky_share)
    if wave.light_aovs.shape[0] > 0:
        wave.light_aovs[number] = LightAovs()
    if wave.features.shape[0] > 0:
        wave.features[number] = Feature(albedo=wp.vec3(1.0), normal=wp.vec3(0.0), depth=0.0)
    if path.alive != 0:
        wave.rays[0, take_place(wave.counts, 0)] = number
    else:
        path.met = -1
    wave.paths[number] = path


@wp.kernel(enable_backward=False)
def trace(tables: SceneTables, options: PathOptions, views: Views, wave: Wave, step: int):
    i = wp.tid()
    if i >= wave.counts[2 * step]:
        return
    number = wave.rays[step % 2, i]
    place = place_of(wave, options, views, number)
    wave.hits[number] = next_hit(tables, wave.paths[number], step, place.seed, place.index)


@wp.kernel(enable_backward=False)
def shade(tables: SceneTables, options: PathOptions, views: Views, wave: Wave, step: int):
    i = wp.tid()
    if i >= wave.counts[2 * step]:
        return
    number = wave.rays[step % 2, i]
    hit = wave.hits[number]
    arrival = arrive(tables, options, wave.paths[number], light_aovs_of(wave, number), hit, step)
    path = arrival.path
    light_aovs = arrival.light_aovs
    if path.alive != 0:
        place = place_of(wave, options, views, number)
        left = depart(tables, options, path, light_aovs, hit, step, place.seed, place.index)
        path = left.path
        light_aovs = left.light_aovs
        if step == 0 and wave.features.shape[0] > 0:
            wave.features[number] = left.feature
        light = left.connection.light
        if light[0] + light[1] + light[2] > 0.0:
            wave.connections[number] = left.connection
            wave.shadows[take_place(wave.counts, 2 * step + 1)] = number
        if path.alive != 0:
            wave.rays[(step + 1) % 2, take_place(wave.counts, 2 * step + 2)] = number
    wave.paths[number] = path
    if wave.light_aovs.shape[0] > 0:
        wave.light_aovs[number] = light_aovs


@wp.kernel(enable_backward=False)
def connect(tables: SceneTables, wave: Wave, step: int):
    i = wp.tid()
    if i >= wave.counts[2 * step + 1]:
        return
    number = wave.shadows[i]
    path = wave.paths[number]
    connection = wave.connections[number]
    share = transmitted(tables, path.origin, connection.direction, connection.distance)
    if share > 0.0:
        arrival = connected(path, light_aovs_of(wave, number), connection, share, step)
        wave.paths[number].radiance = arrival.path.radiance
        if wave.light_aovs.shape[0] > 0:
            wave.light_aovs[number] = arrival.light_aovs


@wp.kernel(enable_backward=False)
def gather(options: PathOptions, views: Views, wave: Wave, films: wp.array(dtype=FilmArrays)):
    i = wp.tid()
    pixel = pixel_at(views, wave.first_pixel + i)
    film = films[pixel[0]]
    x = pixel[1]
    y = pixel[2]
    sums = load_pixel(film, options, y, x)
    for k in range(wave.samples):
        number = k * wave.pixels + i
        if wave.paths[number].met >= 0:
            feature = Feature()
            if wave.features.shape[0] > 0:
                feature = wave.features[number]
            sums = with_sample(sums, options, wave.paths[number].radiance, feature, light_aovs_of(wave, number))
    store_pixel(film, options, y, x, sums)
