"""The annotators, one module for each group of related outputs. Importing this package registers them all."""

# One row a module. The order is that of `annotators.get_registered_annotators()`.
from usdsdg.annotators.kinds import (  # noqa: F401
    amodal,
    boxes,
    camera,
    correspondence,
    image,
    keypoints,
    light,
    matte,
    object_coordinates,
    object_poses,
    oriented_boxes,
    pointcloud,
    segmentation,
    shading,
    skeleton,
    stage_values,
    truncation,
)
from usdsdg.annotators.kinds.depth import depth_camera  # noqa: F401
