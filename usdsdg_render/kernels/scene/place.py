"""Placement of instances: matrices of their records, and world bounding boxes. Runs on the CPU for any device."""

import warp as wp

from usdsdg_render.kernels.scene.support import support
from usdsdg_render.scene.structs import Instance

_HALF = wp.constant(wp.float64(0.5))
# A matrix is flat if its determinant is less than this fraction of the product of its rows' lengths, or if that
# product is less than the second.
_FLAT = wp.constant(wp.float64(1e-12))
_NOTHING = wp.constant(wp.float64(1e-30))
# Relative margin of boxes, above the rounding of a ray in single precision.
_ROUNDING = wp.constant(wp.float64(2e-6))


@wp.struct
class Places:
    """What `place` reads and fills: all arrays but `supports` have an element for each instance."""

    matrices: wp.array(dtype=wp.mat44d)  # local to world, for row vectors
    prototype: wp.array(dtype=wp.int32)
    supports: wp.array2d(dtype=wp.float64)  # (prototypes, nodes): see `geometry.support_function`
    # out
    instances: wp.array(dtype=Instance)  # their matrices and origins; other fields stay
    lower: wp.array(dtype=wp.vec3)
    upper: wp.array(dtype=wp.vec3)
    solid: wp.array(dtype=wp.uint8)  # 1 = it has a volume in the world; 0 = its matrix is flat or not finite


@wp.func
def is_solid(matrix: wp.mat44d, linear: wp.mat33d):
    for row in range(4):
        for column in range(4):
            if not wp.isfinite(matrix[row, column]):
                return False
    scale = wp.length(linear[0]) * wp.length(linear[1]) * wp.length(linear[2])
    return scale > _NOTHING and wp.abs(wp.determinant(linear)) > _FLAT * scale


@wp.kernel(enable_backward=False)
def place(places: Places):
    i = wp.tid()
    matrix = places.matrices[i]
    linear = wp.mat33d(
        matrix[0, 0], matrix[0, 1], matrix[0, 2],
        matrix[1, 0], matrix[1, 1], matrix[1, 2],
        matrix[2, 0], matrix[2, 1], matrix[2, 2],
    )  # fmt: skip
    origin = wp.vec3d(matrix[3, 0], matrix[3, 1], matrix[3, 2])
    solid = is_solid(matrix, linear)
    if not solid:
        linear = wp.identity(3, dtype=wp.float64)
        origin = wp.vec3d()
    # Rows times matrix on the host, matrix times column in kernels.
    places.instances[i].local_to_world = wp.mat33(wp.transpose(linear))
    places.instances[i].world_to_local = wp.mat33(wp.transpose(wp.inverse(linear)))
    places.instances[i].world_origin = wp.vec3(origin)
    lower = wp.vec3()
    upper = wp.vec3()
    for axis in range(3):
        # The coordinate of a point p along a world axis is p · (column of the matrix).
        along = wp.vec3d(linear[0, axis], linear[1, axis], linear[2, axis])
        first = origin[axis] - support(places.supports, places.prototype[i], -along)
        last = origin[axis] + support(places.supports, places.prototype[i], along)
        middle = (first + last) * _HALF
        half = (last - first) * _HALF
        half += _ROUNDING * (wp.abs(middle) + half)
        lower[axis] = wp.float32(middle - half)
        upper[axis] = wp.float32(middle + half)
    places.lower[i] = lower
    places.upper[i] = upper
    places.solid[i] = wp.uint8(wp.where(solid, 1, 0))
