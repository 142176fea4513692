"""Warp kernel over contacts: redirect those that would push a body through a static box."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

# ruff: noqa: UP018, RUF046

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays
from usdsdg_physics.guards.sides import point_on, shape_on

# An exit face and the step in which it was last touched share one integer: step * FACE_CODES + face.
FACE_CODES = wp.constant(8)
# Contacts flicker: an exit face is forgotten after this many steps without one.
MEMORY_STEPS = wp.constant(4)
# Depth [m] from which a push along the surface means a body inside the box, not one that slides over its edge.
DEEP_PENETRATION = wp.constant(0.01)
MIN_DEPTH = wp.constant(0.02)  # m
# A wall wins against what squeezes a body into it: beyond the slop, depths count this much more.
SLOP = wp.constant(0.002)  # m
DEPTH_GAIN = wp.constant(0.25)


@wp.kernel(enable_backward=False)
def count_step(steps: wp.array[wp.int32]):
    """Count a step in `steps` (1,)."""
    steps[0] = steps[0] + 1


@wp.kernel(enable_backward=False)
def redirect_contacts(
    # scene
    box_index: wp.array[wp.int32],
    half_extent: wp.array[wp.vec3],
    shape_transform: wp.array[wp.transform],
    shape_body: wp.array[wp.int32],
    shape_center: wp.array[wp.vec3],
    # body
    anchor: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    teleported: wp.array[wp.int32],
    steps: wp.array[wp.int32],
    # in and out
    contacts: ContactArrays,
    exit_face: wp.array2d[wp.int32],
):
    """Redirect contacts that would push a convex shape out of a static box by the wrong face.

    The narrow phase pushes along the minimum penetration depth. For a shape more than half way into a wall that leads
    through the wall, for one that slides down a wall into the seam with the floor it leads into the seam. Here the exit
    face stays the one at which the contact began: the face in whose Voronoi region the shape's center was, or, when its
    body was teleported since the last step, the face of maximum separation of the body's anchor.

    `exit_face[box_index, shape]` holds step * FACE_CODES + face of each static box and shape; `box_index` is -1 for
    other shapes. `shape_center` and `anchor` are in the body's frame; `steps` (1,) counts the steps.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    if contacts.shape0[contact] < 0 or contacts.shape1[contact] < 0:
        return
    side = float(1.0)  # of the box
    if box_index[contacts.shape0[contact]] < 0:
        side = float(-1.0)
    box = shape_on(side, contact, contacts)
    shape = shape_on(-side, contact, contacts)
    row = box_index[box]
    body = shape_body[shape]
    if row < 0 or body < 0:
        return

    box_to_world = shape_transform[box]
    world_to_box = wp.transform_inverse(box_to_world)
    pose = body_q[body]
    point_on_shape = wp.transform_point(pose, point_on(-side, contact, contacts))
    point_on_box = point_on(side, contact, contacts)
    push = wp.transform_vector(world_to_box, side * contacts.normal[contact])
    depth = (
        wp.dot(side * contacts.normal[contact], point_on_box - point_on_shape)
        + contacts.margin0[contact]
        + contacts.margin1[contact]
    )
    center = wp.transform_point(pose, shape_center[shape])
    center_face = voronoi_face(wp.transform_point(world_to_box, center), half_extent[box])
    face = int(remembered_face(exit_face[row, shape], steps[0]))
    if face >= 0:
        if not (center_face == face or depth > DEEP_PENETRATION or wp.dot(push, face_normal(face)) < -0.5):
            face = face_of_direction(push)
    elif teleported[body] != 0:
        from_box = wp.transform_point(world_to_box, wp.transform_point(pose, anchor[body]))
        face = face_of_max_separation(from_box, half_extent[box], face_of_direction(push))
    else:
        face = wp.where(center_face >= 0, center_face, face_of_direction(push))
    exit_face[row, shape] = steps[0] * FACE_CODES + face

    exit_normal = face_normal(face)
    cosine = wp.dot(push, exit_normal)
    if cosine < -0.5 or (cosine < 0.2 and (depth > DEEP_PENETRATION or face == center_face)):
        # The contact's own point tells the depth only while the center is outside.
        point = point_on_shape
        min_depth = float(0.0)
        if face != center_face:
            point = center
            min_depth = MIN_DEPTH
        face_depth = half_extent[box][face / 2] - wp.dot(wp.transform_point(world_to_box, point), exit_normal)
        exit_normal = wp.transform_vector(box_to_world, exit_normal)
        contacts.normal[contact] = side * exit_normal
        point_on_shape = point
        point_on_box = point + wp.where(face == center_face, face_depth, wp.max(face_depth, min_depth)) * exit_normal
    elif depth > SLOP:
        point_on_box = point_on_box + DEPTH_GAIN * depth * side * contacts.normal[contact]
    else:
        return
    point_on_shape = wp.transform_point(wp.transform_inverse(pose), point_on_shape)
    contacts.point0[contact] = wp.where(side > 0.0, point_on_box, point_on_shape)
    contacts.point1[contact] = wp.where(side > 0.0, point_on_shape, point_on_box)


@wp.func
def remembered_face(code: int, step: int):
    """Return the exit face of a value of `exit_face`; -1 for none, and for one that is forgotten at this step."""
    if code < 0 or step - code / FACE_CODES > MEMORY_STEPS:
        return -1
    return code % FACE_CODES


@wp.func
def face_of_direction(direction: wp.vec3):
    """Return the index 2 * axis + (1 if positive) of the face whose normal is nearest to a direction."""
    size = wp.vec3(wp.abs(direction[0]), wp.abs(direction[1]), wp.abs(direction[2]))
    axis = int(0)
    if size[1] > size[axis]:
        axis = 1
    if size[2] > size[axis]:
        axis = 2
    return 2 * axis + wp.where(direction[axis] > 0.0, 1, 0)


@wp.func
def voronoi_face(point: wp.vec3, half_extent: wp.vec3):
    """Return the face in whose Voronoi region a point lies; -1 inside the box or in the region of an edge or vertex."""
    face = int(-1)
    outside = int(0)
    for axis in range(3):
        if wp.abs(point[axis]) > half_extent[axis]:
            outside += 1
            face = 2 * axis + wp.where(point[axis] > 0.0, 1, 0)
    return wp.where(outside == 1, face, -1)


@wp.func
def face_of_max_separation(point: wp.vec3, half_extent: wp.vec3, inside: int):
    """Return the face whose plane a point is farthest beyond; `inside` for a point inside the box."""
    max_separation = float(0.0)
    face = inside
    for axis in range(3):
        separation = wp.abs(point[axis]) - half_extent[axis]
        if separation > max_separation:
            max_separation = separation
            face = 2 * axis + wp.where(point[axis] > 0.0, 1, 0)
    return face


@wp.func
def face_normal(face: int):
    """Return the normal of a face of a box, in its frame."""
    normal = wp.vec3(0.0, 0.0, 0.0)
    normal[face / 2] = float(2 * (face % 2) - 1)
    return normal
