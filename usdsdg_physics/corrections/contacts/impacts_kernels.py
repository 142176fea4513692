"""Warp kernels over contacts: let the impulse of an impact pass through the center of mass, where that is held up."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import arm_of, body_point, point_velocity, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.corrections.contacts.contact_gaps import contact_gap, is_free, is_same_pair
from usdsdg_physics.corrections.contacts.supports_kernels import FixedShapes, is_supported

# Speed [m/s] of a center of mass toward a surface from which a contact is an impact, and that at which it is one
# fully. Bodies that tip over are slower, and what lies has the speed that gravity adds in a substep, 0.08 m/s.
MIN_SPEED = wp.constant(0.25)
FULL_SPEED = wp.constant(0.5)
# Of the arm that friction needs; without any the whole load would be on the contacts ahead, and rounding turn the body.
MARGIN = wp.constant(1.5)
# How far below the plane of a contact something holds a body up: parts of the distance between the contact and what is
# below the center of mass, and of the height of that above the plane.
SLOPE = wp.constant(0.5)
SLACK = wp.constant(0.1)
# Ratio of the distance along the plane and the height from which on a lever is long: cubes that slide against a low
# step stop there, and what has an end is turned by it. What falls needs none.
LONG = wp.constant(1.5)
# Cosine of the angle to gravity up to which a normal is that of something below.
BELOW = wp.constant(0.7)
PATCH = wp.constant(8)  # contacts of the same shapes before and after one that are taken for its patch


@wp.kernel(enable_backward=False)
def find_levers(
    # scene
    shape_body: wp.array[wp.int32],
    fixed_shapes: FixedShapes,
    contacts: ContactArrays,
    gravity: wp.array[wp.vec3],
    # body
    free: wp.array[wp.int32],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    # out
    lever: wp.array[wp.vec3],
):
    """Find about what bodies turn that hit something with an end alone, since nothing fixed is below their middle.

    `lever` (C,) is a unit vector along the plane of a contact, from below the center of mass to the middle of all
    contacts of the two shapes; zero where the body will lie on what is below its center of mass, or on something there
    and something else as far beyond it, as on slats.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    lever[contact] = wp.vec3(0.0, 0.0, 0.0)
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    if first < 0 or second < 0:
        return
    body0 = int(shape_body[first])
    body1 = int(shape_body[second])
    moves1 = is_free(body1, free)
    if is_free(body0, free) == moves1:
        return
    body = wp.where(moves1, body1, body0)
    fixed = wp.where(moves1, body0, body1)
    normal = wp.where(moves1, contacts.normal[contact], -contacts.normal[contact])
    point0 = world_point(body0, contacts.point0[contact], body_q)
    point1 = world_point(body1, contacts.point1[contact], body_q)
    arm = arm_of(body, wp.where(moves1, point1, point0), center, body_q)
    moving_arm = arm_of(fixed, wp.where(moves1, point0, point1), center, body_q)
    velocity = wp.spatial_top(body_qd[body]) - point_velocity(fixed, moving_arm, body_qd)
    tangent = arm - wp.dot(arm, normal) * normal
    center_of_mass = wp.where(moves1, point1, point0) - arm
    margin = wp.where(moves1, contacts.margin0[contact], contacts.margin1[contact])
    above = wp.dot(center_of_mass - wp.where(moves1, point0, point1), normal) - margin
    if -wp.dot(normal, velocity) <= MIN_SPEED or above <= 0.0:
        return
    falls = wp.dot(normal, gravity[0]) < -BELOW * wp.length(gravity[0])
    if not falls and wp.length(tangent) < LONG * above:
        return
    reach = (1.0 + SLACK) * above + SLOPE * wp.length(tangent)
    hit = wp.where(moves1, first, second)
    if is_supported(hit, center_of_mass, normal, reach, fixed_shapes, body_q):
        return
    if falls and is_supported(hit, center_of_mass - tangent, normal, reach, fixed_shapes, body_q):
        return

    middle = tangent
    for direction in range(2):
        step = 1 - 2 * direction
        other = contact + step
        for _ in range(PATCH):
            if other >= 0 and other < contacts.count[0] and is_same_pair(contact, other, contacts):
                local = wp.where(moves1, contacts.point1[other], contacts.point0[other])
                beside = arm_of(body, world_point(body, local, body_q), center, body_q)
                middle += beside - wp.dot(beside, normal) * normal
                other += step
    lever[contact] = wp.normalize(middle)


@wp.kernel(enable_backward=False)
def center_impacts(
    # scene
    shape_body: wp.array[wp.int32],
    restitution: wp.array[wp.float32],
    friction: wp.array[wp.float32],
    surface_velocity: wp.array[wp.vec3],
    lever: wp.array[wp.vec3],
    # body
    free: wp.array[wp.int32],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    dt: wp.float32,
    # in and out
    contacts: ContactArrays,
):
    """Move the points of a contact along its plane, to below the center of mass of the body that falls.

    That is, where exactly one of the bodies is `free`, no restitution is asked for, and the surfaces meet within `dt`
    seconds. A body that turns into the surface faster than it falls keeps that part of the arm: only a contact at that
    corner stops its turning. One that slides keeps the part that its friction needs: a contact ahead, where the impulse
    of both passes through the center of mass. One that hits an edge or a post with its end alone keeps the part along
    the `lever` about which it turns.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    if first < 0 or second < 0 or restitution[first] + restitution[second] > 0.0:
        return
    body0 = int(shape_body[first])
    body1 = int(shape_body[second])
    moves0 = is_free(body0, free)
    moves1 = is_free(body1, free)
    if moves0 == moves1:
        return
    body = wp.where(moves1, body1, body0)
    fixed = wp.where(moves1, body0, body1)
    # Points away from what is fixed.
    normal = wp.where(moves1, contacts.normal[contact], -contacts.normal[contact])
    point0 = world_point(body0, contacts.point0[contact], body_q)
    point1 = world_point(body1, contacts.point1[contact], body_q)
    gap = contact_gap(contact, point0, point1, contacts)

    arm = arm_of(body, wp.where(moves1, point1, point0), center, body_q)
    moving_arm = arm_of(fixed, wp.where(moves1, point0, point1), center, body_q)
    velocity = wp.spatial_top(body_qd[body]) - point_velocity(fixed, moving_arm, body_qd)
    fall = -wp.dot(normal, velocity)
    approach = fall - wp.dot(normal, wp.cross(wp.spatial_bottom(body_qd[body]), arm))
    if fall <= MIN_SPEED or gap > wp.max(fall, approach) * dt:
        return

    tangent = arm - wp.dot(arm, normal) * normal
    tangent -= wp.dot(tangent, lever[contact]) * lever[contact]
    slide = velocity + wp.cross(wp.spatial_bottom(body_qd[body]), arm)
    if surface_velocity:
        slide += wp.where(moves1, surface_velocity[contact], -surface_velocity[contact])
    slide -= wp.dot(slide, normal) * normal
    mu = 0.5 * (friction[first] + friction[second])
    height = -wp.dot(arm, normal)
    needed = MARGIN * height * wp.min(mu * wp.length(slide), wp.length_sq(slide) / wp.max(fall, approach))
    ahead = wp.dot(tangent, slide)
    kept = 0.0
    if ahead > 0.0:
        kept = wp.clamp(needed / ahead, 0.0, 1.0)
    share = wp.min((fall - MIN_SPEED) / (FULL_SPEED - MIN_SPEED), 1.0) * fall / wp.max(fall, approach)
    move = -share * (1.0 - kept) * tangent
    contacts.point0[contact] = body_point(body0, point0 + move, body_q)
    contacts.point1[contact] = body_point(body1, point1 + move, body_q)
