"""How a surface scatters light: diffuse, a GGX lobe for metal or dielectric, and a clear coat.

The model of UsdPreviewSurface with energy kept in balance: whatever the coat and the GGX lobe reflect in all
directions together (a table, see `energy`) is missing from what lies below, and the GGX lobe is scaled by what light
brings that several facets hand on (as Turquin does, "Practical multiple scattering compensation for microfacet models",
2019). Facets are sampled as seen from the viewer (Dupuy and Benyoub, "Sampling visible GGX normals with spherical
caps", 2023).
"""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.scene.surface import Surface
from usdsdg_render.kernels.scene.visibility import clearness
from usdsdg_render.kernels.trig import cos_sin
from usdsdg_render.scene.structs import Material

PI = wp.constant(wp.pi)
# A mirror is this rough [GGX alpha]: sharper lobes overflow float32.
MIN_ALPHA = wp.constant(1.5e-3)
# Of light that facets hand on, what leaves at the next one is this power of the share that leaves at the first: within
# 1 % of walks from facet to facet, for any roughness, direction and colour.
LEAVING = wp.constant(0.6)


@wp.struct
class Bsdf:
    """Scattering at one point, for one direction `wo` to the viewer."""

    normal: wp.vec3
    smooth: wp.vec3  # the normal without the material's normal maps
    horizon: wp.vec3
    wo: wp.vec3
    cos_o: wp.float32
    diffuse: wp.vec3  # albedo of the diffuse lobe, after what the lobes above reflect
    f0: wp.vec3  # reflectance of the GGX lobe at normal incidence
    f90: wp.vec3  # and at grazing incidence
    specular_scale: wp.vec3  # multiple scattering, and what the coat lets through
    alpha: wp.float32
    coat: wp.float32
    coat_f0: wp.float32
    coat_alpha: wp.float32
    choose_specular: wp.float32  # chance of each lobe in sampling; diffuse has the rest
    choose_coat: wp.float32
    albedo: wp.vec3  # directional albedo of all lobes


@wp.struct
class Scattered:
    """f * cosine, split so that lights can dim either part, and the density of the direction [1/sr]."""

    diffuse: wp.vec3
    specular: wp.vec3
    pdf: wp.float32


@wp.func
def albedo_terms(table: wp.array(dtype=wp.vec2), cos_o: float, alpha: float):
    """(a, b) such that a GGX lobe has the directional albedo f0 * a + f90 * b."""
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
def opaque_share(material: Material, refracting: int):
    """How much of the diffuse light is left where a path did not go through the material as through glass.

    Where glass is there by chance for paths that it does not bend, what is left is met more seldom already.
    """
    if material.transmission <= 0.0 or refracting != 0:
        return 1.0
    return (1.0 - material.transmission) / wp.max(1.0 - clearness(material), 1.0e-6)


@wp.func
def grazing(f0: float):
    """Reflectance at grazing incidence: what reflects nothing head on (an index of refraction of 1) has none there."""
    return wp.min(1.0, 50.0 * f0)


@wp.func
def reflected_share(f0: wp.vec3, f90: wp.vec3, terms: wp.vec2, leaves: float):
    """Directional albedo of the GGX lobe; of light that facets hand on, the share `leaves` leaves at each."""
    once = terms[0] + terms[1]
    f = wp.min(f0, wp.vec3(1.0))
    later = wp.cw_div(f * leaves, wp.vec3(1.0) - f * (1.0 - leaves))
    return wp.cw_mul(f0 * terms[0] + f90 * terms[1], wp.vec3(1.0) + later * (1.0 / once - 1.0))


@wp.func
def diffuse_above(b: Bsdf):
    """How much of the diffuse lobe `terminator` leaves in a uniform world: within 1.3 % up to 75 degrees of tilt."""
    cosine = wp.dot(b.smooth, b.normal)
    sine = wp.sqrt(wp.max(1.0 - cosine * cosine, 0.0))
    return 1.0 - sine * (0.231 + 0.199 * sine)


@wp.func
def facets_above(height: float, alpha: float):
    """Share of GGX facets that mirror light above a plane over which their mean mirrors it at that sine."""
    h = wp.clamp(height, 0.0, 1.0)
    slope = h / (1.0 + wp.sqrt(1.0 - h * h))
    return 0.5 + 0.5 * slope / wp.sqrt(slope * slope + alpha * alpha)


@wp.func
def glossy_above(b: Bsdf):
    """How much of what the glossy lobe sends above the plane of its own normal is above that of the surface, too."""
    height = 2.0 * b.cos_o * wp.dot(b.normal, b.smooth) - wp.dot(b.wo, b.smooth)
    # Facets that are seen at a low angle mirror higher than their mean, and light near the horizon counts less the
    # wider the lobe is. Fitted to the lobe: at most 5 % too little, and too much at low angles of rough lobes alone.
    lifted = 1.2 * b.alpha * (1.0 - b.cos_o)
    share = facets_above(height + lifted, b.alpha) / facets_above(b.cos_o + lifted, b.alpha)
    return wp.pow(wp.clamp(share, 0.1, 1.0), 1.0 - 0.5 * b.alpha)


@wp.func
def gain(albedo: wp.vec3, above: float):
    """What a lobe is to be scaled by where a normal map turns it partly into the surface.

    What does not leave above meets bumps that are like it, and their share of it comes back: white stays white.
    """
    return wp.vec3(1.0) + wp.min(albedo, wp.vec3(1.0)) * (1.0 / above - 1.0)


@wp.func
def bsdf_at(
    table: wp.array(dtype=wp.vec2),
    surface: Surface,
    material: Material,
    opaque: float,
    normal: wp.vec3,
    wo: wp.vec3,
    least_alpha: float,
):
    """Scattering of a textured surface; `least_alpha` widens every glossy lobe, `opaque` dims the diffuse one."""
    b = Bsdf()
    b.normal = normal
    b.smooth = surface.normal
    b.horizon = surface.horizon
    b.wo = wo
    b.cos_o = wp.max(wp.dot(normal, wo), 1.0e-4)
    roughness = wp.clamp(surface.roughness, 0.0, 1.0)
    metallic = wp.clamp(surface.metallic, 0.0, 1.0)
    b.alpha = wp.max(wp.max(roughness * roughness, MIN_ALPHA), least_alpha)
    b.f0 = surface.specular * (1.0 - metallic) + surface.base * metallic
    edge = wp.vec3(grazing(wp.max(surface.specular)))
    white = wp.vec3(grazing(wp.max(surface.base)))
    metal_edge = surface.base + (white - surface.base) * material.metal_edge
    b.f90 = edge * (1.0 - metallic) + metal_edge * metallic
    terms = albedo_terms(table, b.cos_o, b.alpha)
    leaves = wp.pow(terms[0] + terms[1], LEAVING)
    # Half a metal reflects half of what a metal does and half of what a dielectric does, and only under the dielectric
    # half is there something that its reflection is missing from.
    dielectric = reflected_share(surface.specular, edge, terms, leaves)
    metal = reflected_share(surface.base, metal_edge, terms, leaves)
    reflected = dielectric * (1.0 - metallic) + metal * metallic
    tiny = wp.vec3(1.0e-12)
    b.specular_scale = wp.cw_div(reflected + tiny, b.f0 * terms[0] + b.f90 * terms[1] + tiny)
    b.diffuse = wp.cw_mul(surface.base, wp.vec3(1.0) - dielectric) * ((1.0 - metallic) * opaque)
    b.coat_alpha = 1.0
    coat_albedo = float(0.0)
    if surface.clearcoat > 0.0:
        coat_roughness = wp.clamp(surface.clearcoat_roughness, 0.0, 1.0)
        b.coat = wp.min(surface.clearcoat, 1.0)
        b.coat_f0 = material.coat_f0
        b.coat_alpha = wp.max(wp.max(coat_roughness * coat_roughness, MIN_ALPHA), least_alpha)
        coat_terms = albedo_terms(table, b.cos_o, b.coat_alpha)
        coat_albedo = b.coat * (b.coat_f0 * coat_terms[0] + grazing(b.coat_f0) * coat_terms[1])
        through = 1.0 - coat_albedo
        b.specular_scale = b.specular_scale * through
        b.diffuse = b.diffuse * through
        reflected = reflected * through
    b.albedo = b.diffuse + reflected + wp.vec3(coat_albedo)
    if wp.dot(b.smooth, normal) < 0.9999:
        b.diffuse = wp.cw_mul(b.diffuse, gain(b.albedo, diffuse_above(b)))
        b.specular_scale = wp.cw_mul(b.specular_scale, gain(b.albedo, glossy_above(b)))
    diffuse_weight = luminance(b.diffuse)
    specular_weight = luminance(reflected)
    total = diffuse_weight + specular_weight + coat_albedo
    if total > 0.0:
        b.choose_specular = specular_weight / total
        b.choose_coat = coat_albedo / total
    return b


@wp.func
def ggx_density(cos_h: float, alpha: float):
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
def terminator(b: Bsdf, cos_i: float, wi: wp.vec3):
    """Fades light that the surface hides before its bumped normal does (Chiang et al., 2019).

    Only what normal maps add counts: measured from the triangle instead, wavy meshes would show their facets and lose
    light to no shadow.
    """
    g = wp.dot(b.smooth, wi) / (cos_i * wp.max(wp.dot(b.smooth, b.normal), 1.0e-3))
    if g >= 1.0:
        return 1.0
    g = wp.max(g, 0.0)
    return g * (1.0 + g - g * g)


@wp.func
def scatter(b: Bsdf, wi: wp.vec3):
    """f * cosine and density towards `wi`; nothing passes through the surface."""
    out = Scattered()
    cos_i = wp.dot(b.normal, wi)
    if cos_i <= 1.0e-5 or wp.dot(b.horizon, wi) <= 0.0:
        return out
    half_way = wp.normalize(wi + b.wo)
    cos_h = wp.min(wp.dot(b.normal, half_way), 1.0)
    cos_d = wp.clamp(wp.dot(b.wo, half_way), 0.0, 1.0)
    density = ggx_density(cos_h, b.alpha)
    root_i = smith_root(cos_i, b.alpha)
    root_o = smith_root(b.cos_o, b.alpha)
    glossy = density * 0.5 * cos_i / (b.cos_o * root_i + cos_i * root_o)
    out.specular = wp.cw_mul(fresnel(b.f0, b.f90, cos_d), b.specular_scale) * glossy
    out.diffuse = b.diffuse * (terminator(b, cos_i, wi) * cos_i / PI)
    out.pdf = b.choose_specular * density * 0.5 / (b.cos_o + root_o)
    out.pdf += (1.0 - b.choose_specular - b.choose_coat) * cos_i / PI
    if b.coat > 0.0:
        density = ggx_density(cos_h, b.coat_alpha)
        root_i = smith_root(cos_i, b.coat_alpha)
        root_o = smith_root(b.cos_o, b.coat_alpha)
        m = 1.0 - cos_d
        reflectance = b.coat * (b.coat_f0 + (grazing(b.coat_f0) - b.coat_f0) * m * m * m * m * m)
        glossy = reflectance * density * 0.5 * cos_i / (b.cos_o * root_i + cos_i * root_o)
        out.specular += wp.vec3(glossy)
        out.pdf += b.choose_coat * density * 0.5 / (b.cos_o + root_o)
    return out


@wp.func
def perpendicular(n: wp.vec3):
    """A unit vector across n (Duff et al., "Building an Orthonormal Basis, Revisited", 2017)."""
    sign = wp.where(n[2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + n[2])
    return wp.vec3(1.0 + sign * n[0] * n[0] * a, sign * n[0] * n[1] * a, -sign * n[0])


@wp.func
def sample_facet(b: Bsdf, alpha: float, across: wp.vec3, along: wp.vec3, r: wp.vec2):
    """The mirror direction of `wo` about a visible facet."""
    stretched = wp.normalize(wp.vec3(alpha * wp.dot(b.wo, across), alpha * wp.dot(b.wo, along), wp.dot(b.wo, b.normal)))
    z = (1.0 - r[0]) * (1.0 + stretched[2]) - stretched[2]
    s = wp.sqrt(wp.clamp(1.0 - z * z, 0.0, 1.0))
    around = cos_sin(r[1])
    h = wp.vec3(s * around[0], s * around[1], z) + stretched
    h = wp.normalize(wp.vec3(alpha * h[0], alpha * h[1], wp.max(h[2], 0.0)))
    facet = across * h[0] + along * h[1] + b.normal * h[2]
    return facet * (2.0 * wp.dot(b.wo, facet)) - b.wo


@wp.func
def sample_direction(b: Bsdf, r: wp.vec2):
    """A direction drawn from the density that `scatter` reports; the first number also chooses the lobe."""
    across = perpendicular(b.normal)
    along = wp.cross(b.normal, across)
    if r[0] < b.choose_specular:
        return sample_facet(b, b.alpha, across, along, wp.vec2(r[0] / b.choose_specular, r[1]))
    rest = r[0] - b.choose_specular
    if rest < b.choose_coat:
        return sample_facet(b, b.coat_alpha, across, along, wp.vec2(rest / b.choose_coat, r[1]))
    u = wp.min((rest - b.choose_coat) / (1.0 - b.choose_specular - b.choose_coat), 1.0)
    s = wp.sqrt(u)
    around = cos_sin(r[1])
    d = across * (s * around[0]) + along * (s * around[1])
    return d + b.normal * wp.sqrt(1.0 - u)
