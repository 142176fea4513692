"""Lights that do not reach everything, or whose shadows are not black: UsdLux's light linking and ShadowAPI."""

import warp as wp

from usdsdg_render.bvh.query import unpack, wide_closest
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, MAX_LAYERS, opacity_of_hit
from usdsdg_render.scene.structs import Light, LightRules, SceneTables

LIT = wp.constant(1)
CASTING = wp.constant(2)


@wp.func
def is_linked(rules: LightRules, instance: int, kind: int):
    if rules.links == wp.uint64(0):
        return True
    links = wp.array(ptr=rules.links, shape=(instance + 1,), dtype=wp.uint8)
    return (int(links[instance]) & kind) != 0


@wp.func
def shadow_strength(rules: LightRules, distance: float):
    """How dark the shadow of an occluder at a distance is, 0 to 1."""
    left = rules.shadow_distance - distance
    if left >= rules.shadow_falloff:
        return 1.0
    return wp.pow(wp.max(left, 0.0) / rules.shadow_falloff, rules.shadow_gamma)


@wp.func
def has_rules(tables: SceneTables, index: int):
    """Whether a chosen light (see `LightChoice`) wants `by_rules`."""
    if index < 0 or index >= tables.light_count:
        return False
    return tables.lights[index].rules != wp.uint64(0)


@wp.func
def by_rules(tables: SceneTables, light: Light, instance: int, origin: wp.vec3, direction: wp.vec3, distance: float):
    """What a light with rules sends through to a point of an instance, as a factor to its radiance."""
    rules = wp.array(ptr=light.rules, shape=(1,), dtype=LightRules)[0]
    if not is_linked(rules, instance, LIT):
        return wp.vec3(0.0)
    share = float(1.0)
    t = float(0.0)
    reach = wp.min(distance, rules.shadow_distance)
    for _layer in range(MAX_LAYERS):
        hit = unpack(wide_closest(tables.tree, origin, direction, t, reach))
        if hit.instance < 0:
            break
        if tables.tree.instances[hit.instance].casts_shadow != 0 and is_linked(rules, hit.instance, CASTING):
            opacity = float(1.0)
            if tables.cutouts != 0:
                opacity = opacity_of_hit(tables, hit, BY_CHANCE)
            share *= 1.0 - opacity * shadow_strength(rules, hit.t)
            # One solid thing casts one shadow, however many of its surfaces are in the way.
            if opacity >= 1.0:
                break
        t = hit.t
    return wp.vec3(share) + rules.shadow_color * (1.0 - share)
