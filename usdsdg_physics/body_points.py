"""Warp functions of points of bodies, for all kernels: where they are, and how fast they move."""

# Code of Warp functions is not Python to a type checker.
# pyright: reportArgumentType=false, reportCallIssue=false, reportGeneralTypeIssues=false, reportIndexIssue=false, reportOperatorIssue=false

import warp as wp


@wp.func
def body_of(shape: int, shape_body: wp.array[wp.int32]):
    """Return the body of a shape; the world (-1) of none (-1)."""
    if shape < 0:
        return -1
    return int(shape_body[shape])


@wp.func
def world_point(body: int, point: wp.vec3, body_q: wp.array[wp.transform]):
    """Return a point of a body, or of the world (-1), in the world."""
    if body < 0:
        return point
    return wp.transform_point(body_q[body], point)


@wp.func
def shape_to_world(
    shape: int, transform: wp.array[wp.transform], shape_body: wp.array[wp.int32], body_q: wp.array[wp.transform]
):
    """Return the pose of a shape in the world; `transform` is that in its body, or in the world of static ones."""
    body = shape_body[shape]
    if body < 0:
        return transform[shape]
    return body_q[body] * transform[shape]


@wp.func
def body_point(body: int, point: wp.vec3, body_q: wp.array[wp.transform]):
    """Return a point of the world in the frame of a body, or of the world (-1)."""
    if body < 0:
        return point
    return wp.transform_point(wp.transform_inverse(body_q[body]), point)


@wp.func
def arm_of(body: int, point: wp.vec3, center: wp.array[wp.vec3], body_q: wp.array[wp.transform]):
    """Return what leads from the center of mass of a body to a point, both in the world [m]; zero in the world (-1).

    `center` is in the frames of the bodies.
    """
    if body < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    return point - wp.transform_point(body_q[body], center[body])


@wp.func
def turning_velocity(motion: wp.spatial_vector, arm: wp.vec3):
    """Return the velocity of a point [m/s], from the motion of a rigid body and the arm [m] that leads to the point."""
    return wp.spatial_top(motion) + wp.cross(wp.spatial_bottom(motion), arm)


@wp.func
def point_velocity(body: int, arm: wp.vec3, body_qd: wp.array[wp.spatial_vector]):
    """Return the velocity of a point of a body [m/s], world, from the arm that leads to it; zero in the world (-1)."""
    if body < 0:
        return wp.vec3(0.0, 0.0, 0.0)
    return turning_velocity(body_qd[body], arm)
