"""Screen bounds of instances for cameras without a lens model: 8-DOPs (octagons with sides in fixed directions).

Planes through the eye that touch an instance intersect the image in its tangent lines. The signed distance
f(c) = max(aX + bY - cZ) of its points from the plane of the line aX/Z + bY/Z = c decreases with c, by no less than the
smallest depth of the instance and no more than the largest, and is convex. So a secant through two values before the
root ends before it, too, and from there the root is at most f(c) over the smallest depth away.
"""

import warp as wp

from usdsdg_render.kernels.cameras.camera import Camera
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.scene.support_function import SupportFunctions, coordinate_bound, support_from
from usdsdg_render.kernels.scene.worlds import in_world
from usdsdg_render.scene.structs import Instance, SceneTables

# Sides of an 8-DOP; their normals point outwards, in columns and rows.
SIDES = wp.constant(8)
# Pixels added on each side, for rounding.
MARGIN = wp.constant(1.0)
# Lines tested across the image for instances without a tangent line: those that reach behind the camera.
TESTED_LINES = wp.constant(33)
# Offsets of sides: of an instance that no pixel shows, and of an unbounded one.
NOWHERE = wp.constant(-1.0e30)
ANYWHERE = wp.constant(1.0e30)


@wp.func
def side_normal(side: int):
    """Return the normal of a side: (1, 0), (0, 1), (1, 1), (1, -1), or their opposites."""
    k = side % 4
    normal = wp.vec2(1.0, 0.0)
    if k == 1:
        normal = wp.vec2(0.0, 1.0)
    elif k == 2:
        normal = wp.vec2(1.0, 1.0)
    elif k == 3:
        normal = wp.vec2(1.0, -1.0)
    if side > 3:
        normal = -normal
    return normal


@wp.func
def tangent_offset(
    supports: SupportFunctions,
    instance: Instance,
    index: int,
    camera: Camera,
    normal: wp.vec2,
    min_depth: float,
    max_depth: float,
    largest: float,
):
    """Return the offset of the tangent line [pixels from the principal point], rounded up.

    The instance is entirely in front of the camera, at depths from `min_depth` to `max_depth`.
    """
    offset = float(0.0)
    before = float(0.0)
    previous_distance = float(0.0)
    steps = int(4)
    for step in range(steps):
        toward = camera.rotation * wp.vec3(normal[0] * camera.fx, -normal[1] * camera.fy, offset)  # depth is -z
        distance = support_from(supports, instance, index, toward, camera.origin, largest)
        now = offset
        if camera.orthographic != 0:
            return distance
        if step == 0:
            if distance > 0.0:
                offset = distance / max_depth
            else:
                offset = distance / min_depth
        elif step == 1:
            offset = now + distance / max_depth
        elif step == 2:
            slope = (previous_distance - distance) / wp.max(now - before, 1.0e-30)
            offset = now + distance / wp.clamp(slope, min_depth, max_depth)
        else:
            offset = now + wp.max(distance, 0.0) / min_depth
        before = now
        previous_distance = distance
    return offset


@wp.func
def separating_offset(
    supports: SupportFunctions, instance: Instance, index: int, camera: Camera, normal: wp.vec2, largest: float
):
    """Return a coarse bound for an instance that may reach behind the camera: a line with all of it on one side."""
    # From the corner of the image that lies farthest along the normal to the opposite one.
    middle = wp.vec2(0.5 * float(camera.width) - camera.cx, 0.5 * float(camera.height) - camera.cy)
    half = 0.5 * (wp.abs(normal[0]) * float(camera.width) + wp.abs(normal[1]) * float(camera.height))
    highest = wp.dot(normal, middle) + half
    bound = float(ANYWHERE)
    for k in range(TESTED_LINES):
        offset = highest - 2.0 * half * float(k) / float(TESTED_LINES - 1)
        toward = camera.rotation * wp.vec3(normal[0] * camera.fx, -normal[1] * camera.fy, offset)
        if support_from(supports, instance, index, toward, camera.origin, largest) <= 0.0:
            bound = offset
    return bound


@wp.kernel(enable_backward=False, module=LABELS)
def bound_on_screen(
    tables: SceneTables,
    supports: SupportFunctions,
    cameras: wp.array(dtype=Camera),
    tested: wp.array(dtype=wp.int32),  # instances, or -1 for none
    first_view: int,
    # out, (views, tested, SIDES): offsets of the sides [pixels]
    bounds: wp.array3d(dtype=wp.float32),
):
    v, k = wp.tid()
    v += first_view
    camera = cameras[v]
    sides = int(SIDES)
    index = tested[k]
    if index < 0:
        for side in range(sides):
            bounds[v, k, side] = NOWHERE
        return
    tables = in_world(tables, camera.world)
    instance = tables.tlas.instances[tables.first_instance + index]
    largest = coordinate_bound(supports, instance, index, camera.origin)
    back = camera.rotation * wp.vec3(0.0, 0.0, 1.0)
    deepest = support_from(supports, instance, index, -back, camera.origin, largest)
    nearest = -support_from(supports, instance, index, back, camera.origin, largest)
    around = nearest <= wp.max(camera.near * 0.5, 1.0e-12) and camera.orthographic == 0
    for side in range(sides):
        normal = side_normal(side)
        bound = float(NOWHERE)
        near = camera.near - 1.0e-3 * wp.abs(camera.near)
        if deepest >= near and nearest <= camera.far + 1.0e-3 * wp.abs(camera.far):
            if around:
                bound = separating_offset(supports, instance, index, camera, normal, largest)
            else:
                max_depth = wp.max(deepest, nearest)
                bound = tangent_offset(supports, instance, index, camera, normal, nearest, max_depth, largest)
            bound += wp.dot(normal, wp.vec2(camera.cx, camera.cy)) + MARGIN
        bounds[v, k, side] = bound
