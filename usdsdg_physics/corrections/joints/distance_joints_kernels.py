"""Warp kernels over distance joints: the contacts and springs that stand for them."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import arm_of, point_velocity, world_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

NEAREST = wp.constant(1.0e-9)  # m; nearer points have no direction
MOVES = wp.constant(1.0e-4)  # m/s
# Parts of what would stop a mass within one step, beyond which an explicit spring and damper are not stable.
STIFFEST = wp.constant(0.25)
STRONGEST = wp.constant(0.5)


@wp.kernel(enable_backward=False)
def add_distance_contacts(
    # joint
    bodies: wp.array[wp.vec2i],
    shapes: wp.array[wp.vec2i],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    distance: wp.array[wp.vec2],
    spring: wp.array[wp.vec2],
    # body
    free: wp.array[wp.int32],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    # out
    contacts: ContactArrays,
    surface_velocity: wp.array[wp.vec3],
    touched: wp.array[wp.int32],
    rest_time: wp.array[wp.float32],
):
    """Write, after the contacts that are counted, one that keeps points together and one that keeps them apart.

    The least and the greatest `distance` [m] are margins of the contacts; the normal of the former points from point 1
    to point 0. Joints with a `spring`, whose stiffness is not negative, and limits that are none give contacts of no
    shapes.
    """
    joint = wp.tid()
    row = contacts.count[0] + 2 * joint
    if row + 1 >= contacts.shape0.shape[0]:
        return
    first = bodies[joint][0]
    second = bodies[joint][1]
    start = world_point(first, point0[joint], body_q)
    end = world_point(second, point1[joint], body_q)
    normal = end - start
    length = wp.length(normal)
    if length > NEAREST:
        normal = normal / length
    else:
        normal = wp.vec3(0.0, 0.0, 1.0)
    rigid = spring[joint][0] < 0.0
    for side in range(2):
        acts = rigid and wp.isfinite(distance[joint][1])
        margin = -distance[joint][1]
        direction = -normal
        if side == 1:
            acts = rigid and distance[joint][0] > 0.0
            margin = distance[joint][0]
            direction = normal
        contacts.shape0[row + side] = wp.where(acts, shapes[joint][0], -1)
        contacts.shape1[row + side] = wp.where(acts, shapes[joint][1], -1)
        contacts.point0[row + side] = point0[joint]
        contacts.point1[row + side] = point1[joint]
        contacts.normal[row + side] = direction
        contacts.margin0[row + side] = margin
        contacts.margin1[row + side] = 0.0
        if surface_velocity:
            surface_velocity[row + side] = wp.vec3(0.0, 0.0, 0.0)
    note_end(first, second, free, body_qd, touched, rest_time)
    note_end(second, first, free, body_qd, touched, rest_time)


@wp.func
def note_end(
    body: int,
    other: int,
    free: wp.array[wp.int32],
    body_qd: wp.array[wp.spatial_vector],
    touched: wp.array[wp.int32],
    rest_time: wp.array[wp.float32],
):
    """Let a body be touched, and not rest where the other is moved by something else than forces."""
    if body >= 0:
        touched[body] = 1
        if other >= 0:  # noqa: SIM102 (Warp evaluates both sides of `and`)
            if free[other] == 0 and wp.length(body_qd[other]) > MOVES:
                rest_time[body] = 0.0


@wp.kernel(enable_backward=False)
def count_distance_contacts(
    joints: wp.int32,
    capacity: wp.int32,
    # in and out
    count: wp.array[wp.int32],
    first: wp.array[wp.int32],
):
    """Count the contacts that were added, and note the first of them."""
    first[0] = count[0]
    count[0] = wp.min(count[0] + 2 * joints, capacity)


@wp.kernel(enable_backward=False)
def pull_springs(
    # joint
    joints: wp.int32,
    bodies: wp.array[wp.vec2i],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    distance: wp.array[wp.vec2],
    spring: wp.array[wp.vec2],
    dt: wp.float32,
    # body
    inverse_mass: wp.array[wp.float32],
    inverse_inertia: wp.array[wp.mat33],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    # out
    body_f: wp.array[wp.spatial_vector],
    force: wp.array[wp.float32],
):
    """Pull and push the ends of springs [N/m, N s/m] that are too long or too short, one after the other.

    What is stiffer than the step `dt` [s] can follow is as stiff as it can.
    """
    for joint in range(joints):
        force[joint] = 0.0
        if spring[joint][0] >= 0.0:
            first = bodies[joint][0]
            second = bodies[joint][1]
            start = world_point(first, point0[joint], body_q)
            end = world_point(second, point1[joint], body_q)
            normal = end - start
            length = wp.length(normal)
            excess = wp.max(length - distance[joint][1], 0.0) + wp.min(length - distance[joint][0], 0.0)
            if excess != 0.0 and length > NEAREST:
                normal = normal / length
                yields = inverse_of(first, start, normal, inverse_mass, inverse_inertia, center, body_q)
                yields += inverse_of(second, end, normal, inverse_mass, inverse_inertia, center, body_q)
                if yields > 0.0:
                    speed = wp.dot(
                        normal,
                        point_velocity(second, arm_of(second, end, center, body_q), body_qd)
                        - point_velocity(first, arm_of(first, start, center, body_q), body_qd),
                    )
                    stiffness = wp.min(spring[joint][0], STIFFEST / (yields * dt * dt))
                    damping = wp.min(spring[joint][1], STRONGEST / (yields * dt))
                    pull = stiffness * excess + damping * speed
                    force[joint] = wp.abs(pull)
                    push(first, start, pull * normal, center, body_q, body_f)
                    push(second, end, -pull * normal, center, body_q, body_f)


@wp.kernel(enable_backward=False)
def note_broken_distances(
    first: wp.array[wp.int32],
    spring: wp.array[wp.vec2],
    force: wp.array[wp.float32],
    break_force: wp.array[wp.float32],
    contact_force: wp.array[wp.spatial_vector],
    # out
    broken: wp.array[wp.int32],
):
    """Set `broken` of joints whose contacts, or whose spring, pull with more than their break force [N]."""
    joint = wp.tid()
    row = first[0] + 2 * joint
    load = force[joint]
    if spring[joint][0] < 0.0 and row + 1 < contact_force.shape[0]:
        load = wp.length(wp.spatial_top(contact_force[row]) + wp.spatial_top(contact_force[row + 1]))
    if load > break_force[joint]:
        broken[joint] = 1


@wp.func
def inverse_of(
    body: int,
    point: wp.vec3,
    normal: wp.vec3,
    inverse_mass: wp.array[wp.float32],
    inverse_inertia: wp.array[wp.mat33],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
):
    """Return how easily a point of a body moves along a normal [1/kg]."""
    if body < 0:
        return 0.0
    arm = arm_of(body, point, center, body_q)
    turn = wp.quat_rotate_inv(wp.transform_get_rotation(body_q[body]), wp.cross(arm, normal))
    return inverse_mass[body] + wp.dot(turn, inverse_inertia[body] * turn)


@wp.func
def push(
    body: int,
    point: wp.vec3,
    force: wp.vec3,
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_f: wp.array[wp.spatial_vector],
):
    """Add a force [N] that acts at a point of a body, both in the world, to its wrench; the world (-1) has none."""
    if body >= 0:
        arm = arm_of(body, point, center, body_q)
        body_f[body] = body_f[body] + wp.spatial_vector(force, wp.cross(arm, force))
