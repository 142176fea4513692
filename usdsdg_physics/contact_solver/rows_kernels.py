"""Warp kernels over rows: what each contact asks of the velocities of its bodies, and the force that this took."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018

import warp as wp

from usdsdg_physics.body_points import body_of, point_velocity, world_point
from usdsdg_physics.contact_solver.arrays import OVERFLOW, Bodies, Pairs, Rows
from usdsdg_physics.solver.rebounds_kernels import rebound_speed

# Added to each inverse effective mass [1/kg], so that rows that repeat each other share their load.
SOFTNESS = wp.constant(1.0e-6)
# Surfaces that come this near have met [m].
MEETING = wp.constant(1.0e-6)


@wp.kernel(enable_backward=False)
def prepare_rows(
    # contact
    contact_of: wp.array[wp.int32],
    pair_number: wp.array[wp.int32],
    shape0: wp.array[wp.int32],
    shape1: wp.array[wp.int32],
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    margin0: wp.array[wp.float32],
    margin1: wp.array[wp.float32],
    surface_velocity: wp.array[wp.vec3],
    # scene
    shape_body: wp.array[wp.int32],
    shape_friction: wp.array[wp.float32],
    shape_restitution: wp.array[wp.float32],
    # body
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    max_depenetration_velocity: wp.array[wp.float32],
    bodies: Bodies,
    pairs: Pairs,
    world: wp.int32,
    penetration_share: wp.float32,
    bounce_threshold: wp.float32,
    dt: wp.float32,
    step: wp.float32,
    # out
    rows: Rows,
):
    """Fill in the row of each contact; `step` is the length of the whole step of which this is a part."""
    row = wp.tid()
    if row >= row_count(pairs):
        return
    pair = pair_number[row] - 1
    first = pairs.first[pair]
    second = pairs.second[pair]
    contact = contact_of[row]
    s0 = shape0[contact]
    s1 = shape1[contact]
    body0 = body_of(s0, shape_body)
    body1 = body_of(s1, shape_body)

    # The points that touch, and the direction from the pair's first body to its second.
    n = normal[contact]
    at0 = world_point(body0, point0[contact], body_q) + margin0[contact] * n
    at1 = world_point(body1, point1[contact], body_q) - margin1[contact] * n
    distance = wp.dot(n, at1 - at0)
    surface = wp.vec3(0.0)
    if surface_velocity:
        surface = -surface_velocity[contact]
    if wp.where(body0 < 0, world, body0) != first:
        n = -n
        surface = -surface
        at0, at1 = at1, at0
        body0, body1 = body1, body0
    arm0 = wp.where(body0 < 0, wp.vec3(0.0), at0 - bodies.center[first])
    arm1 = wp.where(body1 < 0, wp.vec3(0.0), at1 - bodies.center[second])

    # What the bodies do in the direction of the contact and across it.
    t0, t1 = tangents(n)
    mass, friction_mass = effective_masses(pair, n, t0, t1, arm0, arm1, bodies, pairs)
    before = wp.dot(n, point_velocity(body1, arm1, body_qd) - point_velocity(body0, arm0, body_qd))
    approach = wp.dot(n, relative_velocity(first, second, arm0, arm1, bodies) - surface)

    # What the contact asks for: to rebound, or to come no nearer than to touch.
    rebound = float(0.0)
    if before < -bounce_threshold and (distance <= MEETING or distance + dt * approach <= MEETING):
        restitution = restitution_of(s0, s1, shape_restitution)
        if restitution > 0.0:
            center = wp.vec3(0.0)
            change = relative_velocity(first, second, center, center, bodies)
            change -= point_velocity(body1, center, body_qd) - point_velocity(body0, center, body_qd)
            pull = -wp.dot(n, change) / dt
            rebound = rebound_speed(restitution, -before, pull, wp.max(distance, 0.0), dt, step)
    bias = distance / dt
    if distance < 0.0:
        bias = wp.max(penetration_share * distance / dt, -slower(body0, body1, max_depenetration_velocity))
    # As in PhysX, what is above the surface first reaches it, and rebounds in the sweeps for velocities.
    if rebound > 0.0 and distance <= 0.0:
        bias = -rebound

    rows.contact[row] = contact
    rows.normal[row] = n
    rows.tangent[row] = t0
    rows.arm0[row] = arm0
    rows.arm1[row] = arm1
    rows.surface[row] = surface
    rows.distance[row] = distance
    rows.mass[row] = mass
    rows.friction_mass[row] = friction_mass
    rows.friction[row] = friction_of(s0, s1, shape_friction)
    rows.rebound[row] = rebound
    rows.bias[row] = bias
    rows.impulse[row] = wp.vec3(0.0)


@wp.kernel(enable_backward=False)
def ask_for_velocities(
    pair_number: wp.array[wp.int32],
    bodies: Bodies,
    pairs: Pairs,
    dt: wp.float32,
    # out
    rows: Rows,
):
    """Let each row ask for the velocity after the step, without the speed that took overlaps apart.

    Surfaces that stay apart may go on approaching.
    """
    row = wp.tid()
    if row >= row_count(pairs):
        return
    if rows.rebound[row] > 0.0:
        rows.bias[row] = -rows.rebound[row]
        return
    pair = pair_number[row] - 1
    velocity = relative_velocity(pairs.first[pair], pairs.second[pair], rows.arm0[row], rows.arm1[row], bodies)
    approach = wp.dot(rows.normal[row], velocity - rows.surface[row])
    distance = rows.distance[row]
    bias = float(0.0)
    if distance > 0.0 and distance + dt * approach > MEETING:
        bias = distance / dt
    rows.bias[row] = bias


@wp.kernel(enable_backward=False)
def report_forces(
    shape0: wp.array[wp.int32],
    shape_body: wp.array[wp.int32],
    pair_number: wp.array[wp.int32],
    pairs: Pairs,
    rows: Rows,
    world: wp.int32,
    dt: wp.float32,
    # out
    forces: wp.array[wp.spatial_vector],
):
    """Give the force [N] of each contact on its first shape."""
    row = wp.tid()
    if row >= row_count(pairs):
        return
    contact = rows.contact[row]
    body = body_of(shape0[contact], shape_body)
    n = rows.normal[row]
    t0, t1 = tangents(n)
    impulse = rows.impulse[row]
    force = (impulse[0] * n + impulse[1] * t0 + impulse[2] * t1) / dt
    if wp.where(body < 0, world, body) == pairs.first[pair_number[row] - 1]:
        force = -force
    forces[contact] = wp.spatial_vector(force, wp.vec3(0.0))


@wp.func
def row_count(pairs: Pairs):
    """Return how many rows all pairs have."""
    count = pairs.count[0]
    if count == 0:
        return 0
    return int(pairs.end[count - 1])


@wp.func
def effective_masses(
    pair: int, n: wp.vec3, t0: wp.vec3, t1: wp.vec3, arm0: wp.vec3, arm1: wp.vec3, bodies: Bodies, pairs: Pairs
):
    """Return the mass [kg] that a pair's bodies have along `n`, where arms [m] lead to, and that across it.

    The latter is `friction_mass` of `Rows`. Of the pairs that got no color, each has a share of its bodies' mass.
    """
    first = pairs.first[pair]
    second = pairs.second[pair]
    share0 = float(1.0)
    share1 = float(1.0)
    if pairs.color[pair] == OVERFLOW:
        share0 = float(bodies.overflow_count[first])
        share1 = float(bodies.overflow_count[second])
    linear = share0 * bodies.inverse_mass[first] + share1 * bodies.inverse_mass[second]
    inertia0 = share0 * bodies.inverse_inertia[first]
    inertia1 = share1 * bodies.inverse_inertia[second]
    a0 = wp.cross(arm0, n)
    a1 = wp.cross(arm1, n)
    mass = 1.0 / (along(n, n, linear) + SOFTNESS + wp.dot(a0, inertia0 * a0) + wp.dot(a1, inertia1 * a1))
    x0 = wp.cross(arm0, t0)
    x1 = wp.cross(arm1, t0)
    y0 = wp.cross(arm0, t1)
    y1 = wp.cross(arm1, t1)
    xx = along(t0, t0, linear) + SOFTNESS + wp.dot(x0, inertia0 * x0) + wp.dot(x1, inertia1 * x1)
    yy = along(t1, t1, linear) + SOFTNESS + wp.dot(y0, inertia0 * y0) + wp.dot(y1, inertia1 * y1)
    xy = along(t0, t1, linear) + wp.dot(x0, inertia0 * y0) + wp.dot(x1, inertia1 * y1)
    determinant = xx * yy - xy * xy
    least = 2.0 / (xx + yy + wp.sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy))
    friction_mass = wp.vec4(yy / determinant, -xy / determinant, xx / determinant, least)
    if determinant <= 1.0e-6 * xx * yy:
        friction_mass = wp.vec4(least, 0.0, least, least)
    return mass, friction_mass


@wp.func
def along(a: wp.vec3, b: wp.vec3, inverse_mass: wp.vec3):
    """Return the part of an inverse mass that couples two directions."""
    return wp.dot(a, wp.cw_mul(inverse_mass, b))


@wp.func
def tangents(n: wp.vec3):
    """Return two directions across `n` and each other."""
    t0 = wp.cross(n, wp.vec3(1.0, 0.0, 0.0))
    if wp.abs(n[0]) > 0.9:
        t0 = wp.cross(n, wp.vec3(0.0, 1.0, 0.0))
    t0 = wp.normalize(t0)
    return t0, wp.cross(n, t0)


@wp.func
def relative_velocity(first: int, second: int, arm0: wp.vec3, arm1: wp.vec3, bodies: Bodies):
    """Return the velocity [m/s] of a point of the second body relative to one of the first."""
    return (bodies.velocity[second] + wp.cross(bodies.angular[second], arm1)) - (
        bodies.velocity[first] + wp.cross(bodies.angular[first], arm0)
    )


@wp.func
def slower(body0: int, body1: int, max_depenetration_velocity: wp.array[wp.float32]):
    """Return the smaller of the speeds [m/s] at which two bodies, or the world (-1), may be pushed apart.

    A speed of zero is no limit.
    """
    limit = float(1.0e20)
    if body0 >= 0 and max_depenetration_velocity[body0] > 0.0:
        limit = wp.min(limit, max_depenetration_velocity[body0])
    if body1 >= 0 and max_depenetration_velocity[body1] > 0.0:
        limit = wp.min(limit, max_depenetration_velocity[body1])
    return limit


@wp.func
def friction_of(s0: int, s1: int, shape_friction: wp.array[wp.float32]):
    """Return the mean of two shapes' friction."""
    if s0 < 0 and s1 < 0:
        return 0.0
    if s0 < 0:
        return shape_friction[s1]
    if s1 < 0:
        return shape_friction[s0]
    return 0.5 * (shape_friction[s0] + shape_friction[s1])


@wp.func
def restitution_of(s0: int, s1: int, shape_restitution: wp.array[wp.float32]):
    """Return the mean of two shapes' restitution."""
    if s0 < 0 or s1 < 0:
        return 0.0
    return 0.5 * (wp.clamp(shape_restitution[s0], 0.0, 1.0) + wp.clamp(shape_restitution[s1], 0.0, 1.0))
