"""What the kernels of the contact solver share: bodies, pairs of bodies that touch, and rows, one for each contact."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

import warp as wp

# Pairs of one color have no moving body in common. Those that get none of the colors are solved at once, each with a
# share of the mass of its bodies.
COLORS = 32
OVERFLOW = wp.constant(COLORS)
OPEN = wp.constant(-1)  # has no color yet
# Pairs of a body and the world, of which a body has at most one.
GROUND = wp.constant(COLORS + 1)
GROUPS = wp.constant(COLORS + 2)
# Of more pairs than this, light bodies that carry heavy ones get no sweeps of their own, which others would wait for.
MOST_BURDENED = wp.constant(64)


@wp.struct
class Bodies:
    """By body; a last row is the world, which stands still."""

    center: wp.array[wp.vec3]  # of mass, world, m
    velocity: wp.array[wp.vec3]  # of the center of mass, world, m/s
    angular: wp.array[wp.vec3]  # world, rad/s
    moves: wp.array[wp.int32]  # 0 for what contacts do not move
    inverse_mass: wp.array[wp.vec3]  # along the axes of the world, 1/kg
    inverse_inertia: wp.array[wp.mat33]  # world, 1/(kg m²)
    # Of the pairs that got no color: how many a body has, and what they change, in fixed point so that the sum does not
    # depend on its order.
    overflow_count: wp.array[wp.int32]
    overflow_change: wp.array2d[wp.int64]
    burden: wp.array[wp.int32]  # not 0 of those that lie near where light ones carry heavy ones


@wp.struct
class Pairs:
    """By pair of bodies that touch; the pairs of a color, or another group, follow each other in `order`."""

    count: wp.array[wp.int32]  # (1,)
    first: wp.array[wp.int32]  # row of Bodies
    second: wp.array[wp.int32]
    begin: wp.array[wp.int32]  # first of its rows
    end: wp.array[wp.int32]
    color: wp.array[wp.int32]
    order: wp.array[wp.int32]
    group_size: wp.array[wp.int32]  # (GROUPS,)
    group_begin: wp.array[wp.int32]  # (GROUPS + 1,)
    group_filled: wp.array[wp.int32]  # (GROUPS,)
    burdened: wp.array[wp.int32]  # (1,) 0, or one more than there are pairs with `burden`
    # Those pairs by group, where there are at most MOST_BURDENED.
    burdened_size: wp.array[wp.int32]  # (GROUPS,)
    burdened_order: wp.array2d[wp.int32]  # (GROUPS, MOST_BURDENED)


@wp.struct
class Rows:
    """By contact, those of a pair after each other. Impulses act on the second body, their opposites on the first."""

    contact: wp.array[wp.int32]  # index in Newton's contacts
    normal: wp.array[wp.vec3]  # from the first body to the second, world
    tangent: wp.array[wp.vec3]  # across it, the first of two
    arm0: wp.array[wp.vec3]  # from the center of mass of the first body, m
    arm1: wp.array[wp.vec3]
    surface: wp.array[wp.vec3]  # velocity of the second surface relative to the first at which they do not rub, m/s
    distance: wp.array[wp.float32]  # negative where the surfaces overlap, m
    mass: wp.array[wp.float32]  # effective, along the normal, kg
    friction_mass: wp.array[wp.vec4]  # effective, xx, xy and yy of the two tangents, and the least along any, kg
    friction: wp.array[wp.float32]
    rebound: wp.array[wp.float32]  # speed at which an impact leaves, zero for none, m/s
    bias: wp.array[wp.float32]  # the surfaces part at minus this speed at least, m/s
    impulse: wp.array[wp.vec3]  # along the normal and the two tangents, N s
