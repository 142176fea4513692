"""Colors in linear Rec. 709."""

import warp as wp

from usdsdg.stage.colors import LUMINANCE

RED, GREEN, BLUE = (wp.constant(weight) for weight in LUMINANCE.tolist())


@wp.func
def luminance(color: wp.vec3):
    """Luminance of a color, relative to white."""
    return RED * color[0] + GREEN * color[1] + BLUE * color[2]
