"""Records of the paths in flight, in planes of 16-byte words: word w of path number n is `planes[w, n]`.

Neighboring threads mostly hold neighboring paths. In an array of structs, each 4-byte member that they load or store is
in a sector of memory of its own; in planes, 32 threads move 512 contiguous bytes at once. Words that a kernel does not
use are not loaded: the compiler leaves such loads out.
"""

# Code of Warp kernels is not Python to a type checker.
# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportInvalidTypeForm=false

import warp as wp

from usdsdg_render.kernels.path.path_state import DenoiserFeatures, Path, ShadowRay
from usdsdg_render.scene.structs import Hit

# Words of each record.
PATH_WORDS, SHADOW_RAY_WORDS, HIT_WORDS, FEATURE_WORDS = 6, 3, 2, 3

# Warp's vec4 is aligned to 4 bytes; CUDA's float4, to 16, is moved by one instruction.
_LOAD = """
#if defined(__CUDA_ARCH__)
    const float4 moved = ((const float4*)planes.data)[(size_t)word * planes.shape[1] + number];
    return wp::vec_t<4, float>(moved.x, moved.y, moved.z, moved.w);
#else
    return planes.data[(size_t)word * planes.shape[1] + number];
#endif
"""
_STORE = """
#if defined(__CUDA_ARCH__)
    ((float4*)planes.data)[(size_t)word * planes.shape[1] + number] = make_float4(a[0], a[1], a[2], b);
#else
    planes.data[(size_t)word * planes.shape[1] + number] = wp::vec_t<4, float>(a[0], a[1], a[2], b);
#endif
"""


@wp.func_native(_LOAD)
def load(planes: wp.array2d(dtype=wp.vec4), word: int, number: int) -> wp.vec4: ...


@wp.func_native(_STORE)
def store(planes: wp.array2d(dtype=wp.vec4), word: int, number: int, a: wp.vec3, b: float): ...


@wp.func
def first_three(word: wp.vec4):
    return wp.vec3(word[0], word[1], word[2])


@wp.func
def store_path(planes: wp.array2d(dtype=wp.vec4), number: int, path: Path):
    store(planes, 0, number, path.origin, path.tmin)
    store(planes, 1, number, path.direction, path.tmax)
    store(planes, 2, number, path.throughput, path.pdf)
    store(planes, 3, number, path.normal, path.light_weight_sum)
    weights = wp.vec3(path.specular_fraction, path.environment_weight, path.min_alpha)
    store(planes, 4, number, weights, wp.cast(path.instance, wp.float32))
    store_radiance(planes, number, path)


@wp.func
def store_radiance(planes: wp.array2d(dtype=wp.vec4), number: int, path: Path):
    """Store the radiance of a path, and its counters, which share a word."""
    flags = path.bounces * 8 + path.alive * 4 + path.can_refract * 2 + path.fine_environment
    store(planes, 5, number, path.radiance, wp.cast(flags, wp.float32))


@wp.func
def load_path(planes: wp.array2d(dtype=wp.vec4), number: int):
    origin = load(planes, 0, number)
    direction = load(planes, 1, number)
    throughput = load(planes, 2, number)
    normal = load(planes, 3, number)
    weights = load(planes, 4, number)
    radiance = load(planes, 5, number)
    flags = wp.cast(radiance[3], wp.int32)
    return Path(
        origin=first_three(origin),
        direction=first_three(direction),
        tmin=origin[3],
        tmax=direction[3],
        throughput=first_three(throughput),
        pdf=throughput[3],
        specular_fraction=weights[0],
        instance=wp.cast(weights[3], wp.int32),
        normal=first_three(normal),
        light_weight_sum=normal[3],
        environment_weight=weights[1],
        fine_environment=flags & 1,
        min_alpha=weights[2],
        can_refract=(flags >> 1) & 1,
        bounces=flags >> 3,
        alive=(flags >> 2) & 1,
        radiance=first_three(radiance),
    )


@wp.func
def store_hit(planes: wp.array2d(dtype=wp.vec4), number: int, hit: Hit):
    """Store a hit of a surface."""
    store(planes, 0, number, wp.vec3(hit.t, hit.u, hit.v), wp.cast(hit.instance, wp.float32))
    store(planes, 1, number, wp.vec3(wp.cast(hit.triangle, wp.float32), 0.0, 0.0), 0.0)


@wp.func
def load_hit(planes: wp.array2d(dtype=wp.vec4), number: int):
    word = load(planes, 0, number)
    triangle = wp.cast(load(planes, 1, number)[0], wp.int32)
    return Hit(t=word[0], u=word[1], v=word[2], instance=wp.cast(word[3], wp.int32), triangle=triangle)


@wp.func
def store_shadow_ray(planes: wp.array2d(dtype=wp.vec4), number: int, ray: ShadowRay):
    store(planes, 0, number, ray.direction, ray.distance)
    store(planes, 1, number, ray.radiance, ray.clamp)
    store(planes, 2, number, ray.diffuse_fraction, 0.0)


@wp.func
def load_shadow_ray(planes: wp.array2d(dtype=wp.vec4), number: int):
    direction = load(planes, 0, number)
    radiance = load(planes, 1, number)
    return ShadowRay(
        direction=first_three(direction),
        distance=direction[3],
        radiance=first_three(radiance),
        diffuse_fraction=first_three(load(planes, 2, number)),
        clamp=radiance[3],
    )


@wp.func
def store_features(planes: wp.array2d(dtype=wp.vec4), number: int, features: DenoiserFeatures):
    store(planes, 0, number, features.albedo, features.depth)
    store(planes, 1, number, features.normal, 0.0)
    store(planes, 2, number, features.emission, 0.0)


@wp.func
def load_features(planes: wp.array2d(dtype=wp.vec4), number: int):
    albedo = load(planes, 0, number)
    return DenoiserFeatures(
        albedo=first_three(albedo),
        normal=first_three(load(planes, 1, number)),
        depth=albedo[3],
        emission=first_three(load(planes, 2, number)),
    )
