"""Light linking and shadow parameters: UsdLux's link collections and UsdLuxShadowAPI."""

import warp as wp

from usdsdg_render.bvh.query import unpack, wide_closest
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, MAX_LAYERS, opacity_of_hit
from usdsdg_render.scene.structs import Light, LightLinks, SceneTables

LIT = wp.constant(1)
CASTING = wp.constant(2)


@wp.func
def is_linked(links: LightLinks, instance: int, kind: int):
    """Whether an instance is in the light link (LIT) or the shadow link (CASTING) of a light."""
    if links.masks == wp.uint64(0):
        return True
    masks = wp.array(ptr=links.masks, shape=(instance + 1,), dtype=wp.uint8)
    return (int(masks[instance]) & kind) != 0


@wp.func
def shadow_strength(links: LightLinks, distance: float):
    """Return the opacity of the shadow of an occluder at a distance, 0 to 1."""
    remaining = links.shadow_distance - distance
    if remaining >= links.shadow_falloff:
        return 1.0
    return wp.pow(wp.max(remaining, 0.0) / links.shadow_falloff, links.shadow_gamma)


@wp.func
def has_links(tables: SceneTables, index: int):
    """Whether a chosen light (see `LightChoice`) needs `linked_visibility`."""
    if index < 0 or index >= tables.light_count:
        return False
    return tables.lights[index].links != wp.uint64(0)


@wp.func
def linked_visibility(
    tables: SceneTables, light: Light, instance: int, origin: wp.vec3, direction: wp.vec3, distance: float
):
    """Return the factor on the radiance of a linked light at a point of an instance: links, shadow color, distance."""
    links = wp.array(ptr=light.links, shape=(1,), dtype=LightLinks)[0]
    if not is_linked(links, instance, LIT):
        return wp.vec3(0.0)
    visibility = float(1.0)
    t = float(0.0)
    t_max = wp.min(distance, links.shadow_distance)
    for _layer in range(MAX_LAYERS):
        hit = unpack(wide_closest(tables.tlas, origin, direction, t, t_max))
        if hit.instance < 0:
            break
        if tables.tlas.instances[hit.instance].casts_shadow != 0 and is_linked(links, hit.instance, CASTING):
            opacity = float(1.0)
            if tables.cutouts != 0:
                opacity = opacity_of_hit(tables, hit, BY_CHANCE)
            visibility *= 1.0 - opacity * shadow_strength(links, hit.t)
            # An opaque object casts one shadow, however many of its surfaces the ray hits.
            if opacity >= 1.0:
                break
        t = hit.t
    return wp.vec3(visibility) + links.shadow_color * (1.0 - visibility)
