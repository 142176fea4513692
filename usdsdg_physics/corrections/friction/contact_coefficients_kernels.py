"""Warp kernel over contacts: replace shapes by stand-ins with other friction and restitution."""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp

from usdsdg_physics.body_points import point_velocity
from usdsdg_physics.corrections.contacts.contact_arrays import ContactArrays

# Slower surfaces stick in any case, as those of bodies on each other, which gravity does not press together here.
STICKING_SPEED = wp.constant(0.01)  # m/s


@wp.kernel(enable_backward=False)
def replace_shapes(
    # scene
    shape_body: wp.array[wp.int32],
    material: wp.array[wp.int32],
    value: wp.array3d[wp.int32],
    stand_in: wp.array2d[wp.int32],
    static_friction: wp.array2d[wp.float32],
    gravity: wp.array[wp.vec3],
    dt: wp.float32,
    # body
    dynamic: wp.array[wp.int32],
    inverse_mass: wp.array[wp.float32],
    body_f: wp.array[wp.spatial_vector],
    center: wp.array[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    surface_velocity: wp.array[wp.vec3],
    # in and out
    contacts: ContactArrays,
):
    """Replace both shapes of a contact by those with the coefficients of their pair of materials.

    Surfaces stick where friction can stop them within `dt` seconds, as in PhysX: where the speed at which they would
    slide is at most their static friction times that at which they would approach each other. `value[material, other
    material, sticks]` is a column of `stand_in`, whose row is the body's index plus one; -1 keeps the shape.
    """
    contact = wp.tid()
    if contact >= contacts.count[0]:
        return
    first = int(contacts.shape0[contact])
    second = int(contacts.shape1[contact])
    if first < 0 or second < 0:
        return
    own = int(material[first])
    other = int(material[second])
    if own < 0 or other < 0:
        return
    body0 = int(shape_body[first])
    body1 = int(shape_body[second])
    arm0 = turned_arm(body0, contacts.point0[contact], center, body_q)
    arm1 = turned_arm(body1, contacts.point1[contact], center, body_q)
    velocity = point_velocity(body0, arm0, body_qd) - point_velocity(body1, arm1, body_qd)
    # Not what torques do, as friction bears the forces of what does not slide.
    if body0 >= 0 and dynamic[body0] != 0:
        velocity += dt * (gravity[0] + inverse_mass[body0] * wp.spatial_top(body_f[body0]))
    if body1 >= 0 and dynamic[body1] != 0:
        velocity -= dt * (gravity[0] + inverse_mass[body1] * wp.spatial_top(body_f[body1]))
    if surface_velocity:
        velocity -= surface_velocity[contact]
    normal = wp.vec3(contacts.normal[contact])
    approach = wp.dot(normal, velocity)
    sliding = wp.length(velocity - approach * normal)
    sticks = wp.where(sliding <= wp.max(STICKING_SPEED, static_friction[own, other] * approach), 1, 0)
    column = int(value[own, other, sticks])
    if column >= 0 and stand_in[body0 + 1, column] >= 0:
        contacts.shape0[contact] = stand_in[body0 + 1, column]
    column = int(value[other, own, sticks])
    if column >= 0 and stand_in[body1 + 1, column] >= 0:
        contacts.shape1[contact] = stand_in[body1 + 1, column]


@wp.func
def turned_arm(body: int, point: wp.vec3, center: wp.array[wp.vec3], body_q: wp.array[wp.transform]):
    """Return what leads from the center of mass of a body to a point in its frame, in the world [m]; zero in that."""
    if body < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    return wp.transform_vector(body_q[body], point - center[body])
