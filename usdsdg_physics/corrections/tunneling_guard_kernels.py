"""Warp kernel over contacts: which side of a static box a body is pushed to."""
# ruff: noqa: UP018, RUF046

from __future__ import annotations

import warp as wp

# A remembered face shares one integer with the step in which it was last touched.
FACES = wp.constant(8)
# Contacts flicker: a face is forgotten after this many steps without one.
MEMORY = wp.constant(4)
# Depth [m] from which a push along the surface means a body inside the box, not one that slides over its edge.
DEEP = wp.constant(0.01)
LEAST_DEPTH = wp.constant(0.02)  # m
# A wall wins against what squeezes a body into it: beyond the slop, depths count this much more.
SLOP = wp.constant(0.002)  # m
HARDER = wp.constant(2.0)


@wp.kernel
def keep_sides(
    # scene
    box_row: wp.array[wp.int32],
    half_extent: wp.array[wp.vec3],
    shape_transform: wp.array[wp.transform],
    shape_body: wp.array[wp.int32],
    shape_center: wp.array[wp.vec3],
    # body
    body_q: wp.array[wp.transform],
    placed: wp.array[wp.int32],
    # contact
    count: wp.array[wp.int32],
    shape0: wp.array[wp.int32],
    shape1: wp.array[wp.int32],
    margin0: wp.array[wp.float32],
    margin1: wp.array[wp.float32],
    step: wp.int32,
    # out
    point0: wp.array[wp.vec3],
    point1: wp.array[wp.vec3],
    normal: wp.array[wp.vec3],
    side: wp.array2d[wp.int32],
):
    """Turn contacts round that would push a convex shape out of a static box on the wrong side.

    The narrow phase takes the shortest way out. For a shape more than half way into a wall that leads through the
    wall, for one that slides down a wall into the seam with the floor it leads into the seam. Here the face on which
    the contact began stays the exit: the one that the shape's centre is straight above, or, when its body was placed
    since the last step, the one on whose side the body's origin is. `side[row, shape]` holds step * FACES + face for
    each static box (`box_row`) and shape; `shape_center` is in the body's frame.
    """
    contact = wp.tid()
    if contact >= count[0]:
        return
    box = int(shape0[contact])
    shape = int(shape1[contact])
    towards = float(1.0)
    if box < 0 or shape < 0:
        return
    if box_row[box] < 0:
        box = int(shape1[contact])
        shape = int(shape0[contact])
        towards = float(-1.0)
    row = box_row[box]
    body = shape_body[shape]
    if row < 0 or body < 0:
        return

    # Points of a static shape are given in the world; spheres and capsules give their axis and a margin.
    to_world = shape_transform[box]
    to_box = wp.transform_inverse(to_world)
    pose = body_q[body]
    on_shape = wp.transform_point(pose, wp.where(towards > 0.0, point1[contact], point0[contact]))
    on_box = wp.where(towards > 0.0, point0[contact], point1[contact])
    push = wp.transform_vector(to_box, towards * normal[contact])
    depth = wp.dot(towards * normal[contact], on_box - on_shape) + margin0[contact] + margin1[contact]
    center = wp.transform_point(pose, shape_center[shape])

    # The face to leave by.
    above = face_below(wp.transform_point(to_box, center), half_extent[box])
    face = int(face_along(push))
    known = side[row, shape]
    if known >= 0 and step - known / FACES <= MEMORY:
        known = known % FACES
        if above == known or depth > DEEP or wp.dot(push, face_normal(known)) < -0.5:
            face = known
    elif placed[body] != 0:
        origin = wp.transform_point(to_box, wp.transform_get_translation(pose))
        face = face_towards(origin, half_extent[box], face)
    elif above >= 0:
        face = above
    side[row, shape] = step * FACES + face

    out = face_normal(face)
    along = wp.dot(push, out)
    if along < -0.5 or (along < 0.2 and (depth > DEEP or face == above)):
        # The contact's own point tells the depth only while the centre is outside.
        point = on_shape
        least = float(0.0)
        if face != above:
            point = center
            least = LEAST_DEPTH
        inside = half_extent[box][face / 2] - wp.dot(wp.transform_point(to_box, point), out)
        out = wp.transform_vector(to_world, out)
        normal[contact] = towards * out
        on_shape = point
        on_box = point + wp.where(face == above, inside, wp.max(inside, least)) * out
    elif depth > SLOP:
        on_box = on_box + HARDER * depth * towards * normal[contact]
    else:
        return
    on_shape = wp.transform_point(wp.transform_inverse(pose), on_shape)
    point0[contact] = wp.where(towards > 0.0, on_box, on_shape)
    point1[contact] = wp.where(towards > 0.0, on_shape, on_box)


@wp.func
def face_along(direction: wp.vec3):
    """Index 2 * axis + (1 if positive) of the face whose normal is nearest to a direction."""
    size = wp.vec3(wp.abs(direction[0]), wp.abs(direction[1]), wp.abs(direction[2]))
    axis = int(0)
    if size[1] > size[axis]:
        axis = 1
    if size[2] > size[axis]:
        axis = 2
    return 2 * axis + wp.where(direction[axis] > 0.0, 1, 0)


@wp.func
def face_below(point: wp.vec3, half: wp.vec3):
    """The face that a point is straight above; -1 for a point inside the box or beyond an edge of it."""
    face = int(-1)
    outside = int(0)
    for axis in range(3):
        if wp.abs(point[axis]) > half[axis]:
            outside += 1
            face = 2 * axis + wp.where(point[axis] > 0.0, 1, 0)
    return wp.where(outside == 1, face, -1)


@wp.func
def face_towards(point: wp.vec3, half: wp.vec3, otherwise: int):
    """The face that a point outside the box is farthest beyond; `otherwise` for a point inside."""
    best = float(0.0)
    face = otherwise
    for axis in range(3):
        beyond = wp.abs(point[axis]) - half[axis]
        if beyond > best:
            best = beyond
            face = 2 * axis + wp.where(point[axis] > 0.0, 1, 0)
    return face


@wp.func
def face_normal(face: int):
    out = wp.vec3(0.0, 0.0, 0.0)
    out[face / 2] = float(2 * (face % 2) - 1)
    return out
