"""One segment of a path: intersection, and scattering at the surface: next-event estimation and BSDF sampling.

The CPU's path tracer runs all segments of a path in one thread (`cpu_path`), that of CUDA runs one segment of many
paths at a time (`wavefront`).
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, diffuse_fraction, evaluate_bsdf, make_bsdf, sample_bsdf
from usdsdg_render.kernels.bsdf.glass import sample_glass
from usdsdg_render.kernels.color import fraction, fractions, luminance
from usdsdg_render.kernels.path.direct_light import FINE_ENVIRONMENT_ALPHA, sample_direct_light
from usdsdg_render.kernels.path.emission import add_surface_emission
from usdsdg_render.kernels.path.mis_weights import DELTA_PDF
from usdsdg_render.kernels.path.path_state import DenoiserFeatures, LightAovs, Path, PathOptions, Scattering
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
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, FAR_AWAY, REFRACTING, closest
from usdsdg_render.scene.structs import Hit, Material, SceneTables

# A last surface that is rougher than this uses next-event estimation alone.
LAST_BOUNCE_ALPHA = wp.constant(0.2)


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
    d = add_surface_emission(tables, options, d, hit, surface, material, segment)
    if segment == 0:
        emission = d.path.radiance - path.radiance
        d.features = DenoiserFeatures(albedo=bsdf.albedo, normal=bsdf.normal, depth=hit.t, emission=emission)
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
