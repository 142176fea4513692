"""One segment of a path: intersection, emission, next-event estimation and BSDF sampling.

The CPU's path tracer runs all segments of a path in one thread (`cpu_path`), that of CUDA runs one segment of many
paths at a time (`wavefront`).
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, diffuse_fraction, evaluate_bsdf, make_bsdf, sample_bsdf
from usdsdg_render.kernels.bsdf.glass import sample_glass
from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.lights.emissive_instances import emissive_light_pdf, is_emissive_light
from usdsdg_render.kernels.lights.light_sampling import choose_light, hit_light, light_weight, sample_light
from usdsdg_render.kernels.lights.linking import has_links, linked_visibility
from usdsdg_render.kernels.path.path_state import (
    DenoiserFeatures,
    LightAovs,
    Path,
    PathOptions,
    ShadowRay,
    add_light_aov,
    clamp_firefly,
)
from usdsdg_render.kernels.path.sampler import (
    PAIR_FIRST_SEGMENT,
    PAIR_LIGHT,
    PAIR_LOBE,
    PAIR_OPACITY,
    PAIRS_PER_SEGMENT,
    sample_pair,
)
from usdsdg_render.kernels.scene.surface import (
    Surface,
    ensure_valid_reflection,
    mapped_normal,
    surface_at,
    with_material,
)
from usdsdg_render.kernels.scene.texture import (
    cell_pdf,
    cell_radiance,
    environment_background,
    environment_cell,
    environment_radiance,
    environment_uv,
)
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, FAR_AWAY, REFRACTING, closest
from usdsdg_render.scene.structs import LIGHT_DISTANT, Hit, Light, Material, SceneTables

# Surfaces with a sharper lobe than this look up the full-resolution environment map; rougher ones a coarse grid that
# stays in cache.
FINE_ENVIRONMENT_ALPHA = wp.constant(0.04)
# A last surface that is rougher than this uses next-event estimation alone.
LAST_BOUNCE_ALPHA = wp.constant(0.2)
# Sentinel pdf of specular bounces, which next-event estimation cannot find; gives them MIS weight 1.
DELTA_PDF = wp.constant(1.0e15)


@wp.struct
class PathUpdate:
    """A path and its light AOVs after radiance was added."""

    path: Path
    light_aovs: LightAovs


@wp.struct
class Scattering:
    """Result of scattering at a surface: a shadow ray to trace, and the path of the next segment unless it is dead."""

    path: Path
    light_aovs: LightAovs
    shadow_ray: ShadowRay
    features: DenoiserFeatures


@wp.func
def mis_weight(pdf: float, other: float):
    """Power heuristic: MIS weight of a sample with density `pdf` that another technique finds with density `other`."""
    a = pdf * pdf
    return a / (a + other * other)


@wp.func
def fraction(part: float, whole: float):
    """Return the fraction of a whole, exactly 1 where there is nothing else, even by an approximate division."""
    if part == whole and part > 0.0:
        return 1.0
    return part / wp.max(whole, 1.0e-30)


@wp.func
def fractions(part: wp.vec3, whole: wp.vec3):
    """Return `fraction` of each color."""
    return wp.vec3(fraction(part[0], whole[0]), fraction(part[1], whole[1]), fraction(part[2], whole[2]))


@wp.func
def light_probability(light: Light, path: Path):
    """Probability that next-event estimation at the path's last vertex chooses this light."""
    return light_weight(light, path.origin, path.normal, path.environment_weight) / path.light_weight_sum


@wp.func
def next_hit(tables: SceneTables, path: Path, segment: int, seed: wp.uint32, index: wp.uint32):
    """Intersect the path's ray with the scene, with stochastic transparency."""
    number = float(0.0)
    mode = int(BY_CHANCE)
    if tables.cutouts != 0:
        number = sample_pair(seed, index, PAIR_FIRST_SEGMENT + PAIRS_PER_SEGMENT * segment + PAIR_OPACITY)[0]
        if path.can_refract != 0:
            mode = REFRACTING
    return closest(tables, path.origin, path.direction, path.tmin, path.tmax, mode, number)


@wp.func
def add_radiance(update: PathUpdate, radiance: wp.vec3, segment: int):
    """Add radiance that arrives along the path's ray at its last vertex."""
    update.path.radiance += radiance
    if segment > 0:
        update.light_aovs = add_light_aov(
            update.light_aovs, radiance, wp.vec3(1.0) - update.light_aovs.specular_fraction, segment - 1
        )
    return update


@wp.func
def add_emission(tables: SceneTables, options: PathOptions, path: Path, light_aovs: LightAovs, hit: Hit, segment: int):
    """Add the emission of lights that the ray hits, and of the environment if it hits no surface.

    The path ends if it hits no surface, sees a light directly, or is at its last bounce.
    """
    update = PathUpdate(path=path, light_aovs=light_aovs)
    clamp = float(0.0)
    if path.bounces > 1:
        clamp = options.clamp
    t_end = path.tmax
    if hit.instance >= 0:
        t_end = hit.t

    # Lights do not occlude, except that a camera ray ends at the first visible one.
    sees_light = bool(False)
    light_radiance = wp.vec3(0.0)
    for k in range(tables.surface_count):
        light = tables.lights[k]
        if path.pdf >= 0.0 or light.visible != 0:
            light_hit = hit_light(light, path.origin, path.direction)
            is_hit = light_hit.distance >= path.tmin and light_hit.distance < t_end
            if light.kind == LIGHT_DISTANT and hit.instance < 0 and light_hit.distance > 0.0:
                is_hit = True
            if light.links != wp.uint64(0) and path.pdf >= 0.0 and path.pdf < DELTA_PDF and light_hit.distance > 0.0:
                visibility = linked_visibility(
                    tables, light, path.instance, path.origin, path.direction, light_hit.distance
                )
                light_hit.radiance = wp.cw_mul(light_hit.radiance, visibility)
                is_hit = True
            if is_hit:
                if path.pdf < 0.0:
                    t_end = light_hit.distance
                    light_radiance = light_hit.radiance
                    sees_light = True
                else:
                    scale = light.diffuse * (1.0 - path.specular_fraction) + light.specular * path.specular_fraction
                    weight = mis_weight(path.pdf, light_hit.pdf * light_probability(light, path)) * scale
                    contribution = clamp_firefly(wp.cw_mul(path.throughput, light_hit.radiance) * weight, clamp)
                    update = add_radiance(update, contribution, segment)
    if sees_light:
        update.path.radiance = light_radiance
        update.path.alive = 0
        return update
    if hit.instance < 0:
        update.path.alive = 0
        dome = tables.dome
        if dome.height > 0 and (path.pdf >= 0.0 or dome.visible != 0):
            uv = environment_uv(dome, path.direction)
            if path.pdf < 0.0:
                update.path.radiance = environment_background(dome, uv)
            else:
                cell = environment_cell(dome, uv)
                probability = dome.strength * path.environment_weight / path.light_weight_sum
                weight = mis_weight(path.pdf, cell_pdf(dome, cell) * probability)
                weight *= dome.diffuse * (1.0 - path.specular_fraction) + dome.specular * path.specular_fraction
                radiance = wp.vec3(0.0)
                if path.fine_environment != 0:
                    radiance = environment_radiance(dome, uv)
                else:
                    radiance = cell_radiance(dome, cell)
                contribution = clamp_firefly(wp.cw_mul(path.throughput, radiance) * weight, clamp)
                update = add_radiance(update, contribution, segment)
    elif path.bounces == options.bounces and not is_emissive_light(tables, hit.instance):
        update.path.alive = 0
    return update


@wp.func
def scatter_path(
    tables: SceneTables,
    options: PathOptions,
    path: Path,
    light_aovs: LightAovs,
    hit: Hit,
    segment: int,
    seed: wp.uint32,
    index: wp.uint32,
):
    """Add the emission of the hit surface, sample a light for next-event estimation, and sample the next direction."""
    d = Scattering()
    d.path = path
    d.light_aovs = light_aovs
    surface, bsdf = shading_at(tables, path, hit)
    material = tables.materials[surface.material]
    if segment == 0:
        d.features = DenoiserFeatures(albedo=bsdf.albedo, normal=bsdf.normal, depth=hit.t)
    d = add_surface_emission(tables, options, d, hit, surface, material, segment)
    if path.bounces == options.bounces:
        d.path.alive = 0
    if d.path.alive == 0:
        return d

    pair = PAIR_FIRST_SEGMENT + PAIRS_PER_SEGMENT * segment
    d.path.tmin = 0.0
    d.path.tmax = FAR_AWAY
    d.path.instance = hit.instance
    if material.transmission > 0.0 and path.can_refract != 0:
        glass_numbers = sample_pair(seed, index, pair + PAIR_OPACITY)
        if glass_numbers[1] < material.transmission:
            number = sample_pair(seed, index, pair + PAIR_LIGHT)[0]
            r = sample_pair(seed, index, pair + PAIR_LOBE)
            return scatter_at_glass(d, surface, material, bsdf, segment, number, r)

    # At the last bounce a rough surface relies on light sampling alone; a sharp lobe also traces its own ray.
    d.path.bounces += 1
    last = d.path.bounces == options.bounces and wp.min(bsdf.alpha, bsdf.coat_alpha) > LAST_BOUNCE_ALPHA
    d = sample_direct_light(tables, options, d, surface, bsdf, last, sample_pair(seed, index, pair + PAIR_LIGHT))
    if last:
        d.path.alive = 0
        return d
    return sample_next_ray(options, d, bsdf, segment, sample_pair(seed, index, pair + PAIR_LOBE))


@wp.func
def shading_at(tables: SceneTables, path: Path, hit: Hit):
    """Return the surface that the path's ray hits, and its BSDF with the normal of normal maps."""
    surface = surface_at(tables, hit, path.direction)
    material = tables.materials[surface.material]
    surface = with_material(tables, surface, material)
    wo = -path.direction
    surface.normal = ensure_valid_reflection(surface.normal, surface.horizon_normal, wo)
    normal = surface.normal
    if material.normal_texture >= 0 or material.detail_texture >= 0:
        normal = ensure_valid_reflection(mapped_normal(tables, hit, surface, material), surface.horizon_normal, wo)
    diffuse_scale = diffuse_fraction(material, path.can_refract)
    return surface, make_bsdf(tables.albedo_table, surface, material, diffuse_scale, normal, wo, path.min_alpha)


@wp.func
def add_surface_emission(
    tables: SceneTables,
    options: PathOptions,
    d: Scattering,
    hit: Hit,
    surface: Surface,
    material: Material,
    segment: int,
):
    """Add the emission of the hit surface; that of one which is also sampled as a light gets its MIS weight."""
    clamp = float(0.0)
    if d.path.bounces > 1:
        clamp = options.clamp
    sampled = d.path.pdf >= 0.0 and is_emissive_light(tables, hit.instance)
    weight = float(1.0)
    if sampled:
        light = tables.lights[tables.instance_light[hit.instance]]
        light_pdf = emissive_light_pdf(light, material, surface.geometric, d.path.direction, hit.t)
        weight = mis_weight(d.path.pdf, light_pdf * light_probability(light, d.path))
    emitted = clamp_firefly(wp.cw_mul(d.path.throughput, surface.emission) * weight, clamp)
    d.path.radiance += emitted
    if segment > 0:
        diffuse = wp.vec3(1.0) - d.light_aovs.specular_fraction
        d.light_aovs = add_light_aov(d.light_aovs, emitted, diffuse, wp.where(sampled, segment - 1, segment))
    return d


@wp.func
def scatter_at_glass(
    d: Scattering, surface: Surface, material: Material, bsdf: Bsdf, segment: int, number: float, r: wp.vec2
):
    """Reflect or refract the path at glass, without next-event estimation: both are treated as specular bounces."""
    ray = sample_glass(surface, material, bsdf, number, r)
    d.path.throughput = wp.cw_mul(d.path.throughput, ray.weight)
    if ray.weight[0] + ray.weight[1] + ray.weight[2] <= 0.0:
        d.path.alive = 0
    side = float(1.0)
    if ray.transmitted != 0:
        side = -1.0
    d.path.origin = surface.position + surface.geometric * (side * surface.ray_epsilon)
    d.path.direction = ray.direction
    d.path.normal = bsdf.normal
    d.path.pdf = DELTA_PDF
    d.path.light_weight_sum = DELTA_PDF
    d.path.specular_fraction = 1.0
    d.path.fine_environment = 1
    if segment == 0:
        d.light_aovs.refracted = ray.transmitted
        d.light_aovs.specular_fraction = wp.vec3(1.0)
    return d


@wp.func
def sample_direct_light(
    tables: SceneTables,
    options: PathOptions,
    d: Scattering,
    surface: Surface,
    bsdf: Bsdf,
    last: bool,
    numbers: wp.vec2,
):
    """Move the path to the surface and sample a light there: the shadow ray, unless the light does not reach it.

    At the `last` bounce it has the weight of a sample that no other technique finds.
    """
    d.path.origin = surface.position + surface.terminator_offset + surface.geometric * surface.ray_epsilon
    d.path.normal = bsdf.normal
    fine = wp.min(bsdf.alpha, bsdf.coat_alpha) < FINE_ENVIRONMENT_ALPHA
    d.path.fine_environment = wp.where(fine, 1, 0)
    chosen = choose_light(tables, d.path.origin, bsdf.normal, numbers[0], d.path.environment_weight)
    d.path.light_weight_sum = wp.max(chosen.weight_sum, 1.0e-30)
    light_sample = sample_light(tables, chosen.index, d.path.origin, wp.vec2(chosen.remaining, numbers[1]), fine)
    if light_sample.pdf == 0.0:
        return d
    bsdf_value = evaluate_bsdf(bsdf, light_sample.direction)
    diffuse = bsdf_value.diffuse * light_sample.diffuse
    weighted = diffuse + bsdf_value.specular * light_sample.specular
    if weighted[0] + weighted[1] + weighted[2] <= 0.0:
        return d
    pdf = wp.abs(light_sample.pdf) * chosen.probability
    weight = 1.0 / pdf
    if light_sample.pdf > 0.0 and not last:
        weight *= mis_weight(pdf, bsdf_value.pdf)
    d.shadow_ray.direction = light_sample.direction
    d.shadow_ray.distance = light_sample.distance
    if has_links(tables, chosen.index):
        light = tables.lights[chosen.index]
        visibility = linked_visibility(
            tables, light, d.path.instance, d.path.origin, light_sample.direction, light_sample.distance
        )
        light_sample.radiance = wp.cw_mul(light_sample.radiance, visibility)
        d.shadow_ray.distance = 0.0
    scattered = wp.cw_mul(light_sample.radiance, weighted) * weight
    d.shadow_ray.radiance = wp.cw_mul(d.path.throughput, scattered)
    if d.path.bounces > 1:
        d.shadow_ray.clamp = options.clamp
    d.shadow_ray.diffuse_fraction = fractions(diffuse, weighted)
    return d


@wp.func
def sample_next_ray(options: PathOptions, d: Scattering, bsdf: Bsdf, segment: int, numbers: wp.vec2):
    """Sample the BSDF for the ray of the next segment; the path ends in directions that it does not reflect to."""
    wi = sample_bsdf(bsdf, numbers)
    bsdf_value = evaluate_bsdf(bsdf, wi)
    if bsdf_value.pdf <= 0.0:
        d.path.alive = 0
        return d
    total = bsdf_value.diffuse + bsdf_value.specular
    d.path.throughput = wp.cw_mul(d.path.throughput, total) / bsdf_value.pdf
    d.path.specular_fraction = fraction(luminance(bsdf_value.specular), luminance(total))
    roughened = wp.min(1.0, 1.0 - d.path.specular_fraction + bsdf.alpha)
    d.path.min_alpha = wp.max(d.path.min_alpha, options.regularization * roughened)
    d.path.direction = wi
    d.path.pdf = bsdf_value.pdf
    # Glass seen in a mirror refracts as well; after a rough bounce paths pass it straight.
    if d.path.specular_fraction < 0.5 or wp.min(bsdf.alpha, bsdf.coat_alpha) > FINE_ENVIRONMENT_ALPHA:
        d.path.can_refract = 0
    if segment == 0:
        d.light_aovs.specular_fraction = fractions(bsdf_value.specular, total)
    return d


@wp.func
def add_direct_light(path: Path, light_aovs: LightAovs, shadow_ray: ShadowRay, visibility: float, segment: int):
    """Add the radiance of a shadow ray, times its `visibility` from 0 to 1."""
    update = PathUpdate(path=path, light_aovs=light_aovs)
    radiance = clamp_firefly(shadow_ray.radiance * visibility, shadow_ray.clamp)
    update.path.radiance += radiance
    diffuse = shadow_ray.diffuse_fraction
    if segment > 0:
        diffuse = wp.vec3(1.0) - light_aovs.specular_fraction
    update.light_aovs = add_light_aov(update.light_aovs, radiance, diffuse, segment)
    return update
