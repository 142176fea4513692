"""One step of a path: what its ray meets, and how it goes on from there.

The same steps make up the CPU's path tracer, which runs a path to its end in one thread (`path`), and that of CUDA,
which runs each step for many paths at a time (`wavefront`).
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, bsdf_at, opaque_share, sample_direction, scatter
from usdsdg_render.kernels.bsdf.glass import through_glass
from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.lights.emissive_instances import emitter_density, is_emitter
from usdsdg_render.kernels.lights.light_sampling import choose_light, hit_light, sample_light, weight_at
from usdsdg_render.kernels.lights.linking import by_rules, has_rules
from usdsdg_render.kernels.path.path_state import (
    Connection,
    Feature,
    LightAovs,
    Path,
    PathOptions,
    add_light_aov,
    limited,
)
from usdsdg_render.kernels.path.sampler import (
    PAIR_FIRST_SEGMENT,
    PAIR_LIGHT,
    PAIR_LOBE,
    PAIR_OPACITY,
    PAIRS_PER_SEGMENT,
    sample_pair,
)
from usdsdg_render.kernels.scene.surface import Surface, bumped, facing, surface_at, with_material
from usdsdg_render.kernels.scene.texture import (
    cell_density,
    cell_radiance,
    sky_cell,
    sky_coordinates,
    sky_picture,
    sky_radiance,
)
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, FAR_AWAY, REFRACTING, closest
from usdsdg_render.scene.structs import LIGHT_DISTANT, Hit, Material, SceneTables

# Surfaces with a sharper lobe than this see the sky's picture; rougher ones a coarse one that stays in cache.
FINE_SKY_ALPHA = wp.constant(0.04)
LAST_ALPHA = wp.constant(0.2)
# Density of a direction that sampling lights cannot find.
CERTAIN = wp.constant(1.0e15)


@wp.struct
class Arrival:
    path: Path
    light_aovs: LightAovs


@wp.struct
class Departure:
    """How a path leaves a surface: a `connection` to try, and the path towards the next one unless it is dead."""

    path: Path
    light_aovs: LightAovs
    connection: Connection
    feature: Feature


@wp.func
def mis(pdf: float, other: float):
    """Power heuristic: weight of a sample with density `pdf` that another way finds with density `other`."""
    a = pdf * pdf
    return a / (a + other * other)


@wp.func
def next_hit(tables: SceneTables, path: Path, bounce: int, seed: wp.uint32, index: wp.uint32):
    """The surface that the path meets next."""
    number = float(0.0)
    mode = int(BY_CHANCE)
    if tables.cutouts != 0:
        number = sample_pair(seed, index, PAIR_FIRST_SEGMENT + PAIRS_PER_SEGMENT * bounce + PAIR_OPACITY)[0]
        if path.refracting != 0:
            mode = REFRACTING
    return closest(tables, path.origin, path.direction, path.tmin, path.tmax, mode, number)


@wp.func
def with_light(arrival: Arrival, light: wp.vec3, bounce: int):
    """Count light that the path's ray brings to the surface that it left."""
    arrival.path.radiance += light
    if bounce > 0:
        arrival.light_aovs = add_light_aov(
            arrival.light_aovs, light, wp.vec3(1.0) - arrival.light_aovs.mirrored, bounce - 1
        )
    return arrival


@wp.func
def arrive(tables: SceneTables, options: PathOptions, path: Path, light_aovs: LightAovs, hit: Hit, bounce: int):
    """Light on the way to the hit: of lights that the ray meets, and of the sky where it meets nothing; path dead."""
    a = Arrival(path=path, light_aovs=light_aovs)
    most = float(0.0)
    if path.met > 1:
        most = options.clamp
    reach = path.tmax
    if hit.instance >= 0:
        reach = hit.t

    # Lights in the way: the camera stops at the first, other rays look through them.
    stopped = bool(False)
    seen = wp.vec3(0.0)
    for k in range(tables.surface_count):
        light = tables.lights[k]
        if path.pdf >= 0.0 or light.visible != 0:
            on_light = hit_light(light, path.origin, path.direction)
            inside = on_light.distance >= path.tmin and on_light.distance < reach
            if light.kind == LIGHT_DISTANT and hit.instance < 0 and on_light.distance > 0.0:
                inside = True
            if light.rules != wp.uint64(0) and path.pdf >= 0.0 and path.pdf < CERTAIN and on_light.distance > 0.0:
                through = by_rules(tables, light, path.instance, path.origin, path.direction, on_light.distance)
                on_light.radiance = wp.cw_mul(on_light.radiance, through)
                inside = True
            if inside:
                if path.pdf < 0.0:
                    reach = on_light.distance
                    seen = on_light.radiance
                    stopped = True
                else:
                    dim = light.diffuse * (1.0 - path.glossy) + light.specular * path.glossy
                    chance = weight_at(light, path.origin, path.normal, path.sky_share) / path.all_lights
                    weight = mis(path.pdf, on_light.pdf * chance) * dim
                    found = limited(wp.cw_mul(path.throughput, on_light.radiance) * weight, most)
                    a = with_light(a, found, bounce)
    if stopped:
        a.path.radiance = seen
        a.path.alive = 0
        return a
    if hit.instance < 0:
        a.path.alive = 0
        dome = tables.dome
        if dome.height > 0 and (path.pdf >= 0.0 or dome.visible != 0):
            uv = sky_coordinates(dome, path.direction)
            if path.pdf < 0.0:
                a.path.radiance = sky_picture(dome, uv)
            else:
                cell = sky_cell(dome, uv)
                weight = mis(path.pdf, cell_density(dome, cell) * (dome.strength * path.sky_share / path.all_lights))
                weight *= dome.diffuse * (1.0 - path.glossy) + dome.specular * path.glossy
                sky = wp.vec3(0.0)
                if path.fine_sky != 0:
                    sky = sky_radiance(dome, uv)
                else:
                    sky = cell_radiance(dome, cell)
                a = with_light(a, limited(wp.cw_mul(path.throughput, sky) * weight, most), bounce)
    elif path.met == options.bounces and not is_emitter(tables, hit.instance):
        a.path.alive = 0
    return a


@wp.func
def into_glass(d: Departure, surface: Surface, material: Material, bsdf: Bsdf, bounce: int, number: float, r: wp.vec2):
    """Mirror or bend the path. No light is sampled: only the path's own ray finds what glass shows."""
    ray = through_glass(surface, material, bsdf, number, r)
    d.path.throughput = wp.cw_mul(d.path.throughput, ray.weight)
    if ray.weight[0] + ray.weight[1] + ray.weight[2] <= 0.0:
        d.path.alive = 0
    side = float(1.0)
    if ray.crossed != 0:
        side = -1.0
    d.path.origin = surface.position + surface.geometric * (side * surface.gap)
    d.path.direction = ray.direction
    d.path.normal = bsdf.normal
    d.path.pdf = CERTAIN
    d.path.all_lights = CERTAIN
    d.path.glossy = 1.0
    d.path.fine_sky = 1
    if bounce == 0:
        d.light_aovs.bent = ray.crossed
        d.light_aovs.mirrored = wp.vec3(1.0)
    return d


@wp.func
def depart(
    tables: SceneTables,
    options: PathOptions,
    path: Path,
    light_aovs: LightAovs,
    hit: Hit,
    bounce: int,
    seed: wp.uint32,
    index: wp.uint32,
):
    """Scatter the path at a hit."""
    d = Departure()
    d.path = path
    d.light_aovs = light_aovs
    surface = surface_at(tables, hit, path.direction)
    material = tables.materials[surface.material]
    surface = with_material(tables, surface, material)
    wo = -path.direction
    surface.normal = facing(surface.normal, surface.horizon, wo)
    normal = surface.normal
    if material.normal_texture >= 0 or material.detail_texture >= 0:
        normal = facing(bumped(tables, hit, surface, material), surface.horizon, wo)
    opaque = opaque_share(material, path.refracting)
    bsdf = bsdf_at(tables.albedo_table, surface, material, opaque, normal, wo, path.least_alpha)
    most = float(0.0)
    if path.met > 1:
        most = options.clamp
    # Light of a surface that is also drawn from as a light counts by what following the path is worth.
    sampled = path.pdf >= 0.0 and is_emitter(tables, hit.instance)
    share = float(1.0)
    if sampled:
        light = tables.lights[tables.instance_light[hit.instance]]
        chance = weight_at(light, path.origin, path.normal, path.sky_share) / path.all_lights
        share = mis(path.pdf, emitter_density(light, material, surface.geometric, path.direction, hit.t) * chance)
    emitted = limited(wp.cw_mul(path.throughput, surface.emission) * share, most)
    d.path.radiance += emitted
    if path.met == options.bounces:
        d.path.alive = 0
    if bounce == 0:
        d.feature = Feature(albedo=bsdf.albedo, normal=bsdf.normal, depth=hit.t)
    else:
        d.light_aovs = add_light_aov(
            d.light_aovs, emitted, wp.vec3(1.0) - d.light_aovs.mirrored, wp.where(sampled, bounce - 1, bounce)
        )
    if d.path.alive == 0:
        return d
    pair = PAIR_FIRST_SEGMENT + PAIRS_PER_SEGMENT * bounce
    d.path.tmin = 0.0
    d.path.tmax = FAR_AWAY
    d.path.instance = hit.instance
    if material.transmission > 0.0 and path.refracting != 0:
        chances = sample_pair(seed, index, pair + PAIR_OPACITY)
        if chances[1] < material.transmission:
            number = sample_pair(seed, index, pair + PAIR_LIGHT)[0]
            return into_glass(d, surface, material, bsdf, bounce, number, sample_pair(seed, index, pair + PAIR_LOBE))

    # A rough last surface finds its light by sampling lights alone; a sharp lobe has to look for them as well.
    sharpest = wp.min(bsdf.alpha, bsdf.coat_alpha)
    d.path.met += 1
    last = d.path.met == options.bounces and sharpest > LAST_ALPHA

    # Light that arrives straight from a light.
    numbers = sample_pair(seed, index, pair + PAIR_LIGHT)
    d.path.origin = surface.position + surface.lift + surface.geometric * surface.gap
    d.path.normal = bsdf.normal
    d.path.fine_sky = wp.where(sharpest < FINE_SKY_ALPHA, 1, 0)
    chosen = choose_light(tables, d.path.origin, bsdf.normal, numbers[0], path.sky_share)
    d.path.all_lights = wp.max(chosen.total, 1.0e-30)
    at = wp.vec2(chosen.number, numbers[1])
    to_light = sample_light(tables, chosen.index, d.path.origin, at, sharpest < FINE_SKY_ALPHA)
    if to_light.pdf != 0.0:
        out = scatter(bsdf, to_light.direction)
        diffuse = out.diffuse * to_light.diffuse
        weighted = diffuse + out.specular * to_light.specular
        if weighted[0] + weighted[1] + weighted[2] > 0.0:
            density = wp.abs(to_light.pdf) * chosen.chance
            weight = 1.0 / density
            if to_light.pdf > 0.0 and not last:
                weight *= mis(density, out.pdf)
            d.connection.direction = to_light.direction
            d.connection.distance = to_light.distance
            if has_rules(tables, chosen.index):
                light = tables.lights[chosen.index]
                through = by_rules(tables, light, hit.instance, d.path.origin, to_light.direction, to_light.distance)
                to_light.radiance = wp.cw_mul(to_light.radiance, through)
                d.connection.distance = 0.0
            arriving = wp.cw_mul(to_light.radiance, weighted) * weight
            d.connection.light = wp.cw_mul(path.throughput, arriving)
            if path.met > 0:
                d.connection.most = options.clamp
            d.connection.diffuse = wp.cw_div(diffuse, wp.max(weighted, wp.vec3(1.0e-30)))
    if last:
        d.path.alive = 0
        return d

    # On to the next surface.
    towards = sample_direction(bsdf, sample_pair(seed, index, pair + PAIR_LOBE))
    out = scatter(bsdf, towards)
    if out.pdf <= 0.0:
        d.path.alive = 0
        return d
    total = out.diffuse + out.specular
    d.path.throughput = wp.cw_mul(path.throughput, total) / out.pdf
    d.path.glossy = luminance(out.specular) / wp.max(luminance(total), 1.0e-20)
    d.path.least_alpha = wp.max(
        path.least_alpha, options.regularization * wp.min(1.0, 1.0 - d.path.glossy + bsdf.alpha)
    )
    d.path.direction = towards
    d.path.pdf = out.pdf
    # What a mirror shows of glass is bent as well; from rough surfaces light goes straight through it.
    if d.path.glossy < 0.5 or sharpest > FINE_SKY_ALPHA:
        d.path.refracting = 0
    if bounce == 0:
        d.light_aovs.mirrored = wp.cw_div(out.specular, wp.max(total, wp.vec3(1.0e-30)))
    return d


@wp.func
def connected(path: Path, light_aovs: LightAovs, connection: Connection, share: float, bounce: int):
    """Add the light of a connection of which `share` came through."""
    a = Arrival(path=path, light_aovs=light_aovs)
    light = limited(connection.light * share, connection.most)
    a.path.radiance += light
    diffuse = connection.diffuse
    if bounce > 0:
        diffuse = wp.vec3(1.0) - light_aovs.mirrored
    a.light_aovs = add_light_aov(a.light_aovs, light, diffuse, bounce)
    return a
