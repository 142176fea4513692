"""Surface interaction at a hit: position, normals, material inputs, ray epsilon."""

import warp as wp

from usdsdg_render.kernels.scene.texture import channel, lookup
from usdsdg_render.kernels.scene.visibility import corner_uv, triangle_of
from usdsdg_render.scene.structs import Hit, Instance, Material, SceneTables, Triangle

# Ray epsilon: rounding error of a ray origin relative to its coordinates (three sums, half an ulp each), and of its
# transform to the frame of its instance and back, relative to the distance from there (the worst of random instances,
# with a margin of a third). Larger values are visible: where surfaces touch far from the world origin, rays would start
# inside of the neighbor.
WORLD_ERROR = wp.constant(1.8e-7)
LOCAL_ERROR = wp.constant(7.5e-7)


@wp.struct
class Surface:
    """A surface point hit by a ray; normals point to the side that the ray came from."""

    position: wp.vec3
    ray_epsilon: wp.float32  # offset of secondary rays along the geometric normal [stage units]
    geometric: wp.vec3  # normal of the triangle
    normal: wp.vec3  # interpolated normal
    horizon_normal: wp.vec3  # normal of the geometric horizon: light from below it is blocked
    terminator_offset: wp.vec3  # shadow-terminator offset, from the triangle to the smooth surface
    uv: wp.vec2
    material: wp.int32
    flipped: wp.int32  # 1 = seen from behind
    base: wp.vec3
    metallic: wp.float32
    roughness: wp.float32
    specular: wp.vec3
    clearcoat: wp.float32
    clearcoat_roughness: wp.float32
    emission: wp.vec3


@wp.func
def max_abs(v: wp.vec3):
    return wp.max(wp.max(wp.abs(v[0]), wp.abs(v[1])), wp.abs(v[2]))


@wp.func
def with_terminator_offset(
    surface: Surface, triangle: Triangle, instance: Instance, local: wp.vec3, hit: Hit, direction: wp.vec3
):
    """Add the shadow-terminator offset and the horizon normal of a smooth surface.

    At grazing light a coarse round mesh would show its facets: some are shadowed by their neighbors, others face away
    from the light before their interpolated normals do. Secondary rays therefore start on the tangent planes of the
    vertex normals (Hanika, "Hacking the Shadow Terminator", 2021), and the interpolated normal defines the horizon.
    Meshes whose normals deviate much from their shape, such as a box with smoothed edges, get neither.
    """
    flat = wp.normalize(wp.cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0))
    agreement = wp.min(wp.min(wp.dot(flat, triangle.n0), wp.dot(flat, triangle.n1)), wp.dot(flat, triangle.n2))
    trust = wp.clamp((agreement - 0.7) * 5.0, 0.0, 1.0)
    side = float(1.0)
    if surface.flipped != 0:
        side = -1.0
    a = wp.min(0.0, side * wp.dot(local - triangle.p0, triangle.n0)) * (1.0 - hit.u - hit.v)
    b = wp.min(0.0, side * wp.dot(local - triangle.p1, triangle.n1)) * hit.u
    c = wp.min(0.0, side * wp.dot(local - triangle.p2, triangle.n2)) * hit.v
    offset = triangle.n0 * a + triangle.n1 * b + triangle.n2 * c
    surface.terminator_offset = instance.local_to_world * (offset * (-side * trust))
    horizon = wp.normalize(surface.geometric * (1.0 - trust) + surface.normal * trust)
    if wp.dot(horizon, direction) < -0.05:
        surface.horizon_normal = horizon
    return surface


@wp.func
def surface_at(tables: SceneTables, hit: Hit, direction: wp.vec3):
    """Return position, normals, UV and material row of a hit; textures are read by `with_material`."""
    instance = tables.tlas.instances[hit.instance]
    triangle = triangle_of(instance, hit.triangle)
    w = 1.0 - hit.u - hit.v
    local = triangle.p0 * w + triangle.p1 * hit.u + triangle.p2 * hit.v
    to_normal = wp.transpose(instance.world_to_local)
    s = Surface()
    s.position = instance.local_to_world * local + instance.world_origin
    s.geometric = wp.normalize(to_normal * wp.cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0))
    # Only the component of world rounding along the normal can put a ray behind the surface.
    s.ray_epsilon = WORLD_ERROR * wp.dot(wp.abs(s.geometric), wp.abs(s.position))
    s.ray_epsilon += LOCAL_ERROR * max_abs(s.position - instance.world_origin)
    s.normal = wp.normalize(to_normal * (triangle.n0 * w + triangle.n1 * hit.u + triangle.n2 * hit.v))
    if wp.dot(s.normal, s.geometric) < 0.0:
        s.normal = -s.normal
    if wp.dot(s.geometric, direction) > 0.0:
        s.geometric = -s.geometric
        s.normal = -s.normal
        s.flipped = 1
    s.horizon_normal = s.geometric
    # Flat triangles, the most common ones, need no offset.
    if wp.length_sq(triangle.n1 - triangle.n0) + wp.length_sq(triangle.n2 - triangle.n0) > 1.0e-10:
        s = with_terminator_offset(s, triangle, instance, local, hit, direction)
    s.uv = corner_uv(triangle, hit.u, hit.v)
    s.material = tables.slots[instance.slot_offset + triangle.slot]
    return s


@wp.func
def color_at(tables: SceneTables, value: wp.vec3, texture: int, uv: wp.vec2):
    if texture < 0:
        return value
    rgba = lookup(tables, texture, uv)
    return wp.cw_mul(value, wp.vec3(rgba[0], rgba[1], rgba[2]))


@wp.func
def scalar_at(tables: SceneTables, value: float, texture: int, index: int, uv: wp.vec2):
    if texture < 0:
        return value
    return value * channel(lookup(tables, texture, uv), index)


@wp.func
def base_color_at(tables: SceneTables, material: Material, uv: wp.vec2):
    return color_at(tables, material.base_color, material.base_color_texture, uv)


@wp.func
def with_material(tables: SceneTables, surface: Surface, material: Material):
    """Evaluate the material's inputs, textures included, at this point."""
    uv = surface.uv
    surface.base = base_color_at(tables, material, uv)
    surface.metallic = scalar_at(tables, material.metallic, material.metallic_texture, material.metallic_channel, uv)
    surface.roughness = scalar_at(
        tables, material.roughness, material.roughness_texture, material.roughness_channel, uv
    )
    surface.specular = color_at(tables, material.specular, material.specular_texture, uv)
    surface.emission = color_at(tables, material.emission, material.emission_texture, uv)
    surface.clearcoat = material.clearcoat
    if material.clearcoat > 0.0:
        surface.clearcoat = scalar_at(
            tables, material.clearcoat, material.clearcoat_texture, material.clearcoat_channel, uv
        )
        surface.clearcoat_roughness = scalar_at(
            tables,
            material.clearcoat_roughness,
            material.clearcoat_roughness_texture,
            material.clearcoat_roughness_channel,
            uv,
        )
    return surface


@wp.func
def tangent_space_normal(tables: SceneTables, texture: int, uv: wp.vec2, scale: float):
    """Look up a normal map: return the vector in tangent space, with x and y scaled."""
    rgba = lookup(tables, texture, uv)
    return wp.vec3((rgba[0] * 2.0 - 1.0) * scale, (rgba[1] * 2.0 - 1.0) * scale, rgba[2] * 2.0 - 1.0)


@wp.func
def mapped_normal(tables: SceneTables, hit: Hit, surface: Surface, material: Material):
    """Return the normal after the material's normal maps; tangents follow the UV gradients of the mesh."""
    instance = tables.tlas.instances[hit.instance]
    triangle = triangle_of(instance, hit.triangle)
    a = triangle.uv1 - triangle.uv0
    b = triangle.uv2 - triangle.uv0
    det = a[0] * b[1] - a[1] * b[0]
    if det == 0.0:
        return surface.normal
    e1 = triangle.p1 - triangle.p0
    e2 = triangle.p2 - triangle.p0
    along_u = instance.local_to_world * ((e1 * b[1] - e2 * a[1]) / det)
    along_v = instance.local_to_world * ((e2 * a[0] - e1 * b[0]) / det)
    side = float(1.0)
    if surface.flipped != 0:
        side = -1.0
    n = surface.normal * side
    t = along_u - n * wp.dot(n, along_u)
    if wp.length_sq(t) == 0.0:
        return surface.normal
    t = wp.normalize(t)
    v = wp.cross(n, t)
    if wp.dot(v, along_v) < 0.0:
        v = -v
    tangent_normal = wp.vec3(0.0, 0.0, 1.0)
    if material.normal_texture >= 0:
        tangent_normal = tangent_space_normal(tables, material.normal_texture, surface.uv, material.normal_scale)
    if material.detail_texture >= 0:
        detail = tangent_space_normal(tables, material.detail_texture, surface.uv, material.detail_scale)
        tangent_normal += wp.vec3(detail[0], detail[1], 0.0)
    return wp.normalize(t * tangent_normal[0] + v * tangent_normal[1] + n * wp.max(tangent_normal[2], 1.0e-3)) * side


@wp.func
def ensure_valid_reflection(normal: wp.vec3, geometric: wp.vec3, wo: wp.vec3):
    """Bend the normal by the minimum for which the mirror direction of `wo` lies above the surface.

    Interpolated and mapped normals may face away from the viewer, or reflect rays into the surface; both would
    cause black spots.
    """
    mirrored = normal * (2.0 * wp.dot(normal, wo)) - wo
    limit = wp.min(0.9 * wp.dot(geometric, wo), 0.02)
    height = wp.dot(mirrored, geometric)
    if height >= limit and wp.dot(normal, wo) > 0.0:
        return normal
    flat = mirrored - geometric * height
    length = wp.length(flat)
    if length < 1.0e-6:
        return geometric
    raised = flat * (wp.sqrt(1.0 - limit * limit) / length) + geometric * limit
    return wp.normalize(wo + raised)
