"""The color space of the renderer and of colors on a stage: linear Rec. 709."""

import numpy as np

# Weights of red, green and blue in the luminance of a linear color.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LUMINANCE.setflags(write=False)
