"""Kernels of the denoisers: an edge-avoiding wavelet filter, inputs of Open Image Denoise, and the final blend.

The wavelet filter smooths radiance divided by albedo and multiplies the albedo back. It is an à-trous wavelet (Dammertz
et al., HPG 2010) with variance-guided weights (Schied et al., "SVGF", HPG 2017), over one frame alone: there is no
temporal accumulation, so an image never depends on the one before.
"""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.path.path_memory import load, store
from usdsdg_render.kernels.powers import exp_of_minus, power_64

# On CUDA: approximate division, square root and powers, to an ulp or two, far below the noise.
wp.set_module_options({"fast_math": True})

# Tolerance of the luminance weight [standard deviations].
LIGHT_SIGMAS = wp.constant(3.0)
# Lower bound of the albedo that radiance is divided by.
MIN_ALBEDO = wp.constant(0.02)
# Side of the blocks of `block_luminance` [pixels].
BLOCK_PIXELS = wp.constant(16)


@wp.func
def xyz(v: wp.vec4):
    return wp.vec3(v[0], v[1], v[2])


@wp.kernel(enable_backward=False)
def demodulate(
    color: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    background: wp.array2d(dtype=wp.vec4),
    albedo: wp.array2d(dtype=wp.vec3),
    normal_depth: wp.array2d(dtype=wp.vec4),
    square: wp.array2d(dtype=wp.float32),
    first_row: int,
    # out, of samples that hit a surface
    irradiance: wp.array2d(dtype=wp.vec4),  # mean radiance over albedo [nits], and variance of its mean luminance
    guide: wp.array2d(dtype=wp.vec4),  # unit normal and mean depth; 0 where no sample hit or normals cancel
    surface_albedo: wp.array2d(dtype=wp.vec3),  # mean albedo, at least MIN_ALBEDO
):
    y, x = wp.tid()
    y += first_row
    # What is not scattered, of the background and of surfaces that shine, is set aside and added at the end: it must
    # not be multiplied by the albedo of an edge.
    foreground = color[y, x] - background[y, x]
    n = wp.max(foreground[3], 1.0)
    mean_albedo = wp.max(albedo[y, x] / n, wp.vec3(MIN_ALBEDO))
    mean = wp.cw_div(xyz(foreground) / n, mean_albedo)
    mean_luminance = luminance(mean)
    # One sample gives no variance estimate; treat it as fully uncertain.
    variance = wp.max(square[y, x] / n - mean_luminance * mean_luminance, 0.0) / n
    if n < 2.0:
        variance = mean_luminance * mean_luminance
    irradiance[y, x] = wp.vec4(mean[0], mean[1], mean[2], variance)
    sums = normal_depth[y, x]
    normal = xyz(sums) / n
    length = wp.length(normal)
    guide[y, x] = wp.vec4(0.0)
    if length > 0.5:
        normal = normal / length
        guide[y, x] = wp.vec4(normal[0], normal[1], normal[2], sums[3] / n)
    surface_albedo[y, x] = mean_albedo


@wp.func
def depth_gradient(guide: wp.array2d(dtype=wp.vec4), y: int, x: int, top: int, bottom: int):
    """Depth change per pixel: the smaller of both sides of each axis, so that depth discontinuities do not count."""
    z = guide[y, x][3]
    left = wp.abs(z - guide[y, wp.max(x - 1, 0)][3])
    right = wp.abs(z - guide[y, wp.min(x + 1, guide.shape[1] - 1)][3])
    up = wp.abs(z - guide[wp.max(y - 1, top), x][3])
    down = wp.abs(z - guide[wp.min(y + 1, bottom - 1), x][3])
    return wp.max(wp.min(left, right), wp.min(up, down))


@wp.func
def smoothed_variance(irradiance: wp.array2d(dtype=wp.vec4), y: int, x: int, top: int, bottom: int):
    """Variance filtered over 3x3 pixels, because few samples estimate it badly."""
    total = float(0.0)
    weights = float(0.0)
    for j in range(-1, 2):
        for i in range(-1, 2):
            v = y + j
            u = x + i
            if v >= top and u >= 0 and v < bottom and u < irradiance.shape[1]:
                w = 1.0 / float((1 + wp.abs(i)) * (1 + wp.abs(j)))
                total += w * irradiance[v, u][3]
                weights += w
    return total / weights


@wp.kernel(enable_backward=False)
def atrous_pass(
    irradiance: wp.array2d(dtype=wp.vec4),
    guide: wp.array2d(dtype=wp.vec4),
    step: int,  # pixels between taps
    reach: int,  # rows of taps on either side: 2
    height: int,  # rows of an image; images are one below the other
    first_row: int,
    # out
    smoothed: wp.array2d(dtype=wp.vec4),
):
    y, x = wp.tid()
    y += first_row
    top = y / height * height
    bottom = top + height
    center = load(irradiance, y, x)
    own = load(guide, y, x)
    normal = xyz(own)
    if wp.dot(normal, normal) == 0.0:
        store(smoothed, y, x, xyz(center), center[3])
        return
    depth = own[3]
    gradient = depth_gradient(guide, y, x, top, bottom)
    level = luminance(xyz(center))
    tolerance = LIGHT_SIGMAS * wp.sqrt(smoothed_variance(irradiance, y, x, top, bottom)) + 1.0e-4 * level + 1.0e-8
    inverse_tolerance = 1.0 / tolerance
    total = wp.vec3(0.0)
    variance = float(0.0)
    weight_sum = float(0.0)
    # A loop over rows of taps that is not unrolled: 25 taps at once take registers, so that too few threads of a GPU
    # hide the latency of their loads.
    for j in range(-reach, reach + 1):
        b = wp.abs(j)
        row_weight = wp.where(b == 0, 0.375, wp.where(b == 1, 0.25, 0.0625))
        v = y + j * step
        for i in range(-2, 3):
            u = x + i * step
            if v >= top and u >= 0 and v < bottom and u < irradiance.shape[1]:
                other_guide = load(guide, v, u)
                cos_normals = wp.dot(normal, xyz(other_guide))
                if cos_normals > 0.0:
                    # The B3 spline: 3/8, 1/4, 1/16.
                    a = wp.abs(i)
                    weight = wp.where(a == 0, 0.375, wp.where(a == 1, 0.25, 0.0625)) * row_weight
                    depth_tolerance = gradient * float(step * (a + b)) + 2.0e-3 * depth + 1.0e-12
                    tap = load(irradiance, v, u)
                    distance = wp.abs(depth - other_guide[3]) / depth_tolerance
                    distance += wp.abs(level - luminance(xyz(tap))) * inverse_tolerance
                    weight *= power_64(cos_normals) * exp_of_minus(distance)
                    total += xyz(tap) * weight
                    variance += tap[3] * weight * weight
                    weight_sum += weight
    total = total / weight_sum
    store(smoothed, y, x, total, variance / (weight_sum * weight_sum))


@wp.kernel(enable_backward=False)
def remodulate(
    irradiance: wp.array2d(dtype=wp.vec4),
    surface_albedo: wp.array2d(dtype=wp.vec3),
    sums: wp.array2d(dtype=wp.vec4),  # and number of samples
    background: wp.array2d(dtype=wp.vec4),
    first_row: int,
    # out
    color: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
):
    y, x = wp.tid()
    y += first_row
    n = wp.max(sums[y, x][3], 1.0)
    behind = background[y, x]
    radiance = wp.cw_mul(xyz(irradiance[y, x]), surface_albedo[y, x]) * ((n - behind[3]) / n) + xyz(behind) / n
    color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)


@wp.func
def mirror_index(i: int, length: int):
    """Mirror an index at both ends of 0 … length - 1."""
    if i < 0:
        i = -1 - i
    if i >= length:
        i = 2 * length - 1 - i
    return wp.clamp(i, 0, length - 1)


@wp.kernel(enable_backward=False)
def average_with_margin(
    color: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    background: wp.array2d(dtype=wp.vec4),
    albedo: wp.array2d(dtype=wp.vec3),
    normal_depth: wp.array2d(dtype=wp.vec4),
    margin: int,  # border of mirrored pixels
    first_row: int,
    # out, larger by the margin on each side
    mean_color: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
    mean_albedo: wp.array2d(dtype=wp.vec3),  # 0 to 1
    mean_normal: wp.array2d(dtype=wp.vec3),
):
    y, x = wp.tid()
    y += first_row
    v = mirror_index(y - margin, color.shape[0])
    u = mirror_index(x - margin, color.shape[1])
    n = wp.max(color[v, u][3], 1.0)
    radiance = xyz(color[v, u]) / n
    mean_color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)
    # The networks expect white albedo where no surface was hit.
    mean_albedo[y, x] = wp.min((albedo[v, u] + wp.vec3(background[v, u][3])) / n, wp.vec3(1.0))
    mean_normal[y, x] = xyz(normal_depth[v, u]) / n


@wp.kernel(enable_backward=False)
def block_luminance(
    color: wp.array2d(dtype=wp.vec4),  # radiance [nits]
    first_row: int,
    # out
    mean: wp.array2d(dtype=wp.float32),  # luminance of each block of pixels [nits]
):
    row, column = wp.tid()
    row += first_row
    total = float(0.0)
    bottom = wp.min((row + 1) * BLOCK_PIXELS, color.shape[0])
    right = wp.min((column + 1) * BLOCK_PIXELS, color.shape[1])
    for y in range(row * BLOCK_PIXELS, bottom):
        for x in range(column * BLOCK_PIXELS, right):
            total += luminance(xyz(color[y, x]))
    mean[row, column] = total / float((bottom - row * BLOCK_PIXELS) * (right - column * BLOCK_PIXELS))


@wp.kernel(enable_backward=False)
def blend(
    noisy: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    denoised: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
    noisy_weight: float,  # weight of the noisy image, 0 to 1
    first_row: int,
    # out
    color: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
):
    y, x = wp.tid()
    y += first_row
    mean = xyz(noisy[y, x]) / wp.max(noisy[y, x][3], 1.0)
    radiance = mean * noisy_weight + xyz(denoised[y, x]) * (1.0 - noisy_weight)
    color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)
