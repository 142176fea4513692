"""Support functions of shapes and instances, from the tables of `geometry.support_function.support_table`."""

from typing import Any

import warp as wp

from usdsdg_render.geometry.support_function import CELLS
from usdsdg_render.scene.structs import Instance

# Bound of the rounding error of a ray in single precision, relative to the largest coordinate involved.
ROUNDING = wp.constant(1.0e-5)
_CELLS = wp.constant(CELLS)
_HALF_CELLS = wp.constant(CELLS / 2)


@wp.struct
class SupportFunctions:
    """Tables of the support functions of shapes, and the shape of each instance."""

    values: wp.array2d(dtype=wp.float32)  # (prototypes, nodes)
    prototype: wp.array(dtype=wp.int32)  # per instance


@wp.func
def support(values: wp.array2d(dtype=Any), prototype: int, direction: Any):
    """Return the maximum of p · direction over the points p of a shape, rounded up, in the arguments' precision."""
    axis = int(0)
    if wp.abs(direction[1]) > wp.abs(direction[0]):
        axis = 1
    if wp.abs(direction[2]) > wp.abs(direction[axis]):
        axis = 2
    face = 2 * axis
    if direction[axis] < direction.dtype(0.0):
        face += 1
    one = direction.dtype(1.0)
    half = direction.dtype(_HALF_CELLS)
    length = wp.max(wp.abs(direction[axis]), direction.dtype(1.0e-30))
    first = (direction[(axis + 1) % 3] / length + one) * half
    second = (direction[(axis + 2) % 3] / length + one) * half
    i = wp.min(int(first), _CELLS - 1)
    j = wp.min(int(second), _CELLS - 1)
    u = first - direction.dtype(i)
    v = second - direction.dtype(j)
    node = (face * (_CELLS + 1) + i) * (_CELLS + 1) + j
    table = values[prototype]
    lower = table[node] * (one - v) + table[node + 1] * v
    upper = table[node + _CELLS + 1] * (one - v) + table[node + _CELLS + 2] * v
    return length * (lower * (one - u) + upper * u)


@wp.func
def coordinate_bound(supports: SupportFunctions, instance: Instance, index: int, eye: wp.vec3):
    """Return an upper bound on world coordinates of the eye and the instance; rounding errors scale with it."""
    size = float(0.0)
    prototype = supports.prototype[index]
    sides = int(6)
    for side in range(sides):
        along = wp.vec3(0.0)
        along[side / 2] = 1.0 - 2.0 * float(side % 2)
        size = wp.max(size, wp.abs(support(supports.values, prototype, wp.transpose(instance.local_to_world) * along)))
    return 2.0 * size + wp.max(wp.abs(instance.world_origin)) + wp.max(wp.abs(eye))


@wp.func
def support_from(
    supports: SupportFunctions, instance: Instance, index: int, direction: wp.vec3, eye: wp.vec3, largest: float
):
    """Return the support of an instance relative to the eye along a world direction, rounded up.

    Args:
        largest: `coordinate_bound` of this instance and eye.
    """
    local = wp.transpose(instance.local_to_world) * direction
    value = support(supports.values, supports.prototype[index], local) + wp.dot(direction, instance.world_origin - eye)
    return value + ROUNDING * largest * wp.length(direction)
