"""What the solver's sweeps work on: the rows of constraints, and the units of all rows in the order of a visit."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp
from newton._src.solvers.steel import kernels as newton_kernels

CONTACT = newton_kernels.PGS_CONSTRAINT_TYPE_CONTACT
FRICTION = newton_kernels.PGS_CONSTRAINT_TYPE_FRICTION
DRIVE = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_TARGET
JOINT_LIMIT = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_LIMIT
VELOCITY_LIMIT = newton_kernels.PGS_CONSTRAINT_TYPE_JOINT_VELOCITY_LIMIT

# Kinds of units. Those of free bodies have one body that moves, or one more: two.
FREE_CONTACT = wp.constant(0)
FREE_FRICTION = wp.constant(2)
FREE_LIMIT = wp.constant(4)
DENSE_ROW = wp.constant(5)
DENSE_FRICTION = wp.constant(6)
DENSE_LIMIT = wp.constant(7)
DENSE_CLAMP = wp.constant(8)

# Where in its numbers a unit has what: first kind, row, first dofs of both bodies, and island.
AFTER_HEADER = wp.constant(5)  # 1 / diagonal of a contact, friction coefficient of friction
CONTACT_ROW = wp.constant(6)  # J of each body, then M⁻¹ Jᵀ of each
FRICTION_AXES = wp.constant(6)  # scale, larger and smaller eigenvalue, and the axis of the larger
FRICTION_PATCH = wp.constant(11)  # rows of its normals, -1 after the last
PATCH_ROWS = wp.constant(9)
FRICTION_ROWS = wp.constant(20)  # of both rows what CONTACT_ROW has
HEADER_SIZE = wp.constant(8)
# Numbers that a unit of a free row needs at most, by row; friction of two bodies has 68 for two rows.
NUMBERS_PER_FREE_ROW = 34

# Kinds of units that a step of the schedule keeps apart: four of free bodies, and the others.
KINDS = wp.constant(5)


@wp.struct
class Rows:
    """The rows of one world, as the solver has built them: dense ones of joints, sparse ones of free bodies."""

    gravity: wp.array[wp.vec3]  # m/s², of all bodies
    count: wp.array[int]  # (1,) dense rows
    type: wp.array2d[int]  # (1, M)
    parent: wp.array2d[int]  # (1, M)
    diagonal: wp.array2d[float]  # (1, M) J M⁻¹ Jᵀ
    mu: wp.array2d[float]  # (1, M)
    jacobian: wp.array3d[float]  # (1, M, D)
    response: wp.array3d[float]  # (1, M, D) M⁻¹ Jᵀ
    drive_bias: wp.array2d[float]  # (1, M), as the next three; of drives
    drive_velocity_factor: wp.array2d[float]
    drive_impulse_factor: wp.array2d[float]
    drive_max_impulse: wp.array2d[float]
    drive_max_velocity: wp.array2d[float]  # (1, M) where `clamps`
    free_count: wp.array[int]  # (1,) rows of free bodies
    free_contact_end: wp.array[int]  # (1,) where those of velocity limits begin
    free_dof_a: wp.array2d[int]  # (1, F) first of six, -1 for what does not move
    free_dof_b: wp.array2d[int]
    free_inverse_diagonal: wp.array2d[float]  # (1, F)
    free_type: wp.array2d[int]
    free_parent: wp.array2d[int]  # (1, F) of friction its normal's row, of normals the next of their patch
    free_mu: wp.array2d[float]
    free_jacobian_a: wp.array3d[float]  # (1, F, 6)
    free_jacobian_b: wp.array3d[float]
    free_response_a: wp.array3d[float]
    free_response_b: wp.array3d[float]


@wp.struct
class Islands:
    """The units of all rows in the order in which they are visited, with what is known of each island."""

    node: wp.array[int]  # (D,) body or tree of joints that a dof of the world belongs to; one of N
    dof: wp.array2d[int]  # (1, D) where the solver has the velocity of each
    velocity: wp.array[float]  # (D,) scratch of the sweeps
    count: wp.array[int]  # (1,) units
    order: wp.array[int]  # (U,) where the numbers of each begin
    active: wp.array[int]  # (U,) the same without the islands that do not change any more
    numbers: wp.array[float]
    blocks: wp.array[wp.vec4i]  # (M,) begin and end of two ranges of dofs; outside of them a dense row is zero
    changed: wp.array[int]  # (N,) whether a sweep changed something, by island
    burdened: wp.array[int]  # (N,) not 0 where a light body carries a heavy one, by island
    # Scratch.
    found: wp.array[wp.vec4i]  # (U,) kind, row, the first two nodes
    root: wp.array[int]  # (N,)
    latest: wp.array[int]  # (N,)
    before: wp.array[int]  # (U,) units that have to be visited before
    step: wp.array[int]  # (U,)
    after: wp.array[int]  # (U,) units that have to be visited after
    begin: wp.array[int]  # (KINDS U + 1,) by step and kind
