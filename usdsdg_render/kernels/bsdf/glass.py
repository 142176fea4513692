"""Rough dielectric BSDF: reflection or refraction at the two sides of glass, tinted on entry.

Microfacet normals are sampled as for every GGX lobe (see `bsdf`); Fresnel's equations choose reflection or
transmission.
Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007).
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import Bsdf, perpendicular, sample_ggx_reflection, smith_root
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.scene.structs import CLEAR_PANE, Material


@wp.struct
class GlassSample:
    """A direction sampled from the glass BSDF; weight 0 = absorbed."""

    direction: wp.vec3
    weight: wp.vec3
    transmitted: wp.int32  # 1 = transmitted, 0 = reflected


@wp.func
def fresnel_dielectric(cos_i: float, ratio: float):
    """Unpolarized Fresnel reflectance; `ratio` is the transmitted over the incident index of refraction."""
    sin2_t = (1.0 - cos_i * cos_i) / (ratio * ratio)
    if sin2_t >= 1.0:
        return 1.0
    cos_t = wp.sqrt(1.0 - sin2_t)
    parallel_amplitude = (ratio * cos_i - cos_t) / (ratio * cos_i + cos_t)
    perpendicular_amplitude = (cos_i - ratio * cos_t) / (cos_i + ratio * cos_t)
    return 0.5 * (parallel_amplitude * parallel_amplitude + perpendicular_amplitude * perpendicular_amplitude)


@wp.func
def sample_glass(surface: Surface, material: Material, b: Bsdf, number: float, r: wp.vec2):
    """Sample reflection or transmission at a microfacet; `number` in [0, 1) chooses between them."""
    ray = GlassSample()
    tangent = perpendicular(b.normal)
    reflected = sample_ggx_reflection(b, b.alpha, tangent, wp.cross(b.normal, tangent), r)
    half_vector = wp.normalize(reflected + b.wo)
    cos_o = wp.clamp(wp.dot(b.wo, half_vector), 0.0, 1.0)
    ratio = wp.max(material.ior, 1.0e-3)
    if surface.flipped != 0 and material.thin == 0:
        ratio = 1.0 / ratio
    reflectance = fresnel_dielectric(cos_o, ratio)
    if material.thin != 0:
        # Geometric series of the interreflections between the two faces of a pane.
        reflectance = 2.0 * reflectance / (1.0 + reflectance)
    side = float(1.0)
    if number >= reflectance and material.thin == CLEAR_PANE:
        ray.transmitted = 1
        ray.direction = -b.wo
        ray.weight = wp.vec3(1.0)
        return ray
    if number < reflectance:
        ray.direction = reflected
        ray.weight = wp.vec3(1.0)
    else:
        ray.transmitted = 1
        side = -1.0
        if material.thin != 0:
            ray.direction = reflected - b.normal * (2.0 * wp.dot(reflected, b.normal))
        else:
            cos_t = wp.sqrt(wp.max(0.0, 1.0 - (1.0 - cos_o * cos_o) / (ratio * ratio)))
            ray.direction = wp.normalize(half_vector * (cos_o / ratio - cos_t) - b.wo / ratio)
        ray.weight = wp.vec3(1.0)
        if surface.flipped == 0 or material.thin != 0:
            ray.weight = surface.base
    cos_i = side * wp.dot(b.normal, ray.direction)
    if cos_i <= 0.0 or side * wp.dot(surface.geometric, ray.direction) <= 0.0:
        ray.weight = wp.vec3(0.0)
        return ray
    # Shadowing and masking on the way out; multiple scattering is left out.
    ray.weight = ray.weight * (2.0 * cos_i / (cos_i + smith_root(cos_i, b.alpha)))
    return ray
