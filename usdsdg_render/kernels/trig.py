"""Trigonometry by short polynomials, with angles in turns: library functions are too slow in a path tracer.

The polynomials of atan and acos were fitted at Chebyshev nodes; those of cos and sin are truncated Taylor series.
Errors are at most 2e-7 turns, and 4e-7 of cosines and sines.
"""

import warp as wp

# Cosine and sine of an angle in turns.
_COS_SIN = """
    const float quarters = turns * 4.0f;
    const int nearest = (int)(quarters < 0.0f ? quarters - 0.5f : quarters + 0.5f);
    const float x = (quarters - nearest) * 1.57079632679f, x2 = x * x;
    const float s = x + x * x2 * (-1.6666667e-1f + x2 * (8.3333310e-3f + x2 * -1.9840874e-4f));
    const float c = 1.0f + x2 * (-0.5f + x2 * (4.1666638e-2f + x2 * (-1.3888378e-3f + x2 * 2.4760495e-5f)));
    const bool odd = nearest & 1, flip_cos = (nearest + 1) & 2, flip_sin = nearest & 2;
    const float a = odd ? s : c, b = odd ? c : s;
    return wp::vec_t<2, wp::float32>(flip_cos ? -a : a, flip_sin ? -b : b);
"""

# Angle of (x, y) from the x axis, in [0, 1].
_AZIMUTH_TURNS = """
    const float ax = x < 0.0f ? -x : x, ay = y < 0.0f ? -y : y;
    const float low = ax < ay ? ax : ay, high = ax < ay ? ay : ax;
    const float q = high > 0.0f ? low / high : 0.0f, p = q * q;
    float r = q * (0.159154836f + p * (-0.0530405724f + p * (0.0316397992f + p * (-0.0214547319f
        + p * (0.0133278827f + p * (-0.00587259924f + p * 0.00124546429f))))));
    r = ay > ax ? 0.25f - r : r;
    r = x < 0.0f ? 0.5f - r : r;
    return y < 0.0f && r > 0.0f ? 1.0f - r : r;
"""

# acos(z) / pi for |z| <= 1.
_ACOS_OVER_PI = """
    const float a = z < 0.0f ? -z : z;
    const float rest = a < 1.0f ? 1.0f - a : 0.0f;
    const float r = ::sqrtf(rest) * (0.499999944f + a * (-0.0683041119f + a * (0.028245969f
        + a * (-0.0155094589f + a * (0.00851457659f + a * (-0.00350535137f + a * 0.000716632774f))))));
    return z < 0.0f ? 1.0f - r : r;
"""


@wp.func_native(_COS_SIN)
def cos_sin(turns: float) -> wp.vec2: ...


@wp.func_native(_AZIMUTH_TURNS)
def azimuth_turns(x: float, y: float) -> float: ...


@wp.func_native(_ACOS_OVER_PI)
def acos_over_pi(z: float) -> float: ...
