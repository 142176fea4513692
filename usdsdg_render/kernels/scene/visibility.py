"""Ray queries with opacity: closest hit, and visibility between two points."""

import warp as wp

from usdsdg_render.bvh.query import unpack, wide_closest, wide_closest_in_instance, wide_occluded
from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.scene.texture import channel, lookup
from usdsdg_render.scene.structs import CLEAR_PANE, Hit, Instance, Material, SceneTables, Triangle

FAR_AWAY = wp.constant(1.0e30)
# Maximum number of transparent layers along a ray; the next one counts as opaque.
MAX_LAYERS = wp.constant(64)
# Modes for surfaces that are neither opaque nor cut-outs.
BY_THRESHOLD = wp.constant(0)
BY_CHANCE = wp.constant(1)
# Stochastic too, but glass counts as a hit: it reflects or refracts the path.
REFRACTING = wp.constant(2)
# As BY_THRESHOLD, but labels see through glass.
BEHIND_GLASS = wp.constant(3)


@wp.func
def triangle_of(instance: Instance, index: int):
    records = wp.array(ptr=instance.triangles, shape=(index + 1,), dtype=Triangle)
    return records[index]


@wp.func
def corner_uv(triangle: Triangle, u: float, v: float):
    return triangle.uv0 * (1.0 - u - v) + triangle.uv1 * u + triangle.uv2 * v


@wp.func
def opacity_at(tables: SceneTables, material: Material, uv: wp.vec2):
    if material.opacity_texture < 0:
        return material.opacity
    rgba = lookup(tables, material.opacity_texture, uv)
    return material.opacity * channel(rgba, material.opacity_channel)


@wp.func
def straight_transmittance(material: Material):
    """Return the fraction of light that glass transmits if refraction is ignored, less reflection at its faces."""
    transmittance = material.transmission * (1.0 - material.specular[0])
    if material.thin == CLEAR_PANE:
        return transmittance
    return transmittance * luminance(material.base_color)


@wp.func
def opacity_of_hit(tables: SceneTables, hit: Hit, mode: int):
    """Return the probability that a hit counts: 0 or 1 at cut-outs and in modes BY_THRESHOLD and BEHIND_GLASS."""
    instance = tables.tlas.instances[hit.instance]
    if instance.cutout == 0:
        return 1.0
    triangle = triangle_of(instance, hit.triangle)
    material = tables.materials[tables.slots[instance.slot_offset + triangle.slot]]
    opacity = opacity_at(tables, material, corner_uv(triangle, hit.u, hit.v))
    threshold = material.opacity_threshold
    if mode == BY_CHANCE:
        opacity *= 1.0 - straight_transmittance(material)
    if mode != BY_THRESHOLD and mode != BEHIND_GLASS and threshold <= 0.0:
        return opacity
    if mode == BEHIND_GLASS and material.transmission > 0.5:
        return 0.0
    if threshold <= 0.0:
        # In labels glass counts as a hit unless the mode is BEHIND_GLASS; textured opacity (a leaf) from one half on.
        if material.opacity_texture >= 0 or mode == BEHIND_GLASS:
            threshold = 0.5
        else:
            threshold = 1.0e-6
    if opacity >= threshold:
        return 1.0
    return 0.0


@wp.func
def closest(
    tables: SceneTables, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float, mode: int, number: float
):
    """Return the closest hit with tmin < t < tmax, skipping transparent surfaces.

    A random number in [0, 1) decides layer by layer whether a semi-transparent surface counts.
    """
    hit = Hit()
    t = tmin
    for _layer in range(MAX_LAYERS):
        hit = unpack(wide_closest(tables.tlas, origin, direction, t, tmax))
        if tables.cutouts == 0 or hit.instance < 0:
            break
        opacity = opacity_of_hit(tables, hit, mode)
        if number < opacity:
            break
        # The rescaled number is uniform again.
        number = (number - opacity) / (1.0 - opacity)
        t = hit.t
    return hit


@wp.func
def meets_cutout(
    tables: SceneTables, origin: wp.vec3, direction: wp.vec3, tmin: float, tmax: float, instance: int, mode: int
):
    """Return whether `closest` with a label mode would hit this instance if it were alone in the scene."""
    t = tmin
    for _layer in range(MAX_LAYERS):
        hit = unpack(wide_closest_in_instance(tables.tlas, origin, direction, t, tmax, instance))
        if hit.instance < 0:
            return False
        if opacity_of_hit(tables, hit, mode) > 0.5:
            return True
        t = hit.t
    return True


@wp.func
def transmitted(tables: SceneTables, origin: wp.vec3, direction: wp.vec3, tmax: float):
    """Return the visibility along a shadow ray, 0 to 1, with opacity."""
    if tables.cutouts == 0:
        if wide_occluded(tables.tlas, origin, direction, 0.0, tmax)[3] >= 0:
            return 0.0
        return 1.0
    visibility = float(1.0)
    t = float(0.0)
    for _layer in range(MAX_LAYERS):
        hit = unpack(wide_closest(tables.tlas, origin, direction, t, tmax))
        if hit.instance < 0:
            break
        if tables.tlas.instances[hit.instance].casts_shadow != 0:
            visibility *= 1.0 - opacity_of_hit(tables, hit, BY_CHANCE)
        if visibility <= 0.0:
            break
        t = hit.t
    return visibility
