"""Motion vectors through lens models.

A kernel of its own, because projecting points through a lens would make the label pass slower for all cameras.
"""

import warp as wp

from usdsdg_render.kernels.cameras.lens import NONE, PANORAMA, project_lens, project_panorama
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.motion import PreviousFrame, pixel_of, previous_point
from usdsdg_render.kernels.labels.views import Views, image_row, trace_pixel_center
from usdsdg_render.kernels.scene.visibility import triangle_of
from usdsdg_render.scene.structs import Camera, SceneTables


@wp.func
def lens_pixel_of(camera: Camera, point: wp.vec3, at_infinity: bool):
    """Project a point: (column, row, 1); (0, 0, 0) if it has no pixel. A direction stands for a point at infinity."""
    if camera.lens_kind == NONE:
        return pixel_of(camera, point, at_infinity)
    p = point
    if not at_infinity:
        p = point - camera.origin
    p = wp.transpose(camera.rotation) * p
    if camera.lens_kind == PANORAMA:
        # Seen from infinity, the circle of stereo eyes is a point.
        uv = project_panorama(wp.where(at_infinity, 0.0, camera.lens.eye_offset), p)
        return wp.vec3(uv[0] * float(camera.width), uv[1] * float(camera.height), uv[2])
    q = project_lens(camera.lens, p)
    return wp.vec3(camera.cx + camera.fx * q[0], camera.cy + camera.fy * q[1], 1.0) * q[2]


@wp.kernel(enable_backward=False, module=LABELS)
def label_lens_motion(
    tables: SceneTables,
    views: Views,
    previous: PreviousFrame,
    mode: int,
    first_band: int,
    # out, except those of cameras without a lens model
    motion_vectors: wp.array3d(dtype=wp.vec2),
):
    band, x, row = wp.tid()
    v, y = image_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    previous_camera = previous.cameras[v]
    if camera.lens_kind == NONE and previous_camera.lens_kind == NONE:
        return
    motion_vectors[v, y, x] = wp.vec2(0.0)
    ray, hit = trace_pixel_center(tables, camera, x, y, mode)
    if ray.tmax < ray.tmin:
        return
    point = ray.direction
    previous_position = ray.direction
    at_infinity = hit.instance < 0
    if not at_infinity:
        previous_instance = previous.instances[previous.frames[v], hit.instance]
        if previous_instance.known == 0:
            return
        instance = tables.tlas.instances[hit.instance]
        triangle = triangle_of(instance, hit.triangle)
        local = triangle.p0 * (1.0 - hit.u - hit.v) + triangle.p1 * hit.u + triangle.p2 * hit.v
        point = instance.local_to_world * local + instance.world_origin
        previous_position = previous_point(previous_instance, hit, local)
    a = lens_pixel_of(camera, point, at_infinity)
    b = lens_pixel_of(previous_camera, previous_position, at_infinity)
    if a[2] == 0.0 or b[2] == 0.0:
        return
    moved = wp.vec2(b[0] - a[0], b[1] - a[1])
    if camera.lens_kind == PANORAMA:
        # Across the seam of the panorama the shorter of both displacements counts.
        moved = wp.vec2(moved[0] - float(camera.width) * wp.round(moved[0] / float(camera.width)), moved[1])
    motion_vectors[v, y, x] = moved
