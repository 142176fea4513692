"""Surface BSDF: a diffuse lobe, a GGX lobe for metal or dielectric, and a clear coat.

The model of UsdPreviewSurface, made energy-conserving: the directional albedo of the coat and of the GGX lobe (from a
table, see `device.albedo_table`) is subtracted from the layers below, and the GGX lobe is scaled for multiple
scattering between microfacets (Turquin, "Practical multiple scattering compensation for microfacet models", 2019).
Microfacet normals are sampled from the distribution of visible normals (Dupuy and Benyoub, "Sampling visible GGX
normals with spherical caps", 2023).
"""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.kernels.scene.visibility import straight_transmittance
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import Material

PI = wp.constant(wp.pi)
# Minimum GGX alpha, used for mirrors: sharper lobes overflow float32.
MIN_ALPHA = wp.constant(1.5e-3)
# Exponent from single-scattering albedo to the escape probability of later microfacet bounces. Fitted to random walks
# on microfacets: within 1 % for any roughness, direction and color.
ESCAPE_EXPONENT = wp.constant(0.6)


@wp.struct
class Bsdf:
    """BSDF parameters at one surface point, for one outgoing direction `wo` toward the viewer."""

    normal: wp.vec3
    smooth_normal: wp.vec3  # interpolated normal, without normal maps
    horizon_normal: wp.vec3  # normal of the geometric horizon, see `Surface`
    wo: wp.vec3
    cos_o: wp.float32
    diffuse: wp.vec3  # albedo of the diffuse lobe, attenuated by the lobes above
    f0: wp.vec3  # reflectance of the GGX lobe at normal incidence
    f90: wp.vec3  # reflectance of the GGX lobe at grazing incidence
    specular_scale: wp.vec3  # multiple-scattering compensation times coat transmittance
    alpha: wp.float32
    coat: wp.float32
    coat_f0: wp.float32
    coat_alpha: wp.float32
    specular_probability: wp.float32  # probability of sampling this lobe; the diffuse lobe has the rest
    coat_probability: wp.float32
    albedo: wp.vec3  # directional albedo of all lobes together


@wp.struct
class BsdfValue:
    """f * cosine, split because lights scale diffuse and specular separately, and the pdf of the direction [1/sr]."""

    diffuse: wp.vec3
    specular: wp.vec3
    pdf: wp.float32


@wp.func
def albedo_terms(table: wp.array(dtype=wp.vec2), cos_o: float, alpha: float):
    """Look up (a, b) such that the directional albedo of a GGX lobe is f0 * a + f90 * b."""
    x = (wp.sqrt(cos_o) - 0.02) * (31.0 / 0.98)
    y = wp.sqrt(alpha) * 31.0
    i = wp.clamp(int(x), 0, 30)
    j = wp.clamp(int(y), 0, 30)
    fx = wp.max(x - float(i), 0.0)
    fy = y - float(j)
    k = j * 32 + i
    low = table[k] * (1.0 - fx) + table[k + 1] * fx
    high = table[k + 32] * (1.0 - fx) + table[k + 33] * fx
    return low * (1.0 - fy) + high * fy


@wp.func
def diffuse_fraction(material: Material, can_refract: int):
    """Scale of the diffuse lobe of a material that is partly transmissive.

    For paths that glass does not refract, stochastic transparency already removes most hits, so the factor is divided
    by the probability of a hit.
    """
    if material.transmission <= 0.0 or can_refract != 0:
        return 1.0
    return (1.0 - material.transmission) / wp.max(1.0 - straight_transmittance(material), 1.0e-6)


@wp.func
def grazing_reflectance(f0: float):
    """F90 for an F0: 1, but fading to 0 for an F0 below 0.02, so that an index of refraction of 1 reflects nothing."""
    return wp.min(1.0, 50.0 * f0)


@wp.func
def ggx_albedo(f0: wp.vec3, f90: wp.vec3, terms: wp.vec2, escape: float):
    """Directional albedo of the GGX lobe with multiple scattering; `escape` is the escape probability per bounce."""
    single = terms[0] + terms[1]
    f = wp.min(f0, wp.vec3(1.0))
    multiple = wp.cw_div(f * escape, wp.vec3(1.0) - f * (1.0 - escape))
    return wp.cw_mul(f0 * terms[0] + f90 * terms[1], wp.vec3(1.0) + multiple * (1.0 / single - 1.0))


@wp.func
def diffuse_above_horizon(b: Bsdf):
    """Fraction of diffuse albedo that `shadow_terminator` keeps under uniform light; within 1.3 % up to 75 degrees."""
    cosine = wp.dot(b.smooth_normal, b.normal)
    sine = wp.sqrt(wp.max(1.0 - cosine * cosine, 0.0))
    return 1.0 - sine * (0.231 + 0.199 * sine)


@wp.func
def microfacets_above(elevation: float, alpha: float):
    """Fraction of GGX microfacets that reflect above a plane.

    Args:
        elevation: sine of the elevation of the mean reflection above the plane.
    """
    sine = wp.clamp(elevation, 0.0, 1.0)
    slope = sine / (1.0 + wp.sqrt(1.0 - sine * sine))
    return 0.5 + 0.5 * slope / wp.sqrt(slope * slope + alpha * alpha)


@wp.func
def specular_above_horizon(b: Bsdf):
    """Fraction of the specular lobe that stays above the surface when a normal map tilts the lobe."""
    elevation = 2.0 * b.cos_o * wp.dot(b.normal, b.smooth_normal) - wp.dot(b.wo, b.smooth_normal)
    # At grazing angles visible microfacets reflect higher than their mean; near the horizon the weight falls with the
    # width of the lobe. Fitted to the lobe: at most 5 % too low, and too high only at grazing angles of rough lobes.
    bias = 1.2 * b.alpha * (1.0 - b.cos_o)
    fraction = microfacets_above(elevation + bias, b.alpha) / microfacets_above(b.cos_o + bias, b.alpha)
    return wp.pow(wp.clamp(fraction, 0.1, 1.0), 1.0 - 0.5 * b.alpha)


@wp.func
def tilt_compensation(albedo: wp.vec3, above: float):
    """Energy compensation for directions that a normal map tilts below the surface.

    Such light is assumed to hit neighboring bumps of the same albedo and to scatter again, so a white surface stays
    white.
    """
    return wp.vec3(1.0) + wp.min(albedo, wp.vec3(1.0)) * (1.0 / above - 1.0)


@wp.func
def make_bsdf(
    table: wp.array(dtype=wp.vec2),
    surface: Surface,
    material: Material,
    diffuse_scale: float,
    normal: wp.vec3,
    wo: wp.vec3,
    min_alpha: float,
):
    """Build the BSDF of a textured surface; `min_alpha` bounds roughness from below, `diffuse_scale` scales diffuse."""
    b = Bsdf()
    b.normal = normal
    b.smooth_normal = surface.normal
    b.horizon_normal = surface.horizon_normal
    b.wo = wo
    b.cos_o = wp.max(wp.dot(normal, wo), 1.0e-4)
    roughness = wp.clamp(surface.roughness, 0.0, 1.0)
    metallic = wp.clamp(surface.metallic, 0.0, 1.0)
    b.alpha = wp.max(wp.max(roughness * roughness, MIN_ALPHA), min_alpha)
    b.f0 = surface.specular * (1.0 - metallic) + surface.base * metallic
    dielectric_f90 = wp.vec3(grazing_reflectance(wp.max(surface.specular)))
    white_f90 = wp.vec3(grazing_reflectance(wp.max(surface.base)))
    metal_f90 = surface.base + (white_f90 - surface.base) * material.metal_f90
    b.f90 = dielectric_f90 * (1.0 - metallic) + metal_f90 * metallic
    terms = albedo_terms(table, b.cos_o, b.alpha)
    escape = wp.pow(terms[0] + terms[1], ESCAPE_EXPONENT)
    # Metallic blends the albedos of a metal and a dielectric; only the dielectric attenuates the diffuse layer below.
    dielectric = ggx_albedo(surface.specular, dielectric_f90, terms, escape)
    metal = ggx_albedo(surface.base, metal_f90, terms, escape)
    reflected = dielectric * (1.0 - metallic) + metal * metallic
    tiny = wp.vec3(1.0e-12)
    b.specular_scale = wp.cw_div(reflected + tiny, b.f0 * terms[0] + b.f90 * terms[1] + tiny)
    b.diffuse = wp.cw_mul(surface.base, wp.vec3(1.0) - dielectric) * ((1.0 - metallic) * diffuse_scale)
    b.coat_alpha = 1.0
    coat_albedo = float(0.0)
    if surface.clearcoat > 0.0:
        coat_roughness = wp.clamp(surface.clearcoat_roughness, 0.0, 1.0)
        b.coat = wp.min(surface.clearcoat, 1.0)
        b.coat_f0 = material.coat_f0
        b.coat_alpha = wp.max(wp.max(coat_roughness * coat_roughness, MIN_ALPHA), min_alpha)
        coat_terms = albedo_terms(table, b.cos_o, b.coat_alpha)
        coat_albedo = b.coat * (b.coat_f0 * coat_terms[0] + grazing_reflectance(b.coat_f0) * coat_terms[1])
        through = 1.0 - coat_albedo
        b.specular_scale = b.specular_scale * through
        b.diffuse = b.diffuse * through
        reflected = reflected * through
    b.albedo = b.diffuse + reflected + wp.vec3(coat_albedo)
    if wp.dot(b.smooth_normal, normal) < 0.9999:
        b.diffuse = wp.cw_mul(b.diffuse, tilt_compensation(b.albedo, diffuse_above_horizon(b)))
        b.specular_scale = wp.cw_mul(b.specular_scale, tilt_compensation(b.albedo, specular_above_horizon(b)))
    diffuse_weight = luminance(b.diffuse)
    specular_weight = luminance(reflected)
    total = diffuse_weight + specular_weight + coat_albedo
    if total > 0.0:
        b.specular_probability = specular_weight / total
        b.coat_probability = coat_albedo / total
    return b


@wp.func
def ggx_ndf(cos_h: float, alpha: float):
    a2 = alpha * alpha
    x = cos_h * cos_h * (a2 - 1.0) + 1.0
    return a2 / (PI * x * x)


@wp.func
def smith_root(c: float, alpha: float):
    a2 = alpha * alpha
    return wp.sqrt(a2 + (1.0 - a2) * c * c)


@wp.func
def fresnel(f0: wp.vec3, f90: wp.vec3, cos_d: float):
    m = 1.0 - cos_d
    m2 = m * m
    return f0 + (f90 - f0) * (m2 * m2 * m)


@wp.func
def shadow_terminator(b: Bsdf, cos_i: float, wi: wp.vec3):
    """Attenuate light near the shadow terminator of a normal map (Chiang et al., 2019).

    Measured against the interpolated normal: against the triangle's, smooth meshes would show their facets.
    """
    g = wp.dot(b.smooth_normal, wi) / (cos_i * wp.max(wp.dot(b.smooth_normal, b.normal), 1.0e-3))
    if g >= 1.0:
        return 1.0
    g = wp.max(g, 0.0)
    return g * (1.0 + g - g * g)


@wp.func
def evaluate_bsdf(b: Bsdf, wi: wp.vec3):
    """Evaluate f * cosine and pdf toward `wi`; reflection only."""
    out = BsdfValue()
    cos_i = wp.dot(b.normal, wi)
    if cos_i <= 1.0e-5 or wp.dot(b.horizon_normal, wi) <= 0.0:
        return out
    half_way = wp.normalize(wi + b.wo)
    cos_h = wp.min(wp.dot(b.normal, half_way), 1.0)
    cos_d = wp.clamp(wp.dot(b.wo, half_way), 0.0, 1.0)
    ndf = ggx_ndf(cos_h, b.alpha)
    root_i = smith_root(cos_i, b.alpha)
    root_o = smith_root(b.cos_o, b.alpha)
    lobe = ndf * 0.5 * cos_i / (b.cos_o * root_i + cos_i * root_o)
    out.specular = wp.cw_mul(fresnel(b.f0, b.f90, cos_d), b.specular_scale) * lobe
    out.diffuse = b.diffuse * (shadow_terminator(b, cos_i, wi) * cos_i / PI)
    out.pdf = b.specular_probability * ndf * 0.5 / (b.cos_o + root_o)
    out.pdf += (1.0 - b.specular_probability - b.coat_probability) * cos_i / PI
    if b.coat > 0.0:
        ndf = ggx_ndf(cos_h, b.coat_alpha)
        root_i = smith_root(cos_i, b.coat_alpha)
        root_o = smith_root(b.cos_o, b.coat_alpha)
        m = 1.0 - cos_d
        reflectance = b.coat * (b.coat_f0 + (grazing_reflectance(b.coat_f0) - b.coat_f0) * m * m * m * m * m)
        lobe = reflectance * ndf * 0.5 * cos_i / (b.cos_o * root_i + cos_i * root_o)
        out.specular += wp.vec3(lobe)
        out.pdf += b.coat_probability * ndf * 0.5 / (b.cos_o + root_o)
    return out


@wp.func
def perpendicular(n: wp.vec3):
    """Return a unit vector perpendicular to n (Duff et al., "Building an Orthonormal Basis, Revisited", 2017)."""
    sign = wp.where(n[2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + n[2])
    return wp.vec3(1.0 + sign * n[0] * n[0] * a, sign * n[0] * n[1] * a, -sign * n[0])


@wp.func
def sample_ggx_reflection(b: Bsdf, alpha: float, tangent: wp.vec3, bitangent: wp.vec3, r: wp.vec2):
    """Reflect `wo` about a microfacet normal sampled from the visible ones."""
    wo = wp.vec3(wp.dot(b.wo, tangent), wp.dot(b.wo, bitangent), wp.dot(b.wo, b.normal))
    stretched = wp.normalize(wp.vec3(alpha * wo[0], alpha * wo[1], wo[2]))
    z = (1.0 - r[0]) * (1.0 + stretched[2]) - stretched[2]
    s = wp.sqrt(wp.clamp(1.0 - z * z, 0.0, 1.0))
    around = cos_sin(r[1])
    h = wp.vec3(s * around[0], s * around[1], z) + stretched
    h = wp.normalize(wp.vec3(alpha * h[0], alpha * h[1], wp.max(h[2], 0.0)))
    half_vector = tangent * h[0] + bitangent * h[1] + b.normal * h[2]
    return half_vector * (2.0 * wp.dot(b.wo, half_vector)) - b.wo


@wp.func
def sample_bsdf(b: Bsdf, r: wp.vec2):
    """Sample a direction with the pdf of `evaluate_bsdf`; the first random number also chooses the lobe."""
    tangent = perpendicular(b.normal)
    bitangent = wp.cross(b.normal, tangent)
    if r[0] < b.specular_probability:
        return sample_ggx_reflection(b, b.alpha, tangent, bitangent, wp.vec2(r[0] / b.specular_probability, r[1]))
    remaining = r[0] - b.specular_probability
    if remaining < b.coat_probability:
        return sample_ggx_reflection(b, b.coat_alpha, tangent, bitangent, wp.vec2(remaining / b.coat_probability, r[1]))
    u = wp.min((remaining - b.coat_probability) / (1.0 - b.specular_probability - b.coat_probability), 1.0)
    s = wp.sqrt(u)
    around = cos_sin(r[1])
    d = tangent * (s * around[0]) + bitangent * (s * around[1])
    return d + b.normal * wp.sqrt(1.0 - u)
