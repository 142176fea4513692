"""Motion vectors through lenses that are no pinholes.

A kernel of its own, because the way back from points to pixels would make the label pass slower for all cameras.
"""

import warp as wp

from usdsdg_render.kernels.cameras.lens import NONE, PANORAMA, project_lens, project_panorama
from usdsdg_render.kernels.labels.aov import Past, past_point, pixel_of
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.labels.views import Views, meet_centre, picture_row
from usdsdg_render.kernels.scene.visibility import triangle_of
from usdsdg_render.scene.structs import Camera, SceneTables

# What stands still has moved by exactly nothing: two places that are found by one formula are rounded alike.
wp.set_module_options({"fuse_fp": False})


@wp.func
def place_of(camera: Camera, point: wp.vec3, at_infinity: bool):
    """(column, row, 1), or (0, 0, 0) for a point that has no pixel. A direction stands for a point at infinity."""
    if camera.lens_kind == NONE:
        return pixel_of(camera, point, at_infinity)
    p = point
    if not at_infinity:
        p = point - camera.origin
    p = wp.transpose(camera.rotation) * p
    if camera.lens_kind == PANORAMA:
        # From far away, the circle that the eye goes round is a point.
        place = project_panorama(wp.where(at_infinity, 0.0, camera.lens.eye), p)
        return wp.vec3(place[0] * float(camera.width), place[1] * float(camera.height), place[2])
    q = project_lens(camera.lens, p)
    return wp.vec3(camera.cx + camera.fx * q[0], camera.cy + camera.fy * q[1], 1.0) * q[2]


@wp.kernel(enable_backward=False, module=LABELS)
def label_curved_motion(
    tables: SceneTables,
    views: Views,
    past: Past,
    mode: int,
    first_band: int,
    # out: (views, height, width); pinholes have theirs already
    motion_vectors: wp.array3d(dtype=wp.vec2),
):
    band, x, row = wp.tid()
    v, y = picture_row(views, first_band + band, row)
    if y >= views.height:
        return
    camera = views.cameras[v]
    past_camera = past.cameras[v]
    if camera.lens_kind == NONE and past_camera.lens_kind == NONE:
        return
    motion_vectors[v, y, x] = wp.vec2(0.0)
    ray, hit = meet_centre(tables, camera, x, y, mode)
    if ray.tmax < ray.tmin:
        return
    now = ray.direction
    before = ray.direction
    at_infinity = hit.instance < 0
    if not at_infinity:
        was = past.places[past.moments[v], hit.instance]
        if was.known == 0:
            return
        instance = tables.tlas.instances[hit.instance]
        triangle = triangle_of(instance, hit.triangle)
        local = triangle.p0 * (1.0 - hit.u - hit.v) + triangle.p1 * hit.u + triangle.p2 * hit.v
        now = instance.local_to_world * local + instance.world_origin
        before = past_point(was, hit, local)
    a = place_of(camera, now, at_infinity)
    b = place_of(past_camera, before, at_infinity)
    if a[2] == 0.0 or b[2] == 0.0:
        return
    moved = wp.vec2(b[0] - a[0], b[1] - a[1])
    if camera.lens_kind == PANORAMA:
        # The shorter way around.
        moved = wp.vec2(moved[0] - float(camera.width) * wp.round(moved[0] / float(camera.width)), moved[1])
    motion_vectors[v, y, x] = moved
