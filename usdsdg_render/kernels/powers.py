"""Powers without library functions, which on a CPU take longer than the rest of a filter's tap."""

import warp as wp

# Two to a power from -1 to 0 is a polynomial that was fitted at Chebyshev nodes, with a relative error of 3e-7; whole
# powers are bits of the exponent.
_EXP_OF_MINUS = """
#if defined(__CUDA_ARCH__)
    return __expf(-x);
#else
    const float power = x * 1.44269504f;
    if (!(power < 126.0f)) return 0.0f;
    const int whole = (int)power;
    const float f = power - (float)whole;
    const float part = 0.999999944f + f * (-0.693143135f + f * (0.240178956f + f * (-0.0552981197f
        + f * (0.00920918036f + f * -0.000946877029f))));
    const wp::uint32 bits = (wp::uint32)(127 - whole) << 23;
    float scale;
    memcpy(&scale, &bits, 4);
    return part * scale;
#endif
"""


@wp.func_native(_EXP_OF_MINUS)
def exp_of_minus(x: float) -> float:  # pyright: ignore[reportReturnType]
    """Return exp(-x) for x >= 0; 0 below the smallest normal float, and for NaN."""


@wp.func
def power_64(x: float):
    """Return the 64th power."""
    x2 = x * x
    x4 = x2 * x2
    x8 = x4 * x4
    x16 = x8 * x8
    x32 = x16 * x16
    return x32 * x32
