"""Warp functions of contacts: what takes part in them, and how far apart they are."""

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
def contact_gap(contact: int, point0: wp.vec3, point1: wp.vec3, contacts: ContactArrays):
    """Return how far the surfaces of a contact are apart [m], negative where they overlap; its points in the world."""
    gap = wp.dot(contacts.normal[contact], point1 - point0)
    return gap - contacts.margin0[contact] - contacts.margin1[contact]


@wp.func
def is_first_of_pair(contact: int, contacts: ContactArrays):
    """Return whether the contact before this one, if any, is of other shapes."""
    if contact == 0:
        return True
    return not is_same_pair(contact, contact - 1, contacts)


@wp.func
def is_same_pair(contact: int, other: int, contacts: ContactArrays):
    """Return whether two contacts are of the same shapes."""
    same0 = contacts.shape0[contact] == contacts.shape0[other]
    return same0 and contacts.shape1[contact] == contacts.shape1[other]
