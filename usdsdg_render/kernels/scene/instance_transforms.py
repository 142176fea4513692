"""Transforms of instances: the matrices of their records, and world bounding boxes. Runs on the CPU for any device."""

import warp as wp

from usdsdg_render.kernels.scene.support_function import support
from usdsdg_render.scene.structs import Instance

# Of the largest number of a row.
_NOISE = wp.constant(wp.float64(1.0e-14))
_HALF = wp.constant(wp.float64(0.5))
# A matrix counts as singular if the product of its rows' lengths is at most _MIN_SCALE, or its determinant is at most
# the fraction _MIN_DETERMINANT of that product.
_MIN_DETERMINANT = wp.constant(wp.float64(1e-12))
_MIN_SCALE = wp.constant(wp.float64(1e-30))
# Relative margin of boxes, larger than the rounding error of a ray in single precision.
_ROUNDING = wp.constant(wp.float64(2e-6))


@wp.struct
class InstanceTransforms:
    """Inputs and outputs of `set_instance_transforms`; all arrays but `supports` have one element per instance."""

    matrices: wp.array(dtype=wp.mat44d)  # local to world, for row vectors
    prototype: wp.array(dtype=wp.int32)
    supports: wp.array2d(dtype=wp.float64)  # (prototypes, nodes), see `geometry.support_function`
    # out
    instances: wp.array(dtype=Instance)  # only their matrices and origins are written
    lower: wp.array(dtype=wp.vec3)
    upper: wp.array(dtype=wp.vec3)
    invertible: wp.array(dtype=wp.uint8)  # 0 = its matrix is singular or not finite


@wp.func
def is_invertible(matrix: wp.mat44d, linear: wp.mat33d):
    for row in range(4):
        for column in range(4):
            if not wp.isfinite(matrix[row, column]):
                return False
    scale = wp.length(linear[0]) * wp.length(linear[1]) * wp.length(linear[2])
    return scale > _MIN_SCALE and wp.abs(wp.determinant(linear)) > _MIN_DETERMINANT * scale


@wp.func
def without_noise(matrix: wp.mat33d):
    """Return a matrix with zeros where terms have cancelled out but for their rounding.

    Rays along faces tell zero from a number that depends on how the matrix was computed.
    """
    for row in range(3):
        size = wp.max(wp.max(wp.abs(matrix[row, 0]), wp.abs(matrix[row, 1])), wp.abs(matrix[row, 2]))
        for axis in range(3):
            if wp.abs(matrix[row, axis]) < _NOISE * size:
                matrix[row, axis] = wp.float64(0.0)
    return matrix


@wp.kernel(enable_backward=False)
def set_instance_transforms(transforms: InstanceTransforms, first_instance: int):
    i = wp.tid() + first_instance
    matrix = transforms.matrices[i]
    linear = wp.mat33d(
        matrix[0, 0], matrix[0, 1], matrix[0, 2],
        matrix[1, 0], matrix[1, 1], matrix[1, 2],
        matrix[2, 0], matrix[2, 1], matrix[2, 2],
    )  # fmt: skip
    origin = wp.vec3d(matrix[3, 0], matrix[3, 1], matrix[3, 2])
    linear = without_noise(linear)
    invertible = is_invertible(matrix, linear)
    if not invertible:
        linear = wp.identity(3, dtype=wp.float64)
        origin = wp.vec3d()
    # Matrices of the host are for row vectors, those of kernels for column vectors.
    transforms.instances[i].local_to_world = wp.mat33(wp.transpose(linear))
    transforms.instances[i].world_to_local = wp.mat33(wp.transpose(without_noise(wp.inverse(linear))))
    transforms.instances[i].world_origin = wp.vec3(origin)
    lower = wp.vec3()
    upper = wp.vec3()
    for axis in range(3):
        # The coordinate of a point p along a world axis is p · (column of the matrix).
        along = wp.vec3d(linear[0, axis], linear[1, axis], linear[2, axis])
        first = origin[axis] - support(transforms.supports, transforms.prototype[i], -along)
        last = origin[axis] + support(transforms.supports, transforms.prototype[i], along)
        middle = (first + last) * _HALF
        half = (last - first) * _HALF
        half += _ROUNDING * (wp.abs(middle) + half)
        lower[axis] = wp.float32(middle - half)
        upper[axis] = wp.float32(middle + half)
    transforms.lower[i] = lower
    transforms.upper[i] = upper
    transforms.invertible[i] = wp.uint8(wp.where(invertible, 1, 0))
