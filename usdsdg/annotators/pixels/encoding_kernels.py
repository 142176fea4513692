"""Kernels that write AOVs in the types of images: four channels of float16, float32 or uint8."""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false

import warp as wp


@wp.func
def half_of(x: float, limit: float):
    return wp.float16(wp.where(x > limit, limit, x))


@wp.func
def byte_of(x: float):
    return wp.uint8(wp.clamp(x, 0.0, 1.0) * 255.0 + 0.5)


@wp.kernel(enable_backward=False, module="unique")
def halves_of_vectors(
    image: wp.array(dtype=wp.vec3),
    plus: wp.array(dtype=wp.vec3),  # empty for none
    instance: wp.array(dtype=wp.int32),  # the fourth channel is 1 where it is not -1; empty: everywhere
    limit: float,
    first: int,
    # out
    halves: wp.array(dtype=wp.vec4h),
):
    i = wp.tid()
    i += first
    v = image[i]
    if plus.shape[0] > 0:
        v += plus[i]
    fourth = float(1.0)
    if instance.shape[0] > 0 and instance[i] < 0:
        fourth = 0.0
    halves[i] = wp.vec4h(half_of(v[0], limit), half_of(v[1], limit), half_of(v[2], limit), wp.float16(fourth))


@wp.kernel(enable_backward=False, module="unique")
def halves_of_numbers(
    image: wp.array(dtype=wp.float32),
    first: int,
    # out
    halves: wp.array(dtype=wp.vec4h),
):
    i = wp.tid()
    i += first
    h = wp.float16(image[i])
    halves[i] = wp.vec4h(h, h, h, wp.float16(1.0))


@wp.kernel(enable_backward=False, module="unique")
def floats_of_vectors(
    image: wp.array(dtype=wp.vec3),
    fourth: float,
    first: int,
    # out
    floats: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    i += first
    v = image[i]
    floats[i] = wp.vec4(v[0], v[1], v[2], fourth)


@wp.kernel(enable_backward=False, module="unique")
def floats_of_pairs(
    image: wp.array(dtype=wp.vec2),
    fourth: float,
    first: int,
    # out
    floats: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    i += first
    v = image[i]
    floats[i] = wp.vec4(v[0], v[1], 0.0, fourth)


@wp.kernel(enable_backward=False, module="unique")
def bytes_of_vectors(
    image: wp.array(dtype=wp.vec3),
    first: int,
    # out
    result: wp.array(dtype=wp.vec4ub),
):
    i = wp.tid()
    i += first
    v = image[i]
    result[i] = wp.vec4ub(byte_of(v[0]), byte_of(v[1]), byte_of(v[2]), wp.uint8(255))


@wp.kernel(enable_backward=False, module="unique")
def bytes_of_numbers(
    image: wp.array(dtype=wp.float32),
    first: int,
    # out
    result: wp.array(dtype=wp.vec4ub),
):
    i = wp.tid()
    i += first
    b = byte_of(image[i])
    result[i] = wp.vec4ub(b, b, b, wp.uint8(255))


@wp.kernel(enable_backward=False, module="unique")
def without_alpha(
    image: wp.array(dtype=wp.vec4ub),
    first: int,
    # out
    result: wp.array(dtype=wp.vec3ub),
):
    i = wp.tid()
    i += first
    v = image[i]
    result[i] = wp.vec3ub(v[0], v[1], v[2])


@wp.kernel(enable_backward=False, module="unique")
def behind_everything(
    color: wp.array(dtype=wp.vec4h),
    instance: wp.array(dtype=wp.int32),
    first: int,
    # out
    result: wp.array(dtype=wp.vec4h),
):
    i = wp.tid()
    i += first
    nothing = wp.float16(0.0)
    result[i] = wp.where(instance[i] < 0, color[i], wp.vec4h(nothing, nothing, nothing, nothing))
