"""The edge-avoiding filter of the fast mode: light without its surface colours is smoothed, then put back on them.
At the end, what another filter takes instead of it, and mixing a filtered picture with what it was.

An à-trous wavelet (Dammertz et al., HPG 2010) whose weights know how noisy each pixel is (Schied et al., "SVGF", HPG
2017), over one frame alone: nothing is carried from frame to frame, so a picture never depends on the one before.
"""

import warp as wp

from usdsdg_render.kernels.color import luminance

# How many standard deviations two pixels may differ and still count as the same light.
LIGHT_SIGMAS = wp.constant(3.0)
NORMAL_POWER = wp.constant(64.0)
# Least albedo that light is divided by.
DARKEST = wp.constant(0.02)
# Side of the blocks of pixels whose brightness `levels` tells.
LEVEL_PIXELS = wp.constant(16)


@wp.func
def xyz(v: wp.vec4):
    return wp.vec3(v[0], v[1], v[2])


@wp.kernel(enable_backward=False)
def separate(
    color: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    background: wp.array2d(dtype=wp.vec4),
    albedo: wp.array2d(dtype=wp.vec3),
    normal_depth: wp.array2d(dtype=wp.vec4),
    square: wp.array2d(dtype=wp.float32),
    first_row: int,
    # out, of what hit a surface
    light: wp.array2d(dtype=wp.vec4),  # mean light over albedo [nits], and variance of its mean brightness
    guide: wp.array2d(dtype=wp.vec4),  # unit normal and mean depth; 0 where nothing hit, or all sides of a thing
    surface: wp.array2d(dtype=wp.vec3),  # mean albedo, not below DARKEST
):
    y, x = wp.tid()
    y += first_row
    # What lies behind an edge is added again at the end: times the albedo of the edge it would be another colour.
    seen = color[y, x] - background[y, x]
    n = wp.max(seen[3], 1.0)
    base = wp.max(albedo[y, x] / n, wp.vec3(DARKEST))
    mean = wp.cw_div(xyz(seen) / n, base)
    level = luminance(mean)
    # One sample says nothing of its own variance; count it as wholly uncertain.
    variance = wp.max(square[y, x] / n - level * level, 0.0) / n
    if n < 2.0:
        variance = level * level
    light[y, x] = wp.vec4(mean[0], mean[1], mean[2], variance)
    sums = normal_depth[y, x]
    normal = xyz(sums) / n
    length = wp.length(normal)
    guide[y, x] = wp.vec4(0.0)
    if length > 0.5:
        normal = normal / length
        guide[y, x] = wp.vec4(normal[0], normal[1], normal[2], sums[3] / n)
    surface[y, x] = base


@wp.func
def steepness(guide: wp.array2d(dtype=wp.vec4), y: int, x: int):
    """Change of depth from pixel to pixel: the smaller of the two sides, so that an edge does not count."""
    z = guide[y, x][3]
    left = wp.abs(z - guide[y, wp.max(x - 1, 0)][3])
    right = wp.abs(z - guide[y, wp.min(x + 1, guide.shape[1] - 1)][3])
    up = wp.abs(z - guide[wp.max(y - 1, 0), x][3])
    down = wp.abs(z - guide[wp.min(y + 1, guide.shape[0] - 1), x][3])
    return wp.max(wp.min(left, right), wp.min(up, down))


@wp.func
def steady_variance(light: wp.array2d(dtype=wp.vec4), y: int, x: int):
    """Variance smoothed over 3x3 pixels: a few samples estimate their own badly."""
    total = float(0.0)
    weights = float(0.0)
    for j in range(-1, 2):
        for i in range(-1, 2):
            v = y + j
            u = x + i
            if v >= 0 and u >= 0 and v < light.shape[0] and u < light.shape[1]:
                w = 1.0 / float((1 + wp.abs(i)) * (1 + wp.abs(j)))
                total += w * light[v, u][3]
                weights += w
    return total / weights


@wp.kernel(enable_backward=False)
def smooth(
    light: wp.array2d(dtype=wp.vec4),
    guide: wp.array2d(dtype=wp.vec4),
    step: int,  # pixels between taps
    first_row: int,
    # out
    smoothed: wp.array2d(dtype=wp.vec4),
):
    y, x = wp.tid()
    y += first_row
    here = light[y, x]
    normal = xyz(guide[y, x])
    if wp.dot(normal, normal) == 0.0:
        smoothed[y, x] = here
        return
    depth = guide[y, x][3]
    slope = steepness(guide, y, x)
    level = luminance(xyz(here))
    tolerance = LIGHT_SIGMAS * wp.sqrt(steady_variance(light, y, x)) + 1.0e-4 * level + 1.0e-8
    total = wp.vec3(0.0)
    variance = float(0.0)
    weights = float(0.0)
    for j in range(-2, 3):
        for i in range(-2, 3):
            v = y + j * step
            u = x + i * step
            if v >= 0 and u >= 0 and v < light.shape[0] and u < light.shape[1]:
                other = guide[v, u]
                alike = wp.dot(normal, xyz(other))
                if alike > 0.0:
                    # The B3 spline: 3/8, 1/4, 1/16.
                    a = wp.abs(i)
                    b = wp.abs(j)
                    w = wp.where(a == 0, 0.375, wp.where(a == 1, 0.25, 0.0625))
                    w *= wp.where(b == 0, 0.375, wp.where(b == 1, 0.25, 0.0625))
                    reach = slope * float(step * (a + b)) + 2.0e-3 * depth + 1.0e-12
                    there = light[v, u]
                    apart = wp.abs(depth - other[3]) / reach + wp.abs(level - luminance(xyz(there))) / tolerance
                    w *= wp.pow(alike, NORMAL_POWER) * wp.exp(-apart)
                    total += xyz(there) * w
                    variance += there[3] * w * w
                    weights += w
    total = total / weights
    smoothed[y, x] = wp.vec4(total[0], total[1], total[2], variance / (weights * weights))


@wp.kernel(enable_backward=False)
def combine(
    light: wp.array2d(dtype=wp.vec4),
    surface: wp.array2d(dtype=wp.vec3),
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
    radiance = wp.cw_mul(xyz(light[y, x]), surface[y, x]) * ((n - behind[3]) / n) + xyz(behind) / n
    color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)


@wp.func
def mirrored(i: int, length: int):
    """The place in 0 … length - 1 that a mirror at either end shows at `i`."""
    if i < 0:
        i = -1 - i
    if i >= length:
        i = 2 * length - 1 - i
    return wp.clamp(i, 0, length - 1)


@wp.kernel(enable_backward=False)
def average(
    color: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    background: wp.array2d(dtype=wp.vec4),
    albedo: wp.array2d(dtype=wp.vec3),
    normal_depth: wp.array2d(dtype=wp.vec4),
    margin: int,  # pixels around the picture, mirrored
    first_row: int,
    # out, larger by the margin on each side
    mean_color: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
    mean_albedo: wp.array2d(dtype=wp.vec3),  # 0 to 1
    mean_normal: wp.array2d(dtype=wp.vec3),
):
    y, x = wp.tid()
    y += first_row
    v = mirrored(y - margin, color.shape[0])
    u = mirrored(x - margin, color.shape[1])
    n = wp.max(color[v, u][3], 1.0)
    radiance = xyz(color[v, u]) / n
    mean_color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)
    # What hits nothing is white for the networks.
    mean_albedo[y, x] = wp.min((albedo[v, u] + wp.vec3(background[v, u][3])) / n, wp.vec3(1.0))
    mean_normal[y, x] = xyz(normal_depth[v, u]) / n


@wp.kernel(enable_backward=False)
def levels(
    color: wp.array2d(dtype=wp.vec4),  # radiance [nits]
    first_row: int,
    # out
    mean: wp.array2d(dtype=wp.float32),  # luminance of each block of pixels [nits]
):
    row, column = wp.tid()
    row += first_row
    total = float(0.0)
    bottom = wp.min((row + 1) * LEVEL_PIXELS, color.shape[0])
    right = wp.min((column + 1) * LEVEL_PIXELS, color.shape[1])
    for y in range(row * LEVEL_PIXELS, bottom):
        for x in range(column * LEVEL_PIXELS, right):
            total += luminance(xyz(color[y, x]))
    mean[row, column] = total / float((bottom - row * LEVEL_PIXELS) * (right - column * LEVEL_PIXELS))


@wp.kernel(enable_backward=False)
def mix(
    noisy: wp.array2d(dtype=wp.vec4),  # sums, and number of samples
    clean: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
    share: float,  # of the noisy picture, 0 to 1
    first_row: int,
    # out
    color: wp.array2d(dtype=wp.vec4),  # radiance [nits], one sample
):
    y, x = wp.tid()
    y += first_row
    before = xyz(noisy[y, x]) / wp.max(noisy[y, x][3], 1.0)
    radiance = before * share + xyz(clean[y, x]) * (1.0 - share)
    color[y, x] = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)
