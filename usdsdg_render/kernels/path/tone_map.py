"""Tone mapping: mean radiance to display colors."""

import warp as wp


@wp.func
def filmic(x: float):
    """A fit of the ACES reference curve (Narkowicz, "ACES Filmic Tone Mapping Curve", 2016); 1 maps to 0.8."""
    return wp.clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)


@wp.func
def srgb_encoded(x: float):
    """Encode a linear value by the sRGB transfer function."""
    if x <= 0.0031308:
        return 12.92 * x
    return 1.055 * wp.pow(x, 1.0 / 2.4) - 0.055


@wp.kernel(enable_backward=False)
def tone_map_pixels(
    radiance: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    film: wp.array2d(
        dtype=wp.vec4
    ),  # the same before denoising; pixels without samples (outside of the lens) are clear
    exposure: float,
    curve: int,  # 1 = filmic, 0 = clip
    first_row: int,
    # out
    hdr: wp.array2d(dtype=wp.vec4h),
    ldr: wp.array2d(dtype=wp.vec4ub),
):
    y, x = wp.tid()
    y += first_row
    pixel = radiance[y, x]
    scale = 1.0 / wp.max(pixel[3], 1.0)
    encoded = wp.vec3(0.0)
    for k in range(3):
        value = pixel[k] * scale * exposure
        if curve != 0:
            value = filmic(value)
        encoded[k] = wp.floor(255.0 * srgb_encoded(wp.clamp(value, 0.0, 1.0)) + 0.5)
    # The largest half float.
    largest_half = wp.vec3(65504.0)
    mean = wp.min(wp.vec3(pixel[0], pixel[1], pixel[2]) * scale, largest_half)
    alpha = float(1.0)
    if film[y, x][3] == 0.0:
        alpha = 0.0
        mean = wp.vec3(0.0)
        encoded = wp.vec3(0.0)
    hdr[y, x] = wp.vec4h(wp.float16(mean[0]), wp.float16(mean[1]), wp.float16(mean[2]), wp.float16(alpha))
    ldr[y, x] = wp.vec4ub(wp.uint8(encoded[0]), wp.uint8(encoded[1]), wp.uint8(encoded[2]), wp.uint8(255.0 * alpha))


@wp.kernel(enable_backward=False)
def sum_dropped(
    dropped: wp.array2d(dtype=wp.int32),
    # out
    total: wp.array(dtype=wp.int32),
):
    """Sum the dropped samples of a film; on CUDA only, since additions on a CPU are not atomic."""
    y, x = wp.tid()
    if dropped[y, x] > 0:
        wp.atomic_add(total, 0, dropped[y, x])
