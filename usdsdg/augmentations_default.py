"""Replicator's default augmentations as functions (`rep.augmentations_default`), for direct calls or for
`Augmentation.from_function`. Where Replicator has Warp kernels these are NumPy functions of `data_in`.
"""

from usdsdg.annotators.augmentations.colors import adjust_sigmoid as aug_adjust_sigmoid
from usdsdg.annotators.augmentations.colors import brightness as aug_brightness
from usdsdg.annotators.augmentations.colors import colorize_depth, colorize_normals, rgba_to_rgb
from usdsdg.annotators.augmentations.colors import hsv_to_rgb as aug_hsv_to_rgb
from usdsdg.annotators.augmentations.colors import rgb_to_hsv as aug_rgb_to_hsv
from usdsdg.annotators.augmentations.filters import sobel as sobel_edges
from usdsdg.annotators.augmentations.noise import glass_blur as aug_glass_blur
from usdsdg.annotators.augmentations.noise import shot_noise as aug_shot_noise
from usdsdg.annotators.augmentations.noise import speckle_noise as aug_speckle_noise

__all__ = [
    "aug_adjust_sigmoid", "aug_brightness", "aug_glass_blur", "aug_hsv_to_rgb", "aug_rgb_to_hsv", "aug_shot_noise",
    "aug_speckle_noise", "colorize_depth", "colorize_normals", "rgba_to_rgb", "sobel_edges",
]  # fmt: skip
