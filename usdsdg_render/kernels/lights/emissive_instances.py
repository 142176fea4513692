"""Emissive instances as area lights: points are sampled on their triangles in proportion to emitted power."""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.lights.cdf import invert_cdf
from usdsdg_render.kernels.lights.light_shapes import LightSample
from usdsdg_render.kernels.scene.texture import lookup
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, corner_uv, opacity_of_hit, triangle_of
from usdsdg_render.scene.structs import Hit, Light, Material, SceneTables

# Shadow rays end just before the sampled point, so that its own triangle does not occlude it.
SHADOW_RAY_FRACTION = wp.constant(0.9998)


@wp.func
def is_emissive_light(tables: SceneTables, instance: int):
    """Whether an instance is sampled as a light."""
    if tables.emissive_count == 0:
        return False
    return tables.instance_light[instance] >= 0


@wp.func
def emissive_light_pdf(light: Light, material: Material, normal: wp.vec3, direction: wp.vec3, distance: float):
    """Return the pdf of `sample_emissive_light` for a point along a direction [1/sr]; both sides of a triangle emit."""
    cosine = wp.max(wp.abs(wp.dot(normal, direction)), 1.0e-6)
    return luminance(material.emission) / light.luminance_area * distance * distance / cosine


@wp.func
def sample_emissive_light(tables: SceneTables, light: Light, point: wp.vec3, r: wp.vec2):
    """Sample a direction from `point` to a point of an emissive instance."""
    s = LightSample()
    s.diffuse = 1.0
    s.specular = 1.0
    face_cdf = wp.array(ptr=light.face_cdf, shape=(light.face_count + 1,), dtype=wp.float32)
    face = invert_cdf(face_cdf, 0, light.face_count, r[0])
    remaining = wp.min((r[0] - face_cdf[face]) / wp.max(face_cdf[face + 1] - face_cdf[face], 1.0e-30), 1.0)
    # Uniform over the triangle.
    root = wp.sqrt(remaining)
    u = root * (1.0 - r[1])
    v = root * r[1]
    instance = tables.tlas.instances[light.instance]
    triangle = triangle_of(instance, face)
    p0 = instance.local_to_world * triangle.p0
    p1 = instance.local_to_world * triangle.p1
    p2 = instance.local_to_world * triangle.p2
    on_light = p0 * (1.0 - u - v) + p1 * u + p2 * v + instance.world_origin
    to_light = on_light - point
    distance = wp.length(to_light)
    normal = wp.cross(p1 - p0, p2 - p0)
    material = tables.materials[tables.slots[instance.slot_offset + triangle.slot]]
    if distance <= 0.0 or wp.length(normal) <= 0.0 or luminance(material.emission) <= 0.0:
        return s
    s.direction = to_light / distance
    s.distance = distance * SHADOW_RAY_FRACTION
    s.radiance = material.emission
    if material.emission_texture >= 0:
        rgba = lookup(tables, material.emission_texture, corner_uv(triangle, u, v))
        s.radiance = wp.cw_mul(s.radiance, wp.vec3(rgba[0], rgba[1], rgba[2]))
    if tables.cutouts != 0:
        hit = Hit(t=distance, u=u, v=v, instance=light.instance, triangle=face)
        s.radiance *= opacity_of_hit(tables, hit, BY_CHANCE)
    s.pdf = emissive_light_pdf(light, material, wp.normalize(normal), s.direction, distance)
    return s
