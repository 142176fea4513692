"""Lines of sight: the first surface on given rays, and where points of surfaces are in the image of a camera."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import Ray, camera_ray
from usdsdg_render.kernels.labels.distance import distance_of
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.lens_motion import lens_pixel_of
from usdsdg_render.kernels.scene.visibility import closest, triangle_of
from usdsdg_render.scene.structs import Camera, SceneTables

# Part of its distance by which a surface must be before a point to hide it, for rounding.
SLACK = wp.constant(1.0e-4)

# What becomes of a point of a surface.
NOT_IN_IMAGE = wp.constant(0)
HIDDEN = wp.constant(1)
VISIBLE = wp.constant(2)


@wp.kernel(enable_backward=False, module=LABELS)
def trace_rays(
    tables: SceneTables,
    origins: wp.array(dtype=wp.vec3),
    directions: wp.array(dtype=wp.vec3),  # unit vectors
    first_distance: wp.array(dtype=wp.float32),
    last_distance: wp.array(dtype=wp.float32),
    mode: int,
    first_ray: int,
    # out: of the first hit between the two distances
    distance: wp.array(dtype=wp.float32),  # inf for none
    instance: wp.array(dtype=wp.int32),  # -1 for none
    triangle: wp.array(dtype=wp.int32),
):
    i = wp.tid()
    i += first_ray
    ray = Ray(origin=origins[i], direction=directions[i], tmin=first_distance[i], tmax=last_distance[i])
    hit = closest(tables, ray.origin, ray.direction, ray.tmin, ray.tmax, mode, 0.5)
    instance[i] = hit.instance
    triangle[i] = hit.triangle
    distance[i] = wp.inf
    if hit.instance >= 0:
        distance[i] = distance_of(tables, ray, hit)


@wp.kernel(enable_backward=False, module=LABELS)
def follow_points(
    tables: SceneTables,
    cameras: wp.array(dtype=Camera),  # one
    instances: wp.array2d(dtype=wp.int32),  # of each point; -1 for none
    triangles: wp.array2d(dtype=wp.int32),
    barycentrics: wp.array2d(dtype=wp.vec3),
    mode: int,
    first_row: int,
    # out
    pixels: wp.array2d(dtype=wp.vec2),  # column and row; NaN for none
    states: wp.array2d(dtype=wp.uint8),
):
    y, x = wp.tid()
    y += first_row
    pixels[y, x] = wp.vec2(wp.nan, wp.nan)
    states[y, x] = wp.uint8(NOT_IN_IMAGE)
    index = instances[y, x]
    if index < 0:
        return
    camera = cameras[0]
    instance = tables.tlas.instances[index]
    corners = triangle_of(instance, triangles[y, x])
    weights = barycentrics[y, x]
    local = corners.p0 * weights[0] + corners.p1 * weights[1] + corners.p2 * weights[2]
    point = instance.local_to_world * local + instance.world_origin
    at = lens_pixel_of(camera, point, False)
    if at[2] == 0.0:
        return
    pixels[y, x] = wp.vec2(at[0], at[1])
    if at[0] < 0.0 or at[1] < 0.0 or at[0] >= float(camera.width) or at[1] >= float(camera.height):
        return
    ray = camera_ray(camera, at[0], at[1], wp.vec2(0.0))
    distance = wp.length(point - ray.origin)
    if distance <= ray.tmin or distance >= ray.tmax:
        return
    direction = (point - ray.origin) / distance
    hit = closest(tables, ray.origin, direction, ray.tmin, distance * (1.0 - SLACK), mode, 0.5)
    same = hit.instance == index and hit.triangle == triangles[y, x]
    states[y, x] = wp.uint8(wp.where(hit.instance < 0 or same, VISIBLE, HIDDEN))
