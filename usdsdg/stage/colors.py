"""The color space of the renderer and of colors on a stage, linear Rec. 709, and that of pictures, sRGB."""

import numpy as np

# Weights of red, green and blue in the luminance of a linear color.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LUMINANCE.setflags(write=False)


def srgb_to_linear(values: np.ndarray) -> np.ndarray:
    """Return the linear values of sRGB-coded ones, 0 to 1; of negative ones a continuation."""
    return np.where(values <= 0.04045, values / 12.92, ((np.maximum(values, 0.0) + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(values: np.ndarray) -> np.ndarray:
    """Return the inverse of `srgb_to_linear`."""
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055)
