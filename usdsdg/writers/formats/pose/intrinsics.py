"""The intrinsics of pose files: always those of a pinhole, as in Replicator's."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.errors import warn_once


def intrinsics(writer: str, camera: Mapping[str, Any]) -> dict[str, float]:
    """Return fx, fy, cx, cy [pixels from the corner of the image]; warn where the lens is another one.

    camera: payload of camera_params.
    """
    model = str(camera["cameraModel"])
    if model != "pinhole":
        warn_once(
            f"{writer}: fx and fy of a camera of model {model!r} do not describe its projection: they are, as in "
            "Replicator, those of a pinhole with its focal length. The projected keypoints are correct."
        )
    width, height = (int(size) for size in camera["renderProductResolution"])
    projection = np.asarray(camera["cameraProjection"], np.float64).reshape(4, 4)
    focal = float(camera["cameraFocalLength"]) / (float(camera["cameraAperture"][0]) / width)
    return {
        "fx": focal,
        "fy": focal,
        # The principal point: the image center unless the aperture has an offset.
        "cx": float((1 - projection[2, 0]) * width / 2),
        "cy": float((1 + projection[2, 1]) * height / 2),
    }
