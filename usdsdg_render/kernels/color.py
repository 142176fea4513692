"""Colors in linear Rec. 709."""

import warp as wp

from usdsdg.stage.colors import LUMINANCE

RED, GREEN, BLUE = (wp.constant(weight) for weight in LUMINANCE.tolist())


@wp.func
def luminance(color: wp.vec3):
    """Luminance of a color, relative to white."""
    return RED * color[0] + GREEN * color[1] + BLUE * color[2]


@wp.func
def fraction(part: float, whole: float):
    """Return the fraction of a whole, exactly 1 where there is nothing else, even by an approximate division."""
    if part == whole and part > 0.0:
        return 1.0
    return part / wp.max(whole, 1.0e-30)


@wp.func
def fractions(part: wp.vec3, whole: wp.vec3):
    """Return `fraction` of each color."""
    return wp.vec3(fraction(part[0], whole[0]), fraction(part[1], whole[1]), fraction(part[2], whole[2]))
