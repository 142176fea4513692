"""Octagons around what each instance can cover in the picture of a camera without a lens.

The planes through the eye that touch an instance cut the picture in its tangents. Points of it reach
f(c) = max(aX + bY - cZ) beyond the line aX/Z + bY/Z = c; f falls with c, by no less than the least depth of the
instance and no more than the largest, and bends upwards. So a secant through two points before the tangent ends before
it, too, and what is left from there is at most f(c) over the least depth.
"""

import warp as wp

from usdsdg_render.kernels.cameras.camera import Camera
from usdsdg_render.kernels.labels.label_module import LABELS
from usdsdg_render.kernels.scene.reach import Supports, farthest, reach_from
from usdsdg_render.scene.structs import Instance, SceneTables

# Sides of an octagon: outwards, in columns and rows.
SIDES = wp.constant(8)
# Pixels around what is found, for rounding.
MARGIN = wp.constant(1.0)
# Lines that are tried across a picture where there is no tangent.
ROUGHLY = wp.constant(33)
NOWHERE = wp.constant(-1.0e30)
ANYWHERE = wp.constant(1.0e30)


@wp.func
def side_normal(side: int):
    """(1, 0), (0, 1), (1, 1), (1, -1), and their opposites."""
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
def tangent(
    supports: Supports,
    instance: Instance,
    index: int,
    camera: Camera,
    normal: wp.vec2,
    least: float,
    most: float,
    largest: float,
):
    """Where the tangent lies [pixels from the optical axis], or a little beyond, of an instance with these depths."""
    place = float(0.0)
    before = float(0.0)
    left_before = float(0.0)
    steps = int(4)
    for step in range(steps):
        towards = camera.rotation * wp.vec3(normal[0] * camera.fx, -normal[1] * camera.fy, place)  # depth is -z
        left = reach_from(supports, instance, index, towards, camera.origin, largest)
        now = place
        if camera.orthographic != 0:
            return left
        if step == 0:
            if left > 0.0:
                place = left / most
            else:
                place = left / least
        elif step == 1:
            place = now + left / most
        elif step == 2:
            slope = (left_before - left) / wp.max(now - before, 1.0e-30)
            place = now + left / wp.clamp(slope, least, most)
        else:
            place = now + wp.max(left, 0.0) / least
        before = now
        left_before = left
    return place


@wp.func
def beside(supports: Supports, instance: Instance, index: int, camera: Camera, normal: wp.vec2, largest: float):
    """As `tangent`, roughly, of what may reach behind the camera: a line that it is wholly on one side of, if any."""
    # From the corner of the picture that lies farthest along the normal to the opposite one.
    middle = wp.vec2(0.5 * float(camera.width) - camera.cx, 0.5 * float(camera.height) - camera.cy)
    half = 0.5 * (wp.abs(normal[0]) * float(camera.width) + wp.abs(normal[1]) * float(camera.height))
    highest = wp.dot(normal, middle) + half
    end = float(ANYWHERE)
    for k in range(ROUGHLY):
        place = highest - 2.0 * half * float(k) / float(ROUGHLY - 1)
        towards = camera.rotation * wp.vec3(normal[0] * camera.fx, -normal[1] * camera.fy, place)
        if reach_from(supports, instance, index, towards, camera.origin, largest) <= 0.0:
            end = place
    return end


@wp.kernel(enable_backward=False, module=LABELS)
def draw_octagons(
    tables: SceneTables,
    supports: Supports,
    cameras: wp.array(dtype=Camera),
    tested: wp.array(dtype=wp.int32),  # instances, or -1 for none
    first_view: int,
    # out, (views, tested, SIDES): how far it may reach towards each side [pixels]
    ends: wp.array3d(dtype=wp.float32),
):
    v, k = wp.tid()
    v += first_view
    camera = cameras[v]
    sides = int(SIDES)
    index = tested[k]
    if index < 0:
        for side in range(sides):
            ends[v, k, side] = NOWHERE
        return
    instance = tables.tlas.instances[index]
    largest = farthest(supports, instance, index, camera.origin)
    back = camera.rotation * wp.vec3(0.0, 0.0, 1.0)
    deepest = reach_from(supports, instance, index, -back, camera.origin, largest)
    nearest = -reach_from(supports, instance, index, back, camera.origin, largest)
    around = nearest <= wp.max(camera.near * 0.5, 1.0e-12) and camera.orthographic == 0
    for side in range(sides):
        normal = side_normal(side)
        end = float(NOWHERE)
        if deepest >= camera.near * 0.999 and nearest <= camera.far * 1.001:
            if around:
                end = beside(supports, instance, index, camera, normal, largest)
            else:
                most = wp.max(deepest, nearest)
                end = tangent(supports, instance, index, camera, normal, nearest, most, largest)
            end += wp.dot(normal, wp.vec2(camera.cx, camera.cy)) + MARGIN
        ends[v, k, side] = end
