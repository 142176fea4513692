"""What a path carries from one surface to the next, and what its light adds up to."""

import warp as wp

from usdsdg_render.kernels.cameras.camera import Ray
from usdsdg_render.kernels.color import luminance

# Rows of `FilmArrays.light_aovs`, in the order of `settings.LIGHT_AOVS`.
DIRECT_DIFFUSE = wp.constant(0)
DIRECT_SPECULAR = wp.constant(1)
INDIRECT_DIFFUSE = wp.constant(2)
REFLECTIONS = wp.constant(3)
REFRACTIONS = wp.constant(4)


@wp.struct
class PathOptions:
    """`settings.PathSettings` as kernels read it."""

    bounces: wp.int32  # surfaces a path may meet
    glass_bounces: wp.int32  # and faces of glass besides
    samples: wp.int32
    first_sample: wp.int32
    seed: wp.uint32
    frame: wp.uint32
    clamp: wp.float32  # most that one indirect contribution may add [nits]; 0 = no limit
    regularization: wp.float32  # least GGX alpha after a rough bounce
    features: wp.int32  # 1 = also sum what the denoiser needs
    light_aovs: wp.int32  # 1 = also sum the light by where it came from


@wp.struct
class Path:
    """A path on its way: the ray that it follows next, and what that is worth."""

    origin: wp.vec3
    direction: wp.vec3
    tmin: wp.float32
    tmax: wp.float32
    throughput: wp.vec3
    # Of the direction: its density, -1 for the camera's, and the glossy share of its weight.
    pdf: wp.float32
    glossy: wp.float32
    # Of the point that it leaves: instance, normal, and sum of the weights of all lights.
    instance: wp.int32
    normal: wp.vec3
    all_lights: wp.float32
    sky_share: wp.float32  # that of the camera
    fine_sky: wp.int32
    least_alpha: wp.float32
    refracting: wp.int32  # 1 = nothing rough was met yet, so glass bends the path; else it goes straight through
    met: wp.int32  # surfaces so far, without glass
    alive: wp.int32
    radiance: wp.vec3  # so far


@wp.struct
class LightAovs:
    """The radiance of a path by what its first surface did with the light, without what that gives off itself.

    They are always counted and stored only on demand: a flag within the loop over a path's surfaces makes the compiler
    double the loop, which costs more than the sums.
    """

    direct_diffuse: wp.vec3
    direct_specular: wp.vec3
    indirect_diffuse: wp.vec3
    reflections: wp.vec3
    refractions: wp.vec3
    # Of the direction in which the path left its first surface: the share of its weight that was mirrored, 1 = bent.
    mirrored: wp.vec3
    bent: wp.int32


@wp.struct
class Feature:
    """What the first surface of a path is, for the denoiser."""

    albedo: wp.vec3
    normal: wp.vec3
    depth: wp.float32


@wp.struct
class Connection:
    """Light that a surface scatters into the path if nothing is between the surface and the light."""

    direction: wp.vec3
    distance: wp.float32
    light: wp.vec3  # [nits]; 0 = none
    diffuse: wp.vec3  # share of the light that was not mirrored
    most: wp.float32  # what it may add at most; 0 = no limit


@wp.func
def begin_path(ray: Ray, sky_share: float):
    """The path of a camera ray; dead where the lens lets no light in."""
    path = Path()
    path.origin = ray.origin
    path.direction = ray.direction
    path.tmin = ray.tmin
    path.tmax = ray.tmax
    path.throughput = wp.vec3(1.0)
    path.pdf = -1.0
    path.sky_share = sky_share
    path.instance = -1
    path.refracting = 1
    if ray.tmin <= ray.tmax:
        path.alive = 1
    return path


@wp.func
def limited(color: wp.vec3, most: float):
    """Scale a contribution down to luminance `most`."""
    y = luminance(color)
    if most > 0.0 and y > most:
        return color * (most / y)
    return color


@wp.func
def add_light_aov(light_aovs: LightAovs, light: wp.vec3, diffuse: wp.vec3, bounce: int):
    """Count light that surface number `bounce`, from 0, scatters; `diffuse` is the share of it that is not mirrored."""
    if light_aovs.bent != 0:
        light_aovs.refractions += light
    elif bounce == 0:
        light_aovs.direct_diffuse += wp.cw_mul(light, diffuse)
        light_aovs.direct_specular += wp.cw_mul(light, wp.vec3(1.0) - diffuse)
    else:
        light_aovs.indirect_diffuse += wp.cw_mul(light, wp.vec3(1.0) - light_aovs.mirrored)
        light_aovs.reflections += wp.cw_mul(light, light_aovs.mirrored)
    return light_aovs
