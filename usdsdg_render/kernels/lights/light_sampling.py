"""Light arriving at a point: choosing a light and drawing a direction towards it.

Lights are not geometry: they hide nothing, except that a camera ray stops at the first light it sees. One light is
chosen for each point, with its share of what all would give there if nothing were in the way.
"""

import warp as wp

from usdsdg_render.kernels.bsdf.bsdf import perpendicular
from usdsdg_render.kernels.lights.cdf import invert_cdf
from usdsdg_render.kernels.lights.emissive_instances import sample_emitter
from usdsdg_render.kernels.lights.light_shapes import (
    LightSample,
    emitted,
    half_axes,
    hit_light,
    in_frame,
)
from usdsdg_render.kernels.scene.texture import cell_density, cell_radiance, sky_radiance
from usdsdg_render.kernels.scene.visibility import FAR_AWAY
from usdsdg_render.kernels.trig import cos_sin, half_turns_from_pole
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
    """A light chosen for a point: its row, or the number of lights for the dome, or -1 for none."""

    index: wp.int32
    chance: wp.float32
    total: wp.float32  # sum of the weights of all
    number: wp.float32  # what is left of the number that chose it, in [0, 1)


@wp.func
def in_cone(axis: wp.vec3, height: float, r: wp.vec2):
    """A uniform direction in a cone about a unit axis; `height` is one minus the cosine of its half angle."""
    one_minus_cos = r[0] * height
    c = 1.0 - one_minus_cos
    s = wp.sqrt(wp.max(0.0, one_minus_cos * (2.0 - one_minus_cos)))
    around = cos_sin(r[1])
    across = perpendicular(axis)
    along = wp.cross(axis, across)
    return wp.normalize(across * (s * around[0]) + along * (s * around[1]) + axis * c)


@wp.func
def on_plane(light: Light, r: wp.vec2):
    """A uniform point of a rectangle or disk."""
    x = (r[0] - 0.5) * light.width
    y = (r[1] - 0.5) * light.height
    if light.kind == LIGHT_DISK:
        radius = light.radius * wp.sqrt(r[0])
        around = cos_sin(r[1])
        x = radius * around[0]
        y = radius * around[1] * light.aspect[0]
    return light.position + light.x_axis * x + light.y_axis * y


@wp.func
def towards_sphere(center: wp.vec3, radius: float, r: wp.vec2):
    """A direction from the origin: in the cone that a sphere fills, any from inside it."""
    d2 = wp.dot(center, center)
    sin2 = radius * radius / d2
    if sin2 < 1.0:
        return in_cone(center / wp.sqrt(d2), sin2 / (1.0 + wp.sqrt(1.0 - sin2)), r)
    z = 1.0 - 2.0 * r[0]
    c = wp.sqrt(wp.max(0.0, 1.0 - z * z))
    around = cos_sin(r[1])
    return wp.vec3(c * around[0], c * around[1], z)


@wp.func
def sample_one(light: Light, point: wp.vec3, r: wp.vec2):
    """A direction from `point` to a light that is no dome."""
    s = LightSample()
    s.diffuse = light.diffuse
    s.specular = light.specular
    if light.kind == LIGHT_DISTANT:
        s.distance = FAR_AWAY
        s.direction = light.z_axis
        s.pdf = -1.0
        if light.cos_angle < 1.0:
            s.direction = in_cone(light.z_axis, 1.0 - light.cos_angle, r)
            s.pdf = 1.0 / (2.0 * PI * (1.0 - light.cos_angle))
        s.radiance = emitted(light, s.direction, light.position)
        return s
    if light.kind == LIGHT_SPHERE:
        s.direction = towards_sphere(light.position - point, light.radius, r)
    elif light.kind == LIGHT_ELLIPSOID:
        axes = half_axes(light)
        center = wp.cw_div(in_frame(light, light.position - point), axes)
        d = wp.cw_mul(towards_sphere(center, 1.0, r), axes)
        s.direction = wp.normalize(light.x_axis * d[0] + light.y_axis * d[1] + light.z_axis * d[2])
    elif light.kind == LIGHT_CYLINDER:
        around = cos_sin(r[1])
        on = light.y_axis * around[0] + light.z_axis * (around[1] * light.aspect[0])
        on = light.position + light.x_axis * ((r[0] - 0.5) * light.height) + on * light.radius
        s.direction = wp.normalize(on - point)
        # The far side of the tube faces away; the same ray meets the near side with the same density, so it is dropped.
        outward = light.y_axis * around[0] + light.z_axis * (around[1] / light.aspect[0])
        if wp.dot(s.direction, outward) >= 0.0:
            return s
    else:
        s.direction = wp.normalize(on_plane(light, r) - point)
    hit = hit_light(light, point, s.direction)
    if hit.distance > 0.0:
        s.distance = hit.distance
        s.radiance = hit.radiance
        s.pdf = hit.pdf
    return s


@wp.func
def sample_sky(dome: Dome, r: wp.vec2, fine: bool):
    """A direction drawn from the sky's cells, and the radiance there: of the picture itself if `fine`."""
    y = invert_cdf(dome.row_cdf, 0, dome.grid_height, r[0])
    fy = (r[0] - dome.row_cdf[y]) / wp.max(dome.row_cdf[y + 1] - dome.row_cdf[y], 1.0e-30)
    start = y * (dome.grid_width + 1)
    x = invert_cdf(dome.cell_cdf, start, dome.grid_width, r[1])
    fx = (r[1] - dome.cell_cdf[x]) / wp.max(dome.cell_cdf[x + 1] - dome.cell_cdf[x], 1.0e-30)
    x -= start
    # Uniform in the cosine makes the density constant over the cell.
    upper = cos_sin(0.5 * float(y) / float(dome.grid_height))[0]
    lower = cos_sin(0.5 * float(y + 1) / float(dome.grid_height))[0]
    z = wp.clamp(upper + (lower - upper) * wp.min(fy, 1.0), -1.0, 1.0)
    turn = (float(x) + wp.min(fx, 1.0)) / float(dome.grid_width)
    around = cos_sin(turn)
    c = wp.sqrt(wp.max(0.0, 1.0 - z * z))
    direction = wp.transpose(dome.dome_from_world) * wp.vec3(c * around[0], c * around[1], z)
    cell = y * dome.grid_width + x
    radiance = wp.vec3(0.0)
    if fine:
        radiance = sky_radiance(dome, wp.vec2(turn, half_turns_from_pole(z)))
    else:
        radiance = cell_radiance(dome, cell)
    return LightSample(
        direction=direction,
        distance=FAR_AWAY,
        radiance=radiance,
        pdf=cell_density(dome, cell),
        diffuse=dome.diffuse,
        specular=dome.specular,
    )


@wp.func
def weight_at(light: Light, point: wp.vec3, normal: wp.vec3, sky_share: float):
    """About the irradiance that a light gives to a point; zero only where it gives none.

    Of what comes from beyond the scene, `sky_share` passes what stands around.
    """
    if light.kind == LIGHT_DISTANT:
        return sky_share * light.strength * wp.clamp(wp.dot(normal, light.z_axis) + light.extent, 0.0, 1.0)
    to_light = light.position - point
    e2 = light.extent * light.extent
    d2 = wp.dot(to_light, to_light)
    if d2 <= e2:
        return light.strength / e2
    per_distance = 1.0 / wp.sqrt(d2)
    slack = light.extent * per_distance
    # Outside of its cone, as seen from any of its points.
    off_axis = wp.dot(to_light, light.z_axis) * per_distance + 2.0 * slack
    if light.shaping_cos > -1.0 and off_axis <= light.shaping_cos:
        return 0.0
    facing = wp.clamp(wp.dot(normal, to_light) * per_distance + slack, 0.0, 1.0)
    if light.kind == LIGHT_RECT or light.kind == LIGHT_DISK:
        facing *= wp.clamp(wp.dot(to_light, light.z_axis) * per_distance + slack, 0.0, 1.0)
    return light.strength * facing / d2


@wp.func
def choose_light(tables: SceneTables, point: wp.vec3, normal: wp.vec3, number: float, sky_share: float):
    """One light for a point, by its share of the weights of all.

    The number decides, and what it has left (`number` of the result) is uniform again: points that are well spread
    over the square stay so within the strip of each light, which an independent number for the choice would spoil.
    """
    chosen = LightChoice()
    chosen.index = -1
    sky = tables.dome.strength * sky_share
    total = sky
    for k in range(tables.light_count):
        total += weight_at(tables.lights[k], point, normal, sky_share)
    if total <= 0.0:
        return chosen
    chosen.total = total
    at = number * total
    weight = sky
    if at < weight:
        chosen.index = tables.light_count
    else:
        at -= weight
        for k in range(tables.light_count):
            w = weight_at(tables.lights[k], point, normal, sky_share)
            if w > 0.0:
                chosen.index = k
                weight = w
                if at < w:
                    break
                at -= w
    chosen.chance = weight / total
    chosen.number = wp.min(at / weight, 0.99999994)
    return chosen


@wp.func
def sample_light(tables: SceneTables, index: int, point: wp.vec3, r: wp.vec2, fine_sky: bool):
    """A direction from `point` to the chosen light."""
    if index < 0:
        return LightSample()
    if index < tables.light_count:
        if tables.lights[index].kind == LIGHT_MESH:
            return sample_emitter(tables, tables.lights[index], point, r)
        return sample_one(tables.lights[index], point, r)
    return sample_sky(tables.dome, r, fine_sky)
