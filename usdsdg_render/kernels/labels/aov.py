"""AOVs of the ray through the center of each pixel: identity and position of its hit, depth, normal and motion."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportReturnType=false

import warp as wp

from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.kernels.labels.aov_table import HIT, MOTION, PIXEL, SURFACE, aov
from usdsdg_render.kernels.labels.distance import distance_of, is_large
from usdsdg_render.kernels.labels.motion import PreviousFrame, motion, previous_point
from usdsdg_render.kernels.scene.surface import Surface, base_color_at
from usdsdg_render.kernels.scene.visibility import corner_uv, triangle_of
from usdsdg_render.scene.structs import Camera, Hit, SceneTables


@aov(PIXEL, miss=-1)
def instance(hit: Hit, first_instance: int) -> wp.int32:
    """Index into WarpRenderer.gprims."""
    if hit.instance < 0:
        return -1
    return hit.instance - first_instance


@aov(HIT, miss=-1)
def prim(tables: SceneTables, hit: Hit) -> wp.int32:
    """Face of the source mesh; for other shapes, of the mesh that they are tessellated to."""
    return triangle_of(tables.tlas.instances[hit.instance], hit.triangle).face


@aov(HIT, miss=-1)
def triangle(hit: Hit) -> wp.int32:
    """Triangle of the mesh that the gprim is drawn as."""
    return hit.triangle


@aov(HIT)
def local_position(tables: SceneTables, hit: Hit) -> wp.vec3:
    """Point in the gprim's own frame."""
    corners = triangle_of(tables.tlas.instances[hit.instance], hit.triangle)
    return corners.p0 * (1.0 - hit.u - hit.v) + corners.p1 * hit.u + corners.p2 * hit.v


@aov(HIT)
def barycentrics(hit: Hit) -> wp.vec3:
    """Weights of the corners of the triangle, which sum to 1."""
    return wp.vec3(1.0 - hit.u - hit.v, hit.u, hit.v)


@aov(HIT)
def uv(tables: SceneTables, hit: Hit) -> wp.vec2:
    """Texture coordinates of the surface, before UV transforms of textures."""
    return corner_uv(triangle_of(tables.tlas.instances[hit.instance], hit.triangle), hit.u, hit.v)


@aov(HIT, miss=wp.inf)
def distance_to_camera(tables: SceneTables, camera: Camera, ray: Ray, hit: Hit, meters_per_unit: float) -> wp.float32:
    """Distance from the camera's center [m]; along its axis for an orthographic one, negative behind it."""
    distance = distance_of(tables, ray, hit)
    if camera.near < 0.0:  # the rays of an orthographic camera start there
        return (distance + camera.near) * meters_per_unit
    return distance * meters_per_unit


@aov(HIT, miss=wp.inf)
def distance_to_image_plane(
    tables: SceneTables, camera: Camera, ray: Ray, hit: Hit, meters_per_unit: float
) -> wp.float32:
    """Distance along the optical axis [m]."""
    back = wp.vec3(camera.rotation[0, 2], camera.rotation[1, 2], camera.rotation[2, 2])
    depth = distance_of(tables, ray, hit) * -wp.dot(ray.direction, back)
    if camera.lens.eye_offset != 0.0 or camera.near < 0.0:
        depth -= wp.dot(ray.origin - camera.origin, back)
    return depth * meters_per_unit


@aov(SURFACE)
def normals(surface: Surface) -> wp.vec3:
    """Interpolated normal in world space, toward the camera."""
    return surface.normal


@aov(SURFACE)
def position(tables: SceneTables, ray: Ray, hit: Hit, surface: Surface) -> wp.vec3:
    """Point in world space [stage units]."""
    if is_large(tables, ray, hit):
        return ray.origin + ray.direction * distance_of(tables, ray, hit)
    return surface.position


@aov(SURFACE)
def albedo(tables: SceneTables, surface: Surface) -> wp.vec3:
    """Base color, linear Rec. 709."""
    material = tables.materials[surface.material]
    return base_color_at(tables, material, surface.uv)


@aov(MOTION)
def motion_vectors(tables: SceneTables, camera: Camera, ray: Ray, hit: Hit, previous: PreviousFrame, v: int) -> wp.vec2:
    """Pixels since the previous frame of this camera: +x moved left, +y moved up. See `lens_motion` for lenses."""
    if hit.instance < 0:
        return motion(camera, previous.cameras[v], ray.direction, ray.direction, True)
    previous_instance = previous.instances[previous.frames[v], hit.instance]
    if previous_instance.known == 0:
        return wp.vec2(0.0)
    instance_now = tables.tlas.instances[hit.instance]
    triangle = triangle_of(instance_now, hit.triangle)
    local = triangle.p0 * (1.0 - hit.u - hit.v) + triangle.p1 * hit.u + triangle.p2 * hit.v
    point = instance_now.local_to_world * local + instance_now.world_origin
    return motion(camera, previous.cameras[v], point, previous_point(previous_instance, hit, local), False)
