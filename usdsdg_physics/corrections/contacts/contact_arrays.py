"""Newton's contacts as one Warp struct, which the kernels of all corrections take."""

# Warp structs are no classes to a type checker.
# pyright: reportGeneralTypeIssues=false

from __future__ import annotations

from typing import TYPE_CHECKING

import warp as wp

if TYPE_CHECKING:
    import newton


@wp.struct
class ContactArrays:
    """The arrays of Newton's rigid contacts, by contact.

    Points are in the body's frame, those of a static shape in the world; spheres and capsules give a point on their
    axis and the radius as part of the margin. The normal points from shape 0 to shape 1, in the world.
    """

    count: wp.array[wp.int32]  # (1,) contacts found
    shape0: wp.array[wp.int32]  # -1 for none
    shape1: wp.array[wp.int32]
    point0: wp.array[wp.vec3]  # m
    point1: wp.array[wp.vec3]  # m
    normal: wp.array[wp.vec3]
    margin0: wp.array[wp.float32]  # m
    margin1: wp.array[wp.float32]  # m


def contact_arrays(contacts: newton.Contacts) -> ContactArrays:
    """Return the struct of a contact buffer; the collision pipeline fills the same arrays at every step."""
    arrays = ContactArrays()
    for name in ContactArrays.vars:
        setattr(arrays, name, getattr(contacts, f"rigid_contact_{name}"))
    return arrays
