"""The camera that Isaac Sim's pose annotators, `dope` and `pose`, compute with."""

from collections.abc import Mapping
from typing import Any

from usdsdg.annotators import named_annotators


def register_pose_camera(annotator: str, config_data: Mapping[str, Any], *, width: str, height: str) -> None:
    """Register a pose annotator anew, with a camera for the writers that are initialized from now on.

    config_data: WIDTH and HEIGHT of the pictures [pixels], and CAMERA_ROTATION, the Euler angles [degrees] of the
        rendering camera in the camera frame of the poses.
    width, height: names of the annotator's init parameters for these sizes.
    """
    arguments = {
        width: config_data["WIDTH"],
        height: config_data["HEIGHT"],
        "cameraRotation": tuple(float(angle) for angle in config_data["CAMERA_ROTATION"]),
    }
    named_annotators.register(annotator, named_annotators.get(annotator, arguments))
