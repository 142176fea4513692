"""`from omni.replicator.core.scripts.writers_default.tools import colorize_normals`."""

from usdsdg.tools import (
    binary_mask_to_rle,
    colorize_bbox_2d,
    colorize_distance,
    colorize_motion_vector,
    colorize_normals,
    colorize_segmentation,
    data_to_colour,
    random_colours,
    random_colours_id,
)

__all__ = [
    "binary_mask_to_rle", "colorize_bbox_2d", "colorize_distance", "colorize_motion_vector", "colorize_normals",
    "colorize_segmentation", "data_to_colour", "random_colours", "random_colours_id",
]  # fmt: skip
