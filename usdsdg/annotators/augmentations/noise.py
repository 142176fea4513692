"""Augmentations that add noise. Images are uint8 (H, W, 3 or 4); alpha does not change."""

import numpy as np

from usdsdg.annotators.augmentations.colors import to_bytes, with_rgb
from usdsdg.annotators.augmentations.signatures import kernel_in_replicator
from usdsdg.graph.sampling import generator


@kernel_in_replicator
def speckle_noise(data_in: np.ndarray, sigma: float = 0.5, seed: int = 0) -> np.ndarray:
    """Add multiplicative noise: value * (1 + sigma * n), with n from a standard normal distribution."""
    noise = _normals(data_in, seed, "speckle_noise")
    return with_rgb(data_in, to_bytes(data_in[..., :3] * (1 + np.float32(sigma) * noise)))


@kernel_in_replicator
def shot_noise(data_in: np.ndarray, sigma: float = 0.5, seed: int = 0) -> np.ndarray:
    """Add photon shot noise: value + n * sqrt(value / sigma), for values in 0..1 and n from a standard normal
    distribution.

    sigma: number of photons at full brightness; larger values give less noise.

    Raises:
        ValueError: sigma is not above 0.
    """
    if not sigma > 0:
        raise ValueError(f"sigma is {sigma!r}; expected a number above 0")
    values = data_in[..., :3] / np.float32(255)
    return with_rgb(data_in, to_bytes(255 * (values + _normals(data_in, seed, "shot_noise") * np.sqrt(values / sigma))))


@kernel_in_replicator
def glass_blur(data_in: np.ndarray, delta: int = 4, seed: int = 0) -> np.ndarray:
    """Replace each pixel's color by that of a random pixel at most `delta` rows and columns away.

    Raises:
        ValueError: delta is below 1.
    """
    if delta < 1:
        raise ValueError(f"delta is {delta!r}; expected a whole number above 0")
    height, width = data_in.shape[:2]
    steps = generator(seed, "glass_blur", 0).integers(-int(delta), int(delta) + 1, (2, height, width))
    rows, columns = np.mgrid[:height, :width] + steps
    return with_rgb(data_in, data_in[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1), :3])


def _normals(image: np.ndarray, seed: int, what: str) -> np.ndarray:
    """Draw (H, W, 3) float32 from a standard normal distribution."""
    return generator(seed, what, 0).standard_normal((*image.shape[:2], 3), np.float32)
