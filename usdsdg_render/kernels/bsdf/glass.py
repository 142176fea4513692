"""Glass: light is mirrored or bent where it enters and leaves, and tinted on the way in.

Facets are chosen as for every glossy lobe (see `bsdf`); Fresnel's equations decide between mirroring and bending.
Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007).
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, perpendicular, sample_facet, smith_root
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.scene.structs import CLEAR_PANE, Material


@wp.struct
class GlassRay:
    """How a path goes on from glass; weight 0 = it ends."""

    direction: wp.vec3
    weight: wp.vec3
    crossed: wp.int32  # 1 = bent, 0 = mirrored


@wp.func
def dielectric(cos_i: float, ratio: float):
    """Share that is mirrored, unpolarized; `ratio` is the index of refraction beyond over that on this side."""
    sin2_t = (1.0 - cos_i * cos_i) / (ratio * ratio)
    if sin2_t >= 1.0:
        return 1.0
    cos_t = wp.sqrt(1.0 - sin2_t)
    parallel = (ratio * cos_i - cos_t) / (ratio * cos_i + cos_t)
    across = (cos_i - ratio * cos_t) / (cos_i + ratio * cos_t)
    return 0.5 * (parallel * parallel + across * across)


@wp.func
def through_glass(surface: Surface, material: Material, b: Bsdf, number: float, r: wp.vec2):
    """Mirror or bend the path at a facet; `number` in [0, 1) decides which."""
    ray = GlassRay()
    across = perpendicular(b.normal)
    mirrored = sample_facet(b, b.alpha, across, wp.cross(b.normal, across), r)
    facet = wp.normalize(mirrored + b.wo)
    cos_o = wp.clamp(wp.dot(b.wo, facet), 0.0, 1.0)
    ratio = wp.max(material.ior, 1.0e-3)
    if surface.flipped != 0 and material.thin == 0:
        ratio = 1.0 / ratio
    share = dielectric(cos_o, ratio)
    if material.thin != 0:
        # Between the two faces of a pane light is mirrored to and fro.
        share = 2.0 * share / (1.0 + share)
    side = float(1.0)
    if number >= share and material.thin == CLEAR_PANE:
        ray.crossed = 1
        ray.direction = -b.wo
        ray.weight = wp.vec3(1.0)
        return ray
    if number < share:
        ray.direction = mirrored
        ray.weight = wp.vec3(1.0)
    else:
        ray.crossed = 1
        side = -1.0
        if material.thin != 0:
            ray.direction = mirrored - b.normal * (2.0 * wp.dot(mirrored, b.normal))
        else:
            cos_t = wp.sqrt(wp.max(0.0, 1.0 - (1.0 - cos_o * cos_o) / (ratio * ratio)))
            ray.direction = wp.normalize(facet * (cos_o / ratio - cos_t) - b.wo / ratio)
        ray.weight = wp.vec3(1.0)
        if surface.flipped == 0 or material.thin != 0:
            ray.weight = surface.base
    cos_i = side * wp.dot(b.normal, ray.direction)
    if cos_i <= 0.0 or side * wp.dot(surface.geometric, ray.direction) <= 0.0:
        ray.weight = wp.vec3(0.0)
        return ray
    # The facets that hide each other on the way out; what they would pass on is left out.
    ray.weight = ray.weight * (2.0 * cos_i / (cos_i + smith_root(cos_i, b.alpha)))
    return ray
