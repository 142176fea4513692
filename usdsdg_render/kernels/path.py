"""The path tracer: adds samples to a film, one thread a pixel, all samples of a call in a loop."""

import warp as wp

from usdsdg_render.kernels.bsdf import bsdf_at, luminance, sample_direction, scatter
from usdsdg_render.kernels.camera import camera_ray
from usdsdg_render.kernels.light_sampling import choose_light, hit_light, sample_light, weight_at
from usdsdg_render.kernels.sampler import (
    PAIR_FIRST_SEGMENT,
    PAIR_LENS,
    PAIR_LIGHT,
    PAIR_LOBE,
    PAIR_OPACITY,
    PAIR_PIXEL,
    PAIRS_PER_SEGMENT,
    pixel_seed,
    sample_pair,
)
from usdsdg_render.kernels.surface import bumped, facing, surface_at, with_material
from usdsdg_render.kernels.texture import (
    cell_density,
    cell_radiance,
    sky_cell,
    sky_coordinates,
    sky_picture,
    sky_radiance,
)
from usdsdg_render.kernels.types import Camera, SceneTables
from usdsdg_render.kernels.visibility import BY_CHANCE, FAR_AWAY, closest, material_uv, transmitted

# Surfaces with a sharper lobe than this see the sky's picture; rougher ones a coarse one that stays in cache.
FINE_SKY_ALPHA = wp.constant(0.04)
LAST_ALPHA = wp.constant(0.2)


@wp.struct
class PathOptions:
    """`settings.PathSettings` as kernels read it."""

    bounces: wp.int32  # surfaces a path may meet
    samples: wp.int32
    first_sample: wp.int32
    seed: wp.uint32
    frame: wp.uint32
    clamp: wp.float32  # most that one indirect contribution may add [nits]; 0 = no limit
    regularization: wp.float32  # least GGX alpha after a rough bounce
    features: wp.int32  # 1 = also sum what the denoiser needs


@wp.struct
class FilmArrays:
    """Running sums per pixel, (height, width); the features are empty unless asked for."""

    color: wp.array2d(dtype=wp.vec4)  # radiance [nits] and number of samples
    albedo: wp.array2d(dtype=wp.vec3)
    normal_depth: wp.array2d(dtype=wp.vec4)  # world normal, distance of the first hit [stage units], 0 on no hit
    square: wp.array2d(dtype=wp.float32)  # squared luminance of radiance over albedo
    dropped: wp.array2d(dtype=wp.int32)  # samples that were not finite


@wp.struct
class PathSample:
    radiance: wp.vec3
    # Of the first hit
    albedo: wp.vec3
    normal: wp.vec3
    depth: wp.float32


@wp.func
def limited(color: wp.vec3, most: float):
    """Scale a contribution down to luminance `most`."""
    y = luminance(color)
    if most > 0.0 and y > most:
        return color * (most / y)
    return color


@wp.func
def mis(pdf: float, other: float):
    """Power heuristic: weight of a sample with density `pdf` that another way finds with density `other`."""
    a = pdf * pdf
    return a / (a + other * other)


@wp.func
def trace_path(
    tables: SceneTables,
    options: PathOptions,
    camera: Camera,
    column: float,
    row: float,
    index: wp.uint32,
    seed: wp.uint32,
):
    """Radiance arriving through one point of the picture."""
    result = PathSample()
    result.albedo = wp.vec3(1.0)
    lens = wp.vec2(0.0)
    if camera.lens_radius > 0.0:
        lens = sample_pair(seed, index, PAIR_LENS)
    ray = camera_ray(camera, column, row, lens)
    origin = ray.origin
    direction = ray.direction
    tmin = ray.tmin
    tmax = ray.tmax
    throughput = wp.vec3(1.0)
    # Of the direction in which the path goes on: its density, -1 for the camera's, and the glossy share of its weight;
    # and of the point that it leaves: normal and sum of the weights of all lights.
    pdf = float(-1.0)
    glossy = float(0.0)
    normal = wp.vec3(0.0)
    all_lights = float(0.0)
    fine_sky = bool(False)
    least_alpha = float(0.0)

    # The last surface may need a segment more, on which only lights count.
    for bounce in range(options.bounces + 1):
        pair = PAIR_FIRST_SEGMENT + PAIRS_PER_SEGMENT * bounce
        opacity_number = float(0.0)
        if tables.cutouts != 0:
            opacity_number = sample_pair(seed, index, pair + PAIR_OPACITY)[0]
        hit = closest(tables, origin, direction, tmin, tmax, BY_CHANCE, opacity_number)
        most = float(0.0)
        if bounce > 1:
            most = options.clamp
        reach = tmax
        if hit.instance >= 0:
            reach = hit.t

        # Lights in the way: the camera stops at the first, other rays look through them.
        stopped = bool(False)
        for k in range(tables.surface_count):
            light = tables.lights[k]
            if pdf >= 0.0 or light.visible != 0:
                on_light = hit_light(light, origin, direction)
                inside = on_light.distance >= tmin and on_light.distance < reach
                if light.kind == 1 and hit.instance < 0 and on_light.distance > 0.0:
                    inside = True
                if inside:
                    if pdf < 0.0:
                        reach = on_light.distance
                        result.radiance = on_light.radiance
                        stopped = True
                    else:
                        dim = light.diffuse * (1.0 - glossy) + light.specular * glossy
                        chance = weight_at(light, origin, normal) / all_lights
                        weight = mis(pdf, on_light.pdf * chance) * dim
                        result.radiance += limited(wp.cw_mul(throughput, on_light.radiance) * weight, most)
        if stopped:
            break
        if hit.instance < 0:
            dome = tables.dome
            if dome.height > 0 and (pdf >= 0.0 or dome.visible != 0):
                uv = sky_coordinates(dome, direction)
                if pdf < 0.0:
                    result.radiance = sky_picture(dome, uv)
                else:
                    cell = sky_cell(dome, uv)
                    weight = mis(pdf, cell_density(dome, cell) * (dome.strength / all_lights))
                    sky = wp.vec3(0.0)
                    if fine_sky:
                        sky = sky_radiance(dome, uv)
                    else:
                        sky = cell_radiance(dome, cell)
                    result.radiance += limited(wp.cw_mul(throughput, sky) * weight, most)
            break

        if bounce == options.bounces:
            break

        # The surface.
        surface = surface_at(tables, hit, direction)
        material = tables.materials[surface.material]
        uv = material_uv(material, surface.uv)
        surface = with_material(tables, surface, material, uv)
        wo = -direction
        shading = surface.normal
        if material.normal_texture >= 0:
            shading = bumped(tables, hit, surface, material, uv)
        bent = facing(shading, surface.horizon, wo)
        bsdf = bsdf_at(tables.albedo_table, surface, material, bent, wo, least_alpha)
        result.radiance += limited(wp.cw_mul(throughput, surface.emission), most)
        if bounce == 0:
            result.albedo = bsdf.albedo
            result.normal = bsdf.normal
            result.depth = hit.t

        # A rough last surface finds its light by sampling lights alone; a sharp lobe has to look for them as well.
        sharpest = wp.min(bsdf.alpha, bsdf.coat_alpha)
        last = bounce + 1 == options.bounces and sharpest > LAST_ALPHA

        # Light that arrives straight from a light.
        numbers = sample_pair(seed, index, pair + PAIR_LIGHT)
        origin = surface.position + surface.lift + surface.geometric * surface.gap
        normal = bsdf.normal
        fine_sky = sharpest < FINE_SKY_ALPHA
        chosen = choose_light(tables, origin, normal, numbers[0])
        all_lights = wp.max(chosen.total, 1.0e-30)
        to_light = sample_light(tables, chosen.index, origin, wp.vec2(chosen.number, numbers[1]), fine_sky)
        if to_light.pdf != 0.0:
            out = scatter(bsdf, to_light.direction)
            weighted = out.diffuse * to_light.diffuse + out.specular * to_light.specular
            if weighted[0] + weighted[1] + weighted[2] > 0.0:
                share = transmitted(tables, origin, to_light.direction, to_light.distance)
                if share > 0.0:
                    density = wp.abs(to_light.pdf) * chosen.chance
                    weight = share / density
                    if to_light.pdf > 0.0 and not last:
                        weight *= mis(density, out.pdf)
                    most = 0.0
                    if bounce > 0:
                        most = options.clamp
                    arriving = wp.cw_mul(to_light.radiance, weighted) * weight
                    result.radiance += limited(wp.cw_mul(throughput, arriving), most)
        if last:
            break

        # On to the next surface.
        towards = sample_direction(bsdf, sample_pair(seed, index, pair + PAIR_LOBE))
        out = scatter(bsdf, towards)
        if out.pdf <= 0.0:
            break
        total = out.diffuse + out.specular
        throughput = wp.cw_mul(throughput, total) / out.pdf
        glossy = luminance(out.specular) / wp.max(luminance(total), 1.0e-20)
        least_alpha = wp.max(least_alpha, options.regularization * wp.min(1.0, 1.0 - glossy + bsdf.alpha))
        direction = towards
        pdf = out.pdf
        tmin = 0.0
        tmax = FAR_AWAY
    return result


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
    color = film.color[y, x]
    albedo = wp.vec3(0.0)
    normal_depth = wp.vec4(0.0)
    square = float(0.0)
    dropped = int(0)
    if options.features != 0:
        albedo = film.albedo[y, x]
        normal_depth = film.normal_depth[y, x]
        square = film.square[y, x]
    for k in range(options.samples):
        index = wp.uint32(options.first_sample + k)
        jitter = sample_pair(seed, index, PAIR_PIXEL)
        s = trace_path(tables, options, camera, float(x) + jitter[0], float(y) + jitter[1], index, seed)
        if wp.isfinite(s.radiance[0]) and wp.isfinite(s.radiance[1]) and wp.isfinite(s.radiance[2]):
            color += wp.vec4(s.radiance[0], s.radiance[1], s.radiance[2], 1.0)
            if options.features != 0:
                albedo += s.albedo
                normal_depth += wp.vec4(s.normal[0], s.normal[1], s.normal[2], s.depth)
                light = luminance(wp.cw_div(s.radiance, wp.max(s.albedo, wp.vec3(0.01))))
                square += light * light
        else:
            dropped += 1
    film.color[y, x] = color
    if options.features != 0:
        film.albedo[y, x] = albedo
        film.normal_depth[y, x] = normal_depth
        film.square[y, x] = square
    if dropped > 0:
        film.dropped[y, x] = film.dropped[y, x] + dropped
