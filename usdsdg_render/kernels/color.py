"""Colours in linear Rec. 709."""

import warp as wp


@wp.func
def luminance(color: wp.vec3):
    """How bright a colour looks, relative to white."""
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
