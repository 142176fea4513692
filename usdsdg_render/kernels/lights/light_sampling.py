"""Light sampling: choice of one light for a point, and sampling a direction toward it.

Analytic lights are not geometry: they occlude nothing, except that a camera ray ends at the first visible one. One
light is chosen for each point, with a probability in proportion to its estimated unoccluded irradiance there.
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import perpendicular
from usdsdg_render.kernels.lights.cdf import invert_cdf
from usdsdg_render.kernels.lights.emissive_instances import sample_emissive_light
from usdsdg_render.kernels.lights.light_shapes import (
    LightSample,
    emitted_radiance,
    half_axes,
    hit_light,
    to_light_frame,
)
from usdsdg_render.kernels.scene.texture import cell_pdf, cell_radiance, environment_radiance
from usdsdg_render.kernels.scene.visibility import FAR_AWAY
from usdsdg_render.kernels.trig import acos_over_pi, cos_sin
from usdsdg_render.scene.structs import (
    LIGHT_CYLINDER,
    LIGHT_DISK,
    LIGHT_DISTANT,
    LIGHT_ELLIPSOID,
    LIGHT_MESH,
    LIGHT_RECT,
    LIGHT_SPHERE,
    Dome,
    Light,
    SceneTables,
)

PI = wp.constant(wp.pi)


@wp.struct
class LightChoice:
    """The light chosen for a point."""

    index: wp.int32  # row in `lights`; `light_count` = the dome, -1 = none
    probability: wp.float32
    weight_sum: wp.float32  # sum of the selection weights of all lights
    remaining: wp.float32  # the random number, rescaled to [0, 1) for reuse


@wp.func
def sample_cone(axis: wp.vec3, one_minus_cos_max: float, r: wp.vec2):
    """Sample a direction uniformly in a cone; `one_minus_cos_max` is one minus the cosine of its half angle."""
    one_minus_cos = r[0] * one_minus_cos_max
    c = 1.0 - one_minus_cos
    s = wp.sqrt(wp.max(0.0, one_minus_cos * (2.0 - one_minus_cos)))
    around = cos_sin(r[1])
    tangent = perpendicular(axis)
    bitangent = wp.cross(axis, tangent)
    return wp.normalize(tangent * (s * around[0]) + bitangent * (s * around[1]) + axis * c)


@wp.func
def sample_plane(light: Light, r: wp.vec2):
    """Sample a point uniformly on a rectangle or disk."""
    x = (r[0] - 0.5) * light.width
    y = (r[1] - 0.5) * light.height
    if light.kind == LIGHT_DISK:
        radius = light.radius * wp.sqrt(r[0])
        around = cos_sin(r[1])
        x = radius * around[0]
        y = radius * around[1] * light.aspect[0]
    return light.position + light.x_axis * x + light.y_axis * y


@wp.func
def sample_sphere(center: wp.vec3, radius: float, r: wp.vec2):
    """Sample a direction from the origin in the cone of a sphere; any direction if the origin is inside of it."""
    d2 = wp.dot(center, center)
    sin2 = radius * radius / d2
    if sin2 < 1.0:
        return sample_cone(center / wp.sqrt(d2), sin2 / (1.0 + wp.sqrt(1.0 - sin2)), r)
    z = 1.0 - 2.0 * r[0]
    c = wp.sqrt(wp.max(0.0, 1.0 - z * z))
    around = cos_sin(r[1])
    return wp.vec3(c * around[0], c * around[1], z)


@wp.func
def sample_analytic_light(light: Light, point: wp.vec3, r: wp.vec2):
    """Sample a direction from `point` to an analytic light: not a dome, not an emissive instance."""
    s = LightSample()
    s.diffuse = light.diffuse
    s.specular = light.specular
    if light.kind == LIGHT_DISTANT:
        s.distance = FAR_AWAY
        s.direction = light.z_axis
        s.pdf = -1.0
        if light.cos_angle < 1.0:
            s.direction = sample_cone(light.z_axis, 1.0 - light.cos_angle, r)
            s.pdf = 1.0 / (2.0 * PI * (1.0 - light.cos_angle))
        s.radiance = emitted_radiance(light, s.direction, light.position)
        return s
    if light.kind == LIGHT_SPHERE:
        s.direction = sample_sphere(light.position - point, light.radius, r)
    elif light.kind == LIGHT_ELLIPSOID:
        axes = half_axes(light)
        center = wp.cw_div(to_light_frame(light, light.position - point), axes)
        d = wp.cw_mul(sample_sphere(center, 1.0, r), axes)
        s.direction = wp.normalize(light.x_axis * d[0] + light.y_axis * d[1] + light.z_axis * d[2])
    elif light.kind == LIGHT_CYLINDER:
        around = cos_sin(r[1])
        on = light.y_axis * around[0] + light.z_axis * (around[1] * light.aspect[0])
        on = light.position + light.x_axis * ((r[0] - 0.5) * light.height) + on * light.radius
        s.direction = wp.normalize(on - point)
        # Drop samples on the far side: the same ray hits the near side, which is sampled with the same pdf.
        outward = light.y_axis * around[0] + light.z_axis * (around[1] / light.aspect[0])
        if wp.dot(s.direction, outward) >= 0.0:
            return s
    else:
        s.direction = wp.normalize(sample_plane(light, r) - point)
    hit = hit_light(light, point, s.direction)
    if hit.distance > 0.0:
        s.distance = hit.distance
        s.radiance = hit.radiance
        s.pdf = hit.pdf
    return s


@wp.func
def sample_environment(dome: Dome, r: wp.vec2, fine: bool):
    """Sample a direction by the CDFs of the environment grid; radiance of the full-resolution map if `fine`."""
    y = invert_cdf(dome.row_cdf, 0, dome.grid_height, r[0])
    fy = (r[0] - dome.row_cdf[y]) / wp.max(dome.row_cdf[y + 1] - dome.row_cdf[y], 1.0e-30)
    start = y * (dome.grid_width + 1)
    x = invert_cdf(dome.cell_cdf, start, dome.grid_width, r[1])
    fx = (r[1] - dome.cell_cdf[x]) / wp.max(dome.cell_cdf[x + 1] - dome.cell_cdf[x], 1.0e-30)
    x -= start
    # Uniform in the cosine, so the pdf is constant over a cell.
    upper = cos_sin(0.5 * float(y) / float(dome.grid_height))[0]
    lower = cos_sin(0.5 * float(y + 1) / float(dome.grid_height))[0]
    z = wp.clamp(upper + (lower - upper) * wp.min(fy, 1.0), -1.0, 1.0)
    u = (float(x) + wp.min(fx, 1.0)) / float(dome.grid_width)
    around = cos_sin(u)
    sine = wp.sqrt(wp.max(0.0, 1.0 - z * z))
    direction = wp.transpose(dome.dome_from_world) * wp.vec3(sine * around[0], sine * around[1], z)
    cell = y * dome.grid_width + x
    radiance = wp.vec3(0.0)
    if fine:
        radiance = environment_radiance(dome, wp.vec2(u, acos_over_pi(z)))
    else:
        radiance = cell_radiance(dome, cell)
    return LightSample(
        direction=direction,
        distance=FAR_AWAY,
        radiance=radiance,
        pdf=cell_pdf(dome, cell),
        diffuse=dome.diffuse,
        specular=dome.specular,
    )


@wp.func
def light_weight(light: Light, point: wp.vec3, normal: wp.vec3, environment_weight: float):
    """Estimated irradiance of a light at a point, not occluded: its selection weight, zero only if it contributes none.

    `environment_weight` accounts for the occlusion of distant lights by the scene.
    """
    if light.kind == LIGHT_DISTANT:
        return environment_weight * light.strength * wp.clamp(wp.dot(normal, light.z_axis) + light.extent, 0.0, 1.0)
    to_light = light.position - point
    e2 = light.extent * light.extent
    d2 = wp.dot(to_light, to_light)
    if d2 <= e2:
        return light.strength / e2
    inverse_distance = 1.0 / wp.sqrt(d2)
    angular_radius = light.extent * inverse_distance
    # The point is outside of the shaping cone of every point of the light.
    cos_axis = wp.dot(to_light, light.z_axis) * inverse_distance + 2.0 * angular_radius
    if light.shaping_cos > -1.0 and cos_axis <= light.shaping_cos:
        return 0.0
    cosine = wp.clamp(wp.dot(normal, to_light) * inverse_distance + angular_radius, 0.0, 1.0)
    if light.kind == LIGHT_RECT or light.kind == LIGHT_DISK:
        cosine *= wp.clamp(wp.dot(to_light, light.z_axis) * inverse_distance + angular_radius, 0.0, 1.0)
    return light.strength * cosine / d2


@wp.func
def choose_light(tables: SceneTables, point: wp.vec3, normal: wp.vec3, number: float, environment_weight: float):
    """Choose one light for a point with probability in proportion to `light_weight`.

    The random number is rescaled for reuse (`remaining`): low-discrepancy points stay well distributed within the strip
    of each light, which an independent number for the choice would spoil.
    """
    chosen = LightChoice()
    chosen.index = -1
    dome_weight = tables.dome.strength * environment_weight
    weight_sum = dome_weight
    for k in range(tables.light_count):
        weight_sum += light_weight(tables.lights[k], point, normal, environment_weight)
    if weight_sum <= 0.0:
        return chosen
    chosen.weight_sum = weight_sum
    target = number * weight_sum
    weight = dome_weight
    if target < weight:
        chosen.index = tables.light_count
    else:
        target -= weight
        for k in range(tables.light_count):
            candidate = light_weight(tables.lights[k], point, normal, environment_weight)
            if candidate > 0.0:
                chosen.index = k
                weight = candidate
                if target < candidate:
                    break
                target -= candidate
    chosen.probability = weight / weight_sum
    chosen.remaining = wp.min(target / weight, 0.99999994)
    return chosen


@wp.func
def sample_light(tables: SceneTables, index: int, point: wp.vec3, r: wp.vec2, fine_environment: bool):
    """Sample a direction from `point` to the chosen light."""
    if index < 0:
        return LightSample()
    if index < tables.light_count:
        if tables.lights[index].kind == LIGHT_MESH:
            return sample_emissive_light(tables, tables.lights[index], point, r)
        return sample_analytic_light(tables.lights[index], point, r)
    return sample_environment(tables.dome, r, fine_environment)
