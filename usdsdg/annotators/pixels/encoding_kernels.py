"""Kernels that write AOVs in the types of images: four channels of float16, float32 or uint8.

AOVs are read as floats, so that one kernel of each type takes numbers, pairs and vectors.
"""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportIndexIssue=false

import warp as wp


@wp.func
def channel_of(image: wp.array(dtype=wp.float32), pixel: int, channels: int, c: int):
    """Return a channel of a pixel: those of numbers are all equal, missing ones of pairs and vectors are 0."""
    if channels == 1:
        return image[pixel]
    if c < channels:
        return image[pixel * channels + c]
    return float(0.0)


@wp.func
def half_of(x: float, limit: float):
    return wp.float16(wp.where(x > limit, limit, x))


@wp.func
def byte_of(x: float):
    return wp.uint8(wp.clamp(x, 0.0, 1.0) * 255.0 + 0.5)


@wp.kernel(enable_backward=False, module="unique")
def halves(
    image: wp.array(dtype=wp.float32),
    channels: int,
    plus: wp.array(dtype=wp.float32),  # of as many channels; empty for none
    instance: wp.array(dtype=wp.int32),  # the fourth channel is 1 where it is not -1; empty: everywhere
    limit: float,
    first: int,
    # out
    result: wp.array(dtype=wp.vec4h),
):
    i = wp.tid()
    i += first
    x = channel_of(image, i, channels, 0)
    y = channel_of(image, i, channels, 1)
    z = channel_of(image, i, channels, 2)
    if plus.shape[0] > 0:
        x += channel_of(plus, i, channels, 0)
        y += channel_of(plus, i, channels, 1)
        z += channel_of(plus, i, channels, 2)
    fourth = float(1.0)
    if instance.shape[0] > 0 and instance[i] < 0:
        fourth = 0.0
    result[i] = wp.vec4h(half_of(x, limit), half_of(y, limit), half_of(z, limit), wp.float16(fourth))


@wp.kernel(enable_backward=False, module="unique")
def floats(
    image: wp.array(dtype=wp.float32),
    channels: int,
    fourth: float,
    first: int,
    # out
    result: wp.array(dtype=wp.vec4),
):
    i = wp.tid()
    i += first
    x = channel_of(image, i, channels, 0)
    y = channel_of(image, i, channels, 1)
    z = channel_of(image, i, channels, 2)
    result[i] = wp.vec4(x, y, z, fourth)


@wp.kernel(enable_backward=False, module="unique")
def eight_bits(
    image: wp.array(dtype=wp.float32),
    channels: int,
    first: int,
    # out
    result: wp.array(dtype=wp.vec4ub),
):
    i = wp.tid()
    i += first
    fourth = wp.uint8(255)
    if channels == 4:
        fourth = byte_of(image[4 * i + 3])
    x = byte_of(channel_of(image, i, channels, 0))
    y = byte_of(channel_of(image, i, channels, 1))
    z = byte_of(channel_of(image, i, channels, 2))
    result[i] = wp.vec4ub(x, y, z, fourth)


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
