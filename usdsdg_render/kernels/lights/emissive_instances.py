"""Glowing instances as lights: a point is drawn on their triangles, by how much light each gives off."""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.lights.cdf import invert_cdf
from usdsdg_render.kernels.lights.light_shapes import LightSample
from usdsdg_render.kernels.scene.texture import lookup
from usdsdg_render.kernels.scene.visibility import BY_CHANCE, corner_uv, opacity_of_hit, triangle_of
from usdsdg_render.scene.structs import Hit, Light, Material, SceneTables

# A shadow ray ends before the point that it goes to, so that its own triangle is not in the way.
ALMOST = wp.constant(0.9998)


@wp.func
def is_emitter(tables: SceneTables, instance: int):
    """Whether an instance is drawn from as a light."""
    if tables.emitter_count == 0:
        return False
    return tables.instance_light[instance] >= 0


@wp.func
def emitter_density(light: Light, material: Material, normal: wp.vec3, direction: wp.vec3, distance: float):
    """Density with which `sample_emitter` finds a point of the light along a direction [1/sr]; both sides glow."""
    cosine = wp.max(wp.abs(wp.dot(normal, direction)), 1.0e-6)
    return luminance(material.emission) / light.glow * distance * distance / cosine


@wp.func
def sample_emitter(tables: SceneTables, light: Light, point: wp.vec3, r: wp.vec2):
    """A direction from `point` to a point of a glowing instance."""
    s = LightSample()
    s.diffuse = 1.0
    s.specular = 1.0
    shares = wp.array(ptr=light.faces, shape=(light.face_count + 1,), dtype=wp.float32)
    face = invert_cdf(shares, 0, light.face_count, r[0])
    left = wp.min((r[0] - shares[face]) / wp.max(shares[face + 1] - shares[face], 1.0e-30), 1.0)
    # Uniform over the triangle.
    along = wp.sqrt(left)
    u = along * (1.0 - r[1])
    v = along * r[1]
    instance = tables.tree.instances[light.instance]
    triangle = triangle_of(instance, face)
    p0 = instance.local_to_world * triangle.p0
    p1 = instance.local_to_world * triangle.p1
    p2 = instance.local_to_world * triangle.p2
    at = p0 * (1.0 - u - v) + p1 * u + p2 * v + instance.world_origin
    across = at - point
    distance = wp.length(across)
    normal = wp.cross(p1 - p0, p2 - p0)
    material = tables.materials[tables.slots[instance.slot_offset + triangle.slot]]
    if distance <= 0.0 or wp.length(normal) <= 0.0 or luminance(material.emission) <= 0.0:
        return s
    s.direction = across / distance
    s.distance = distance * ALMOST
    s.radiance = material.emission
    if material.emission_texture >= 0:
        rgba = lookup(tables, material.emission_texture, corner_uv(triangle, u, v))
        s.radiance = wp.cw_mul(s.radiance, wp.vec3(rgba[0], rgba[1], rgba[2]))
    if tables.cutouts != 0:
        hit = Hit(t=distance, u=u, v=v, instance=light.instance, triangle=face)
        s.radiance *= opacity_of_hit(tables, hit, BY_CHANCE)
    s.pdf = emitter_density(light, material, wp.normalize(normal), s.direction, distance)
    return s
