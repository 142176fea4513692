"""Warp functions of a contact's points, which are in the frames of bodies."""

# Code of Warp functions is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@wp.func
def is_free(body: int, free: wp.array[wp.int32]):
    """Return whether a body, or the world (-1), moves by itself."""
    if body < 0:
        return False
    return free[body] != 0


@wp.func
def world_point(body: int, point: wp.vec3, body_q: wp.array[wp.transform]):
    """Return a point of a body, or of the world (-1), in the world."""
    if body < 0:
        return point
    return wp.transform_point(body_q[body], point)


@wp.func
def turning_velocity(motion: wp.spatial_vector, arm: wp.vec3):
    """Return the velocity of a point [m/s], from the motion of a rigid body and the arm [m] that leads to the point."""
    return wp.spatial_top(motion) + wp.cross(wp.spatial_bottom(motion), arm)


@wp.func
def body_point(body: int, point: wp.vec3, body_q: wp.array[wp.transform]):
    """Return a point of the world in the frame of a body, or of the world (-1)."""
    if body < 0:
        return point
    return wp.transform_point(wp.transform_inverse(body_q[body]), point)


@wp.func
def contact_gap(contact: int, point0: wp.vec3, point1: wp.vec3, contacts: ContactArrays):
    """Return how far the surfaces of a contact are apart [m], negative where they overlap; its points in the world."""
    gap = wp.dot(contacts.normal[contact], point1 - point0)
    return gap - contacts.margin0[contact] - contacts.margin1[contact]


@wp.func
def is_first_of_pair(contact: int, contacts: ContactArrays):
    """Return whether the contact before this one, if any, is of other shapes."""
    if contact == 0:
        return True
    same0 = contacts.shape0[contact] == contacts.shape0[contact - 1]
    return not (same0 and contacts.shape1[contact] == contacts.shape1[contact - 1])
