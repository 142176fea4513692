"""Warp functions of the sides of a contact: 1.0 is that of its first shape, -1.0 that of its second.

Multiplied by a side, the normal of the contact points from the shape on that side to the other.
"""

# Code of Warp functions is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import body_point
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays


@wp.func
def shape_on(side: float, contact: int, contacts: ContactArrays):
    """Return the shape on a side of a contact."""
    return int(wp.where(side > 0.0, contacts.shape0[contact], contacts.shape1[contact]))


@wp.func
def point_on(side: float, contact: int, contacts: ContactArrays):
    """Return the point of the shape on a side of a contact, in the frame of its body."""
    return wp.where(side > 0.0, contacts.point0[contact], contacts.point1[contact])


@wp.func
def turn(
    contact: int,
    side: float,
    normal: wp.vec3,
    point: wp.vec3,
    body: int,
    body_q: wp.array[wp.transform],
    contacts: ContactArrays,
):
    """Give a contact a normal, which points from the shape on a side, and a point of that shape, both in the world.

    `body` is that of the shape; -1 is the world.
    """
    contacts.normal[contact] = side * normal
    if side > 0.0:
        contacts.point0[contact] = body_point(body, point, body_q)
    else:
        contacts.point1[contact] = body_point(body, point, body_q)
