"""Warp functions that solve dense rows, those of joints."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: SIM109, UP018

import warp as wp
from newton._src.solvers.steel.friction import friction_pair_candidate
from newton._src.solvers.steel.friction_patches import patch_normal_load

from usdsdg_physics.solver.sweep_arrays import CONTACT, DRIVE, JOINT_LIMIT, Rows


@wp.func
def solve_dense(
    rows: Rows,
    blocks: wp.vec4i,
    row: int,
    bias: wp.array2d[float],
    omega: float,
    impulses: wp.array2d[float],
    v: wp.array[float],
):
    """Solve a drive, a limit, a contact or an equation of joints."""
    speed = dense_speed(float(0.0), rows, row, blocks, v)
    old = impulses[0, row]
    type = rows.type[0, row]
    impulse = float(0.0)
    if type == DRIVE:
        largest = rows.drive_max_impulse[0, row]
        impulse = (
            old * rows.drive_impulse_factor[0, row]
            + speed * rows.drive_velocity_factor[0, row]
            + rows.drive_bias[0, row]
        )
        impulse = wp.min(wp.max(impulse, -largest), largest)
    else:
        impulse = old + omega * (-(speed + bias[0, row]) / rows.diagonal[0, row])
        if impulse < 0.0 and (type == CONTACT or type == JOINT_LIMIT):
            impulse = 0.0
    impulses[0, row] = impulse
    return add_dense(rows, row, blocks, impulse - old, v)


@wp.func
def solve_dense_friction(
    rows: Rows,
    blocks: wp.vec4i,
    row: int,
    cross: float,
    bias: wp.array2d[float],
    omega: float,
    impulses: wp.array2d[float],
    v: wp.array[float],
):
    """Solve the two rows of friction of a link's contact."""
    normal = rows.parent[0, row]
    sibling = normal + 2
    radius = wp.max(rows.mu[0, row] * patch_normal_load(rows.parent, impulses, 0, normal), 0.0)
    old = wp.vec2(impulses[0, row], impulses[0, sibling])
    residual = wp.vec2(
        dense_speed(float(0.0), rows, row, blocks, v) + bias[0, row],
        dense_speed(bias[0, sibling], rows, sibling, blocks, v),
    )
    impulse = friction_pair_candidate(
        rows.diagonal[0, row], cross, rows.diagonal[0, sibling], residual, old, radius, omega
    )
    length = wp.length(impulse)
    scale = float(1.0)
    if length > radius:
        scale = radius / length
    impulse = impulse * scale
    impulses[0, row] = impulse[0]
    impulses[0, sibling] = impulse[1]
    changed = add_dense(rows, sibling, blocks, impulse[1] - old[1], v)
    return wp.max(changed, add_dense(rows, row, blocks, impulse[0] - old[0], v))


@wp.func
def limit_dense(
    rows: Rows, blocks: wp.vec4i, row: int, bias: wp.array2d[float], impulses: wp.array2d[float], v: wp.array[float]
):
    """Take from an axis the speed that is above its limit."""
    residual = dense_speed(float(0.0), rows, row, blocks, v) + bias[0, row]
    impulse = float(0.0)
    if residual < 0.0:
        impulse = -residual / rows.diagonal[0, row]
    impulses[0, row] = impulse
    return add_dense(rows, row, blocks, impulse, v)


@wp.func
def clamp_dense(rows: Rows, blocks: wp.vec4i, row: int, v: wp.array[float]):
    """Take from a driven axis the speed that is above its limit."""
    largest = rows.drive_max_velocity[0, row]
    speed = dense_speed(float(0.0), rows, row, blocks, v)
    if wp.abs(speed) <= largest:
        return 0
    return add_dense(rows, row, blocks, (wp.min(wp.max(speed, -largest), largest) - speed) / rows.diagonal[0, row], v)


@wp.func
def dense_dot(start: float, rows: wp.array3d[float], row: int, blocks: wp.vec4i, others: wp.array3d[float], other: int):
    """Return `start` and the product of two rows over the degrees of freedom in the first one's blocks."""
    total = float(start)
    for d in range(blocks[0], blocks[1]):
        total += rows[0, row, d] * others[0, other, d]
    for d in range(blocks[2], blocks[3]):
        total += rows[0, row, d] * others[0, other, d]
    return total


@wp.func
def dense_speed(start: float, rows: Rows, row: int, blocks: wp.vec4i, v: wp.array[float]):
    """Return `start` and the speed of a row, from velocities `v` of its degrees of freedom."""
    total = float(start)
    for d in range(blocks[0], blocks[1]):
        total += rows.jacobian[0, row, d] * v[d]
    for d in range(blocks[2], blocks[3]):
        total += rows.jacobian[0, row, d] * v[d]
    return total


@wp.func
def add_dense(rows: Rows, row: int, blocks: wp.vec4i, impulse: float, v: wp.array[float]):
    """Add the change of velocities by an impulse; return whether it is one."""
    if impulse == 0.0:
        return 0
    for d in range(blocks[0], blocks[1]):
        v[d] = v[d] + rows.response[0, row, d] * impulse
    for d in range(blocks[2], blocks[3]):
        v[d] = v[d] + rows.response[0, row, d] * impulse
    return 1
