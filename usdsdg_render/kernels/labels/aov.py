"""Label pass: one ray through the centre of each pixel, and everything that is known about what it meets."""

import warp as wp

from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.views import Views, meet_centre, picture_row
from usdsdg_render.kernels.scene.surface import base_color_at, surface_at
from usdsdg_render.kernels.scene.visibility import corner_uv, triangle_of
from usdsdg_render.scene.structs import Camera, Hit, SceneTables


@wp.struct
class AovArrays:
    """Outputs, (views, height, width), of which every pixel is written; an empty array is not asked for."""

    instance: wp.array3d(dtype=wp.int32)
    prim: wp.array3d(dtype=wp.int32)
    barycentrics: wp.array3d(dtype=wp.vec3)
    uv: wp.array3d(dtype=wp.vec2)
    distance_to_camera: wp.array3d(dtype=wp.float32)
    distance_to_image_plane: wp.array3d(dtype=wp.float32)
    normals: wp.array3d(dtype=wp.vec3)
    position: wp.array3d(dtype=wp.vec3)
    albedo: wp.array3d(dtype=wp.vec3)
    motion_vectors: wp.array3d(dtype=wp.vec2)


@wp.struct
class Was:
    """Where an instance was at some moment."""

    known: wp.int32  # 1 = it was there
    local_to_world: wp.mat33
    world_origin: wp.vec3
    corners: wp.uint64  # where the corners of its triangles were (vec3); 0 = where they are


@wp.struct
class Past:
    """Where cameras and things were when each of the cameras last looked."""

    cameras: wp.array(dtype=Camera)
    moments: wp.array(dtype=wp.int32)  # per camera: row of `places`
    places: wp.array2d(dtype=Was)  # (moments, instances)


@wp.func
def past_point(was: Was, hit: Hit, local: wp.vec3):
    """Where in the world the point of a hit was, that is at `local` in its instance's frame now."""
    p = local
    if was.corners != wp.uint64(0):
        first = 3 * hit.triangle
        corners = wp.array(ptr=was.corners, shape=(first + 3,), dtype=wp.vec3)
        p = corners[first] * (1.0 - hit.u - hit.v) + corners[first + 1] * hit.u + corners[first + 2] * hit.v
    return was.local_to_world * p + was.world_origin


@wp.func
def pixel_of(camera: Camera, point: wp.vec3, at_infinity: bool):
    """(column, row, 1), or (0, 0, 0) for a point that has no pixel. A direction stands for a point at infinity."""
    p = point
    if not at_infinity:
        p = point - camera.origin
    p = wp.transpose(camera.rotation) * p
    if camera.orthographic != 0:
        if at_infinity:
            return wp.vec3(0.0)
        return wp.vec3(camera.cx + camera.fx * p[0], camera.cy - camera.fy * p[1], 1.0)
    if p[2] >= -1.0e-12:
        return wp.vec3(0.0)
    return wp.vec3(camera.cx - camera.fx * p[0] / p[2], camera.cy + camera.fy * p[1] / p[2], 1.0)


@wp.func
def motion(camera: Camera, past_camera: Camera, now: wp.vec3, before: wp.vec3, at_infinity: bool):
    """Pixels moved: +x to the left, +y upwards."""
    a = pixel_of(camera, now, at_infinity)
    b = pixel_of(past_camera, before, at_infinity)
    if a[2] == 0.0 or b[2] == 0.0:
        return wp.vec2(0.0)
    return wp.vec2(b[0] - a[0], b[1] - a[1])


@wp.kernel(enable_backward=False, module=LABELS)
def label_pixels(
    tables: SceneTables,
    views: Views,
    past: Past,
    meters_per_unit: float,
    mode: int,
    first_band: int,
    # out
    out: AovArrays,
):
    band, x, row = wp.tid()
    v, y = picture_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    ray, hit = meet_centre(tables, camera, x, y, mode)
    if out.instance.shape[0] > 0:
        out.instance[v, y, x] = hit.instance
    if hit.instance < 0:
        if out.prim.shape[0] > 0:
            out.prim[v, y, x] = -1
        if out.distance_to_camera.shape[0] > 0:
            out.distance_to_camera[v, y, x] = wp.inf
        if out.distance_to_image_plane.shape[0] > 0:
            out.distance_to_image_plane[v, y, x] = wp.inf
        if out.barycentrics.shape[0] > 0:
            out.barycentrics[v, y, x] = wp.vec3(0.0)
        if out.uv.shape[0] > 0:
            out.uv[v, y, x] = wp.vec2(0.0)
        if out.normals.shape[0] > 0:
            out.normals[v, y, x] = wp.vec3(0.0)
        if out.position.shape[0] > 0:
            out.position[v, y, x] = wp.vec3(0.0)
        if out.albedo.shape[0] > 0:
            out.albedo[v, y, x] = wp.vec3(0.0)
        if out.motion_vectors.shape[0] > 0:
            out.motion_vectors[v, y, x] = motion(camera, past.cameras[v], ray.direction, ray.direction, True)
        return
    if out.barycentrics.shape[0] > 0:
        out.barycentrics[v, y, x] = wp.vec3(1.0 - hit.u - hit.v, hit.u, hit.v)
    if out.prim.shape[0] + out.uv.shape[0] > 0:
        triangle = triangle_of(tables.tlas.instances[hit.instance], hit.triangle)
        if out.prim.shape[0] > 0:
            out.prim[v, y, x] = triangle.face
        if out.uv.shape[0] > 0:
            out.uv[v, y, x] = corner_uv(triangle, hit.u, hit.v)
    if out.distance_to_camera.shape[0] > 0:
        out.distance_to_camera[v, y, x] = hit.t * meters_per_unit
    if out.distance_to_image_plane.shape[0] > 0:
        back = wp.vec3(camera.rotation[0, 2], camera.rotation[1, 2], camera.rotation[2, 2])
        depth = hit.t * -wp.dot(ray.direction, back)
        if camera.lens.eye != 0.0:
            depth -= wp.dot(ray.origin - camera.origin, back)
        out.distance_to_image_plane[v, y, x] = depth * meters_per_unit
    if out.normals.shape[0] + out.position.shape[0] + out.albedo.shape[0] > 0:
        surface = surface_at(tables, hit, ray.direction)
        if out.normals.shape[0] > 0:
            out.normals[v, y, x] = surface.normal
        if out.position.shape[0] > 0:
            out.position[v, y, x] = surface.position
        if out.albedo.shape[0] > 0:
            material = tables.materials[surface.material]
            out.albedo[v, y, x] = base_color_at(tables, material, surface.uv)
    if out.motion_vectors.shape[0] > 0:
        moved = wp.vec2(0.0)
        was = past.places[past.moments[v], hit.instance]
        if was.known != 0:
            instance = tables.tlas.instances[hit.instance]
            triangle = triangle_of(instance, hit.triangle)
            local = triangle.p0 * (1.0 - hit.u - hit.v) + triangle.p1 * hit.u + triangle.p2 * hit.v
            now = instance.local_to_world * local + instance.world_origin
            before = past_point(was, hit, local)
            moved = motion(camera, past.cameras[v], now, before, False)
        out.motion_vectors[v, y, x] = moved
