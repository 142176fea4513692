"""Light that a path's ray finds: of lights in its way, of the environment, and of the surface that it hits."""

import warp as wp

from usdsdg_render.kernels.lights.emissive_instances import emissive_light_pdf, is_emissive_light
from usdsdg_render.kernels.lights.light_sampling import hit_light
from usdsdg_render.kernels.lights.linking import linked_visibility
from usdsdg_render.kernels.path.mis_weights import DELTA_PDF, light_probability, mis_weight
from usdsdg_render.kernels.path.path_state import (
    LightAovs,
    Path,
    PathOptions,
    PathUpdate,
    Scattering,
    add_light_aov,
    add_radiance,
    clamp_firefly,
    firefly_clamp,
)
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.kernels.scene.texture import (
    cell_pdf,
    cell_radiance,
    environment_background,
    environment_cell,
    environment_radiance,
    environment_uv,
)
from usdsdg_render.scene.structs import LIGHT_DISTANT, Dome, Hit, Light, Material, SceneTables


@wp.func
def add_emission(tables: SceneTables, options: PathOptions, path: Path, light_aovs: LightAovs, hit: Hit, segment: int):
    """Add the emission of lights that the ray hits, and of the environment if it hits no surface.

    The path ends if it hits no surface, sees a light directly, or is at its last bounce.
    """
    update = PathUpdate(path=path, light_aovs=light_aovs)
    clamp = firefly_clamp(path, options)
    t_end = path.tmax
    if hit.instance >= 0:
        t_end = hit.t

    # Lights do not occlude, except that a camera ray ends at the first visible one.
    sees_light = bool(False)
    light_radiance = wp.vec3(0.0)
    for k in range(tables.surface_count):
        light = tables.lights[k]
        if path.pdf >= 0.0 or light.visible != 0:
            light_hit = light_in_the_way(tables, light, path, hit, t_end)
            if light_hit.distance >= 0.0:
                if path.pdf < 0.0:
                    t_end = light_hit.distance
                    light_radiance = light_hit.radiance
                    sees_light = True
                else:
                    weight = mis_weight(path.pdf, light_hit.pdf * light_probability(light, path))
                    weight *= multiplier_of_lobes(light.diffuse, light.specular, path)
                    contribution = clamp_firefly(wp.cw_mul(path.throughput, light_hit.radiance) * weight, clamp)
                    update = add_radiance(update, contribution, segment)
    if sees_light:
        update.path.radiance = light_radiance
        update.path.alive = 0
        return update
    if hit.instance < 0:
        update.path.alive = 0
        if tables.dome.height > 0 and (path.pdf >= 0.0 or tables.dome.visible != 0):
            update = add_environment(tables.dome, update, clamp, segment)
    elif path.bounces == options.bounces and not is_emissive_light(tables, hit.instance):
        update.path.alive = 0
    return update


@wp.func
def light_in_the_way(tables: SceneTables, light: Light, path: Path, hit: Hit, t_end: float):
    """Return where the path's ray hits a light before `t_end`, with distance < 0 where it does not.

    A distant light lies behind all surfaces. The surfaces between a bounced ray and a light with links dim the light,
    since some of them may cast no shadow of it.
    """
    light_hit = hit_light(light, path.origin, path.direction)
    is_hit = light_hit.distance >= path.tmin and light_hit.distance < t_end
    if light.kind == LIGHT_DISTANT and hit.instance < 0 and light_hit.distance > 0.0:
        is_hit = True
    if light.links != wp.uint64(0) and path.pdf >= 0.0 and path.pdf < DELTA_PDF and light_hit.distance > 0.0:
        visibility = linked_visibility(tables, light, path.instance, path.origin, path.direction, light_hit.distance)
        light_hit.radiance = wp.cw_mul(light_hit.radiance, visibility)
        is_hit = True
    if not is_hit:
        light_hit.distance = -1.0
    return light_hit


@wp.func
def add_environment(dome: Dome, update: PathUpdate, clamp: float, segment: int):
    """Add the environment's light in the direction of the path's ray; a camera ray sees it as the background."""
    path = update.path
    uv = environment_uv(dome, path.direction)
    if path.pdf < 0.0:
        update.path.radiance = environment_background(dome, uv)
        return update
    cell = environment_cell(dome, uv)
    probability = dome.strength * path.environment_weight / path.light_weight_sum
    weight = mis_weight(path.pdf, cell_pdf(dome, cell) * probability)
    weight *= multiplier_of_lobes(dome.diffuse, dome.specular, path)
    radiance = wp.vec3(0.0)
    if path.fine_environment != 0:
        radiance = environment_radiance(dome, uv)
    else:
        radiance = cell_radiance(dome, cell)
    contribution = clamp_firefly(wp.cw_mul(path.throughput, radiance) * weight, clamp)
    return add_radiance(update, contribution, segment)


@wp.func
def multiplier_of_lobes(diffuse: float, specular: float, path: Path):
    """Return a light's multipliers of diffuse and specular reflection, as the last surface of the path reflected."""
    return diffuse * (1.0 - path.specular_fraction) + specular * path.specular_fraction


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
    sampled = d.path.pdf >= 0.0 and is_emissive_light(tables, hit.instance)
    weight = float(1.0)
    if sampled:
        light = tables.lights[tables.instance_light[hit.instance]]
        light_pdf = emissive_light_pdf(light, material, surface.geometric, d.path.direction, hit.t)
        weight = mis_weight(d.path.pdf, light_pdf * light_probability(light, d.path))
    emitted = clamp_firefly(wp.cw_mul(d.path.throughput, surface.emission) * weight, firefly_clamp(d.path, options))
    d.path.radiance += emitted
    if segment > 0:
        diffuse = wp.vec3(1.0) - d.light_aovs.specular_fraction
        d.light_aovs = add_light_aov(d.light_aovs, emitted, diffuse, wp.where(sampled, segment - 1, segment))
    return d
