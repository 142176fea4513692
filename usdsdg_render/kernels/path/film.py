"""Film: running sums per pixel, and adding one sample to those of a pixel."""

import warp as wp

from usdsdg_render.kernels.color import luminance
from usdsdg_render.kernels.path.path_state import (
    DIRECT_DIFFUSE,
    DIRECT_SPECULAR,
    INDIRECT_DIFFUSE,
    REFLECTIONS,
    REFRACTIONS,
    DenoiserFeatures,
    LightAovs,
    PathOptions,
)


@wp.struct
class FilmArrays:
    """Running sums per pixel, (height, width); features and light AOVs are empty unless allocated."""

    color: wp.array2d(dtype=wp.vec4)  # radiance [nits] and number of samples
    # Radiance [nits] of samples that hit no surface, and of surfaces that shine themselves; the number of the former.
    background: wp.array2d(dtype=wp.vec4)
    albedo: wp.array2d(dtype=wp.vec3)  # this and the next two: of samples that hit a surface
    normal_depth: wp.array2d(dtype=wp.vec4)  # world normal, distance of the first hit [stage units]
    square: wp.array2d(dtype=wp.float32)  # squared luminance of scattered radiance divided by albedo
    dropped: wp.array2d(dtype=wp.int32)  # samples that were not finite
    light_aovs: wp.array3d(dtype=wp.vec3)  # radiance by `settings.LIGHT_AOVS`, (len(LIGHT_AOVS), height, width)


@wp.struct
class PixelSums:
    """Running sums of one pixel."""

    color: wp.vec4
    background: wp.vec4
    albedo: wp.vec3
    normal_depth: wp.vec4
    square: wp.float32
    dropped: wp.int32
    light_aovs: LightAovs


@wp.func
def load_pixel(film: FilmArrays, options: PathOptions, y: int, x: int):
    sums = PixelSums()
    sums.color = film.color[y, x]
    if options.features != 0:
        sums.background = film.background[y, x]
        sums.albedo = film.albedo[y, x]
        sums.normal_depth = film.normal_depth[y, x]
        sums.square = film.square[y, x]
    if options.light_aovs != 0:
        sums.light_aovs.direct_diffuse = film.light_aovs[DIRECT_DIFFUSE, y, x]
        sums.light_aovs.direct_specular = film.light_aovs[DIRECT_SPECULAR, y, x]
        sums.light_aovs.indirect_diffuse = film.light_aovs[INDIRECT_DIFFUSE, y, x]
        sums.light_aovs.reflections = film.light_aovs[REFLECTIONS, y, x]
        sums.light_aovs.refractions = film.light_aovs[REFRACTIONS, y, x]
    return sums


@wp.func
def with_sample(
    sums: PixelSums, options: PathOptions, radiance: wp.vec3, features: DenoiserFeatures, light_aovs: LightAovs
):
    """Add one sample; a sample that is not finite is counted as dropped instead."""
    if wp.isfinite(radiance[0]) and wp.isfinite(radiance[1]) and wp.isfinite(radiance[2]):
        sample = wp.vec4(radiance[0], radiance[1], radiance[2], 1.0)
        sums.color += sample
        if options.features != 0 and features.depth == 0.0:
            sums.background += sample
        elif options.features != 0:
            own = features.emission
            sums.background += wp.vec4(own[0], own[1], own[2], 0.0)
            sums.albedo += features.albedo
            sums.normal_depth += wp.vec4(features.normal[0], features.normal[1], features.normal[2], features.depth)
            demodulated = luminance(wp.cw_div(radiance - own, wp.max(features.albedo, wp.vec3(0.01))))
            sums.square += demodulated * demodulated
        if options.light_aovs != 0:
            sums.light_aovs.direct_diffuse += light_aovs.direct_diffuse
            sums.light_aovs.direct_specular += light_aovs.direct_specular
            sums.light_aovs.indirect_diffuse += light_aovs.indirect_diffuse
            sums.light_aovs.reflections += light_aovs.reflections
            sums.light_aovs.refractions += light_aovs.refractions
    else:
        sums.dropped += 1
    return sums


@wp.func
def store_pixel(film: FilmArrays, options: PathOptions, y: int, x: int, sums: PixelSums):
    film.color[y, x] = sums.color
    if options.features != 0:
        film.background[y, x] = sums.background
        film.albedo[y, x] = sums.albedo
        film.normal_depth[y, x] = sums.normal_depth
        film.square[y, x] = sums.square
    if options.light_aovs != 0:
        film.light_aovs[DIRECT_DIFFUSE, y, x] = sums.light_aovs.direct_diffuse
        film.light_aovs[DIRECT_SPECULAR, y, x] = sums.light_aovs.direct_specular
        film.light_aovs[INDIRECT_DIFFUSE, y, x] = sums.light_aovs.indirect_diffuse
        film.light_aovs[REFLECTIONS, y, x] = sums.light_aovs.reflections
        film.light_aovs[REFRACTIONS, y, x] = sums.light_aovs.refractions
    if sums.dropped > 0:
        film.dropped[y, x] = film.dropped[y, x] + sums.dropped
