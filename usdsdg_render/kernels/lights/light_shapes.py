"""Analytic light shapes: ray intersection, and radiance emitted toward the ray's origin."""

import warp as wp

from usdsdg_render.kernels.scene.visibility import FAR_AWAY
from usdsdg_render.kernels.trig import acos_over_pi, azimuth_turns
from usdsdg_render.scene.structs import (
    LIGHT_CYLINDER,
    LIGHT_DISK,
    LIGHT_DISTANT,
    LIGHT_ELLIPSOID,
    LIGHT_SPHERE,
    EmissionProfile,
    Light,
)

PI = wp.constant(wp.pi)


@wp.struct
class LightSample:
    """A sampled direction toward a light; pdf 0 = no sample, pdf < 0 = a delta light."""

    direction: wp.vec3
    distance: wp.float32
    radiance: wp.vec3  # nits; lux for a delta light
    pdf: wp.float32
    diffuse: wp.float32
    specular: wp.float32


@wp.struct
class LightHit:
    """Intersection of a ray with a light, and the pdf of `sample_analytic_light` for it; distance < 0 = no hit."""

    distance: wp.float32
    radiance: wp.vec3
    pdf: wp.float32


@wp.func
def shaping(light: Light, emitted_direction: wp.vec3):
    """Return the factor of a light's cone and focus along a unit direction of emission (UsdLuxShapingAPI)."""
    c = -wp.dot(emitted_direction, light.z_axis)
    falloff = float(1.0)
    if light.shaping_cos > -1.0:
        if c <= light.shaping_cos:
            return wp.vec3(0.0)
        if light.shaping_softness > 0.0:
            cutoff = wp.acos(wp.clamp(light.shaping_cos, -1.0, 1.0))
            start = cutoff * (1.0 - wp.min(light.shaping_softness, 1.0))
            falloff = 1.0 - wp.smoothstep(start, cutoff, wp.acos(wp.clamp(c, -1.0, 1.0)))
    if light.shaping_focus > 0.0:
        focus = wp.pow(wp.abs(c), light.shaping_focus)
        return (light.focus_tint * (1.0 - focus) + wp.vec3(focus)) * falloff
    return wp.vec3(falloff)


@wp.func
def ies_factor(profile: EmissionProfile, toward: wp.vec3):
    """Look up an IES profile bilinearly; `toward` is the unit direction to the light, in the light's frame."""
    values = wp.array(ptr=profile.ies, shape=(profile.ies_height * profile.ies_width,), dtype=wp.float32)
    y = acos_over_pi(wp.clamp(toward[2], -1.0, 1.0)) * float(profile.ies_height - 1)
    x = azimuth_turns(toward[0], toward[1]) * float(profile.ies_width)
    y0 = wp.clamp(int(y), 0, profile.ies_height - 2)
    x0 = wp.clamp(int(x), 0, profile.ies_width - 1)
    x1 = wp.where(x0 + 1 == profile.ies_width, 0, x0 + 1)
    fy = y - float(y0)
    fx = x - float(x0)
    row = y0 * profile.ies_width
    upper = values[row + x0] * (1.0 - fx) + values[row + x1] * fx
    row += profile.ies_width
    lower = values[row + x0] * (1.0 - fx) + values[row + x1] * fx
    return upper * (1.0 - fy) + lower * fy


@wp.func
def light_texture_at(profile: EmissionProfile, u: float, v: float):
    """Look up a light texture bilinearly, u to the right and v downwards in [0, 1]."""
    texels = wp.array(ptr=profile.texels, shape=(profile.height * profile.width,), dtype=wp.vec3)
    x = wp.clamp(u * float(profile.width) - 0.5, 0.0, float(profile.width - 1))
    y = wp.clamp(v * float(profile.height) - 0.5, 0.0, float(profile.height - 1))
    x0 = int(x)
    y0 = int(y)
    x1 = wp.min(x0 + 1, profile.width - 1)
    y1 = wp.min(y0 + 1, profile.height - 1) * profile.width
    y0 *= profile.width
    fx = x - wp.floor(x)
    fy = y - wp.floor(y)
    upper = texels[y0 + x0] * (1.0 - fx) + texels[y0 + x1] * fx
    lower = texels[y1 + x0] * (1.0 - fx) + texels[y1 + x1] * fx
    return upper * (1.0 - fy) + lower * fy


@wp.func
def emitted_radiance(light: Light, direction: wp.vec3, point: wp.vec3):
    """Return the radiance [nits] emitted at a point of a light against `direction`, a ray toward the light."""
    radiance = wp.cw_mul(light.radiance, shaping(light, -direction))
    if light.emission_profile != wp.uint64(0):
        profile = wp.array(ptr=light.emission_profile, shape=(1,), dtype=EmissionProfile)[0]
        if profile.ies != wp.uint64(0):
            toward = wp.vec3(
                wp.dot(direction, light.x_axis), wp.dot(direction, light.y_axis), wp.dot(direction, light.z_axis)
            )
            radiance *= ies_factor(profile, toward)
        if profile.texels != wp.uint64(0):
            u = 0.5 - wp.dot(point - light.position, light.x_axis) / light.width
            v = 0.5 - wp.dot(point - light.position, light.y_axis) / light.height
            radiance = wp.cw_mul(radiance, light_texture_at(profile, u, v))
    return radiance


@wp.func
def cone_pdf(sin2: float):
    """Return the uniform pdf over a cone, from the squared sine of its half angle; accurate for thin cones."""
    return 1.0 / (2.0 * PI * (sin2 / (1.0 + wp.sqrt(wp.max(0.0, 1.0 - sin2)))))


@wp.func
def hit_sphere(center: wp.vec3, radius: float, direction: wp.vec3):
    """Intersect a ray from the origin with a sphere; the pdf is uniform over the cone that the sphere subtends."""
    hit = LightHit()
    hit.distance = -1.0
    d2 = wp.dot(center, center)
    r2 = radius * radius
    along = wp.dot(center, direction)
    off_axis = center - direction * along
    q = r2 - wp.dot(off_axis, off_axis)
    if q <= 0.0:
        return hit
    if d2 > r2:
        hit.distance = along - wp.sqrt(q)
        hit.pdf = cone_pdf(r2 / d2)
    else:
        hit.distance = along + wp.sqrt(q)
        hit.pdf = 1.0 / (4.0 * PI)
    return hit


@wp.func
def half_axes(light: Light):
    return wp.vec3(light.radius, light.radius * light.aspect[0], light.radius * light.aspect[1])


@wp.func
def to_light_frame(light: Light, v: wp.vec3):
    return wp.vec3(wp.dot(v, light.x_axis), wp.dot(v, light.y_axis), wp.dot(v, light.z_axis))


@wp.func
def hit_ellipsoid(light: Light, origin: wp.vec3, direction: wp.vec3):
    """Intersect an ellipsoid in the space where it is a unit sphere.

    Solid angles change by the cube of the ray's length in that space, times the product of the half axes.
    """
    axes = half_axes(light)
    squeezed = wp.cw_div(to_light_frame(light, direction), axes)
    length = wp.length(squeezed)
    hit = hit_sphere(wp.cw_div(to_light_frame(light, light.position - origin), axes), 1.0, squeezed / length)
    hit.distance = hit.distance / length
    hit.pdf = hit.pdf / (axes[0] * axes[1] * axes[2] * length * length * length)
    return hit


@wp.func
def hit_plane(light: Light, origin: wp.vec3, direction: wp.vec3):
    """Intersect a rectangle or disk; both emit from their -z side only."""
    hit = LightHit()
    hit.distance = -1.0
    c = wp.dot(direction, light.z_axis)
    if c <= 1.0e-7:
        return hit
    t = wp.dot(light.position - origin, light.z_axis) / c
    if t <= 0.0:
        return hit
    p = origin + direction * t - light.position
    x = wp.dot(p, light.x_axis)
    y = wp.dot(p, light.y_axis)
    area = light.width * light.height
    if light.kind == LIGHT_DISK:
        area = PI * light.radius * light.radius * light.aspect[0]
        y /= light.aspect[0]
        if x * x + y * y > light.radius * light.radius:
            return hit
    elif wp.abs(x) > 0.5 * light.width or wp.abs(y) > 0.5 * light.height:
        return hit
    hit.distance = t
    hit.pdf = t * t / (area * c)
    return hit


@wp.func
def hit_cylinder(light: Light, origin: wp.vec3, direction: wp.vec3):
    """Intersect the outside of an open cylinder about x, in a space where its cross section is a circle."""
    hit = LightHit()
    hit.distance = -1.0
    to_origin = origin - light.position
    oy = wp.dot(to_origin, light.y_axis)
    oz = wp.dot(to_origin, light.z_axis) / light.aspect[0]
    dy = wp.dot(direction, light.y_axis)
    dz = wp.dot(direction, light.z_axis) / light.aspect[0]
    a = dy * dy + dz * dz
    b = oy * dy + oz * dz
    # Discriminant from the distance between ray and axis: no cancellation far away.
    cross = oy * dz - oz * dy
    q = light.radius * light.radius * a - cross * cross
    if q <= 0.0 or b >= 0.0 or a < 1.0e-12:
        return hit
    root = wp.sqrt(q)
    t = (-b - root) / a
    x = wp.dot(to_origin, light.x_axis) + t * wp.dot(direction, light.x_axis)
    if t <= 0.0 or wp.abs(x) > 0.5 * light.height:
        return hit
    hit.distance = t
    # Points are sampled uniformly in angle. For a circle root / radius is the cosine at the surface; for an ellipse its
    # product with the arc length element is the same.
    hit.pdf = t * t / (2.0 * PI * light.height * light.aspect[0] * root)
    return hit


@wp.func
def hit_light(light: Light, origin: wp.vec3, direction: wp.vec3):
    """Intersect a ray with a light that has a surface, or with the disk of a distant light."""
    hit = LightHit()
    hit.distance = -1.0
    if light.kind != LIGHT_DISTANT:
        # Most rays miss the bounding sphere.
        to_center = light.position - origin
        along = wp.max(wp.dot(to_center, direction), 0.0)
        nearest = to_center - direction * along
        if wp.dot(nearest, nearest) > 1.0001 * light.extent * light.extent:
            return hit
    if light.kind == LIGHT_SPHERE:
        hit = hit_sphere(light.position - origin, light.radius, direction)
    elif light.kind == LIGHT_CYLINDER:
        hit = hit_cylinder(light, origin, direction)
    elif light.kind == LIGHT_DISTANT:
        if wp.dot(direction, light.z_axis) > light.cos_angle:
            hit.distance = FAR_AWAY
            hit.pdf = 1.0 / (2.0 * PI * (1.0 - light.cos_angle))
    elif light.kind == LIGHT_ELLIPSOID:
        hit = hit_ellipsoid(light, origin, direction)
    else:
        hit = hit_plane(light, origin, direction)
    if hit.distance >= 0.0:
        hit.radiance = emitted_radiance(light, direction, origin + direction * hit.distance)
    return hit
