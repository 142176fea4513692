"""Next-event estimation: light that is sampled at a surface of a path, and arrives if nothing is in its way."""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, evaluate_bsdf
from usdsdg_render.kernels.color import fractions
from usdsdg_render.kernels.lights.light_sampling import choose_light, sample_light
from usdsdg_render.kernels.lights.linking import has_links, linked_visibility
from usdsdg_render.kernels.path.mis_weights import mis_weight
from usdsdg_render.kernels.path.path_state import (
    LightAovs,
    Path,
    PathOptions,
    PathUpdate,
    Scattering,
    ShadowRay,
    add_light_aov,
    clamp_firefly,
    firefly_clamp,
)
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.scene.structs import SceneTables

# Surfaces with a sharper lobe than this look up the full-resolution environment map; rougher ones a coarse grid that
# stays in cache.
FINE_ENVIRONMENT_ALPHA = wp.constant(0.04)


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
    d.shadow_ray.clamp = firefly_clamp(d.path, options)
    d.shadow_ray.diffuse_fraction = fractions(diffuse, weighted)
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
