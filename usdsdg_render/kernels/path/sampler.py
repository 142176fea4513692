"""Sample points: a padded two-dimensional Sobol sequence with hashed Owen scrambling.

Every number is a function of (seed, frame, pixel, sample, dimension) alone. Each pair of dimensions is a Sobol (0, 2)
sequence with its own shuffled index, so that a pair is well stratified and pairs are decorrelated.
Sources: Burley, "Practical Hash-based Owen Scrambling" (JCGT 2020) for the construction; Vegdahl's constants for the
hash of Laine and Karras.
"""

import warp as wp

# Dimensions come in pairs: two for the camera, then three for each segment.
PAIR_PIXEL = wp.constant(0)
PAIR_LENS = wp.constant(1)
PAIR_FIRST_SEGMENT = wp.constant(2)
PAIRS_PER_SEGMENT = wp.constant(3)
PAIR_LIGHT = wp.constant(0)
PAIR_LOBE = wp.constant(1)
PAIR_OPACITY = wp.constant(2)

_HASH = """
    wp::uint32 h = a * 0x9e3779b9u ^ b;
    h ^= h >> 16; h *= 0x21f0aaadu; h ^= h >> 15; h *= 0x735a2d97u; h ^= h >> 15;
    return h;
"""

# Reversed, the generator matrix of the second Sobol dimension is Pascal's triangle modulo two: bit b of the result
# is the sum of all bits of the index whose position contains b, which five masked shifts collect.
_PAIR = """
#if defined(__CUDA_ARCH__)
    #define REVERSE_BITS(x) __brev(x)
#else
    #define REVERSE_BITS(x) __builtin_bitreverse32(x)
#endif
    auto scramble = [](wp::uint32 x, wp::uint32 s) -> wp::uint32 {
        x ^= x * 0x3d20adeau; x += s; x *= (s >> 16) | 1u; x ^= x * 0x05526c56u; x ^= x * 0x53a22864u;
        return x;
    };
    wp::uint32 h = seed ^ ((wp::uint32)pair * 0x9e3779b9u);
    h ^= h >> 16; h *= 0x21f0aaadu; h ^= h >> 15; h *= 0x735a2d97u; h ^= h >> 15;
    const wp::uint32 i = REVERSE_BITS(scramble(REVERSE_BITS(index), h));
    wp::uint32 j = i;
    j ^= (j >> 1) & 0x55555555u; j ^= (j >> 2) & 0x33333333u; j ^= (j >> 4) & 0x0f0f0f0fu;
    j ^= (j >> 8) & 0x00ff00ffu; j ^= (j >> 16) & 0x0000ffffu;
    const wp::uint32 x = REVERSE_BITS(scramble(i, h * 0x2c1b3c6du + 0x297a2d39u));
    const wp::uint32 y = REVERSE_BITS(scramble(j, h * 0x85ebca6bu + 0xc2b2ae35u));
    return wp::vec_t<2, wp::float32>((x >> 8) * 0x1p-24f, (y >> 8) * 0x1p-24f);
"""


@wp.func_native(_HASH)
def hash_pair(a: wp.uint32, b: wp.uint32) -> wp.uint32: ...


@wp.func_native(_PAIR)
def sample_pair(seed: wp.uint32, index: wp.uint32, pair: int) -> wp.vec2: ...


@wp.func
def pixel_seed(seed: wp.uint32, frame: wp.uint32, x: int, y: int):
    """Return the scramble seed of one pixel of one frame."""
    return hash_pair(hash_pair(hash_pair(seed, frame), wp.uint32(x)), wp.uint32(y))
