"""State of a path between two segments, and its accumulated radiance."""

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
    """Device form of `settings.PathSettings`."""

    bounces: wp.int32  # maximum number of surfaces, without glass
    glass_bounces: wp.int32  # maximum number of additional glass interfaces
    samples: wp.int32
    first_sample: wp.int32
    seed: wp.uint32
    frame: wp.uint32
    clamp: wp.float32  # firefly clamp of indirect contributions [nits]; 0 = none
    regularization: wp.float32  # minimum GGX alpha after a rough bounce
    features: wp.int32  # 1 = also accumulate denoiser features
    light_aovs: wp.int32  # 1 = also accumulate light AOVs


@wp.struct
class Path:
    """A path: the ray of its next segment, throughput, and what MIS and regularization need of the last vertex."""

    origin: wp.vec3
    direction: wp.vec3
    tmin: wp.float32
    tmax: wp.float32
    throughput: wp.vec3
    pdf: wp.float32  # of the direction [1/sr]; -1 for camera rays
    specular_fraction: wp.float32  # specular fraction of the last BSDF weight, by luminance
    # The last vertex: instance, normal, and sum of the selection weights of all lights there.
    instance: wp.int32
    normal: wp.vec3
    light_weight_sum: wp.float32
    environment_weight: wp.float32  # of the camera, see `structs.Camera`
    fine_environment: wp.int32  # 1 = look up the full-resolution environment map, 0 = its coarse grid
    min_alpha: wp.float32  # path regularization: lower bound on GGX alpha
    can_refract: wp.int32  # 1 = no rough surface so far, so glass refracts; 0 = glass is passed straight
    bounces: wp.int32  # surfaces so far, without glass
    alive: wp.int32
    radiance: wp.vec3  # accumulated so far [nits]


@wp.struct
class LightAovs:
    """Radiance of a path split by how its first surface scattered it, without that surface's emission.

    Always computed, stored only on demand: a flag inside of the loop over segments makes the compiler duplicate the
    loop, which costs more than the sums.
    """

    direct_diffuse: wp.vec3
    direct_specular: wp.vec3
    indirect_diffuse: wp.vec3
    reflections: wp.vec3
    refractions: wp.vec3
    specular_fraction: wp.vec3  # of the BSDF weight at the first surface
    refracted: wp.int32  # 1 = the path was transmitted at the first surface


@wp.struct
class DenoiserFeatures:
    """First-hit features that guide the denoisers; depth 0 = no surface was hit."""

    albedo: wp.vec3
    normal: wp.vec3
    depth: wp.float32
    emission: wp.vec3  # of that surface [nits]


@wp.struct
class ShadowRay:
    """Next-event estimation: a ray to a sampled light, and the radiance that it adds if it is not occluded."""

    direction: wp.vec3
    distance: wp.float32
    radiance: wp.vec3  # [nits]; 0 = none
    diffuse_fraction: wp.vec3  # fraction of the radiance that the diffuse lobe scattered
    clamp: wp.float32  # firefly clamp [nits]; 0 = none


@wp.struct
class PathUpdate:
    """A path and its light AOVs after radiance was added."""

    path: Path
    light_aovs: LightAovs


@wp.struct
class Scattering:
    """Result of scattering at a surface: a shadow ray to trace, and the path of the next segment unless it is dead."""

    path: Path
    light_aovs: LightAovs
    shadow_ray: ShadowRay
    features: DenoiserFeatures


@wp.func
def begin_path(ray: Ray, environment_weight: float):
    """Start a path at a camera ray; dead where the lens transmits no light."""
    path = Path()
    path.origin = ray.origin
    path.direction = ray.direction
    path.tmin = ray.tmin
    path.tmax = ray.tmax
    path.throughput = wp.vec3(1.0)
    path.pdf = -1.0
    path.environment_weight = environment_weight
    path.instance = -1
    path.can_refract = 1
    if ray.tmin <= ray.tmax:
        path.alive = 1
    return path


@wp.func
def firefly_clamp(path: Path, options: PathOptions):
    """Return the firefly clamp [nits] of what reaches the path's last vertex: 0, none, for direct light."""
    if path.bounces > 1:
        return options.clamp
    return 0.0


@wp.func
def clamp_firefly(color: wp.vec3, max_luminance: float):
    """Scale a contribution down to `max_luminance` [nits]; 0 = no clamp."""
    y = luminance(color)
    if max_luminance > 0.0 and y > max_luminance:
        return color * (max_luminance / y)
    return color


@wp.func
def add_light_aov(light_aovs: LightAovs, radiance: wp.vec3, diffuse_fraction: wp.vec3, segment: int):
    """Add radiance that the surface at the end of a segment scattered.

    Args:
        diffuse_fraction: of the radiance; read at the first surface only.
        segment: number of the segment, from 0.
    """
    if light_aovs.refracted != 0:
        light_aovs.refractions += radiance
    elif segment == 0:
        light_aovs.direct_diffuse += wp.cw_mul(radiance, diffuse_fraction)
        light_aovs.direct_specular += wp.cw_mul(radiance, wp.vec3(1.0) - diffuse_fraction)
    else:
        light_aovs.indirect_diffuse += wp.cw_mul(radiance, wp.vec3(1.0) - light_aovs.specular_fraction)
        light_aovs.reflections += wp.cw_mul(radiance, light_aovs.specular_fraction)
    return light_aovs


@wp.func
def add_radiance(update: PathUpdate, radiance: wp.vec3, segment: int):
    """Add radiance that arrives along the path's ray at its last vertex."""
    update.path.radiance += radiance
    if segment > 0:
        update.light_aovs = add_light_aov(
            update.light_aovs, radiance, wp.vec3(1.0) - update.light_aovs.specular_fraction, segment - 1
        )
    return update
