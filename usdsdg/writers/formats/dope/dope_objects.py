"""The records of objects in DOPE's files: with the numbers of Isaac Sim's node, or exact ones."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.writers.formats.pose.intrinsics import intrinsics
from usdsdg.writers.formats.shapes import cuboid
from usdsdg.writers.formats.shapes.camera_projection import project
from usdsdg.writers.formats.shapes.opencv_frame import TO_OPENCV
from usdsdg.writers.formats.shapes.pose import Pose, quaternion, warn_unless_rigid

# The order of DOPE's own cuboid, which solves for the pose: around the far face, then the near one, and the center.
ORDER = ("RDF", "LDF", "LUF", "RUF", "RDB", "LDB", "LUB", "RUB", cuboid.CENTER)
_CENTIMETERS = 100.0  # per meter


def class_name(labels: Mapping[str, str]) -> str:
    """Return the class of an object as Isaac Sim writes it: YCB's names begin with a digit, those of prims cannot."""
    name = labels.get("class") or ",".join(labels.values())
    return f"0{name.lstrip('_')}" if name.startswith("_") else name


def node_objects(poses: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the objects of an annotation `dope` as it has them."""
    return [
        {
            "class": class_name(poses["idToLabels"][str(row["semanticId"])]),
            "visibility": float(row["visibility"]),
            "location": row["location"].astype(np.float64),
            "quaternion_wxyz": row["rotation"].astype(np.float64),
            "projected_cuboid": row["projected_cuboid"].astype(np.float64),
        }
        for row in poses["data"]
    ]


def exact_objects(boxes: Mapping[str, Any], camera: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the objects of annotations bounding_box_3d and camera_params: x right, y down, z ahead, in centimeters.

    The last keypoint is the center of the box; keypoints behind the camera are moved onto its near plane.
    """
    centimeters = float(camera["metersPerSceneUnit"]) * _CENTIMETERS
    to_opencv = np.eye(4)
    to_opencv[:3, :3] = TO_OPENCV
    objects = []
    for row, prim_path in zip(boxes["data"], boxes["primPaths"], strict=True):
        pose = Pose(row, camera, ORDER)
        warn_unless_rigid("DOPEWriter", prim_path, pose)
        to_camera = pose.local_to_camera @ to_opencv
        real, imaginary = quaternion(to_camera)
        objects.append(
            {
                "class": class_name(boxes["idToLabels"][str(row["semanticId"])]),
                "visibility": 1.0 - float(row["occlusionRatio"]),
                "location": to_camera[3, :3] * centimeters,
                "quaternion_wxyz": [real, *imaginary],
                "projected_cuboid": project(np.array(list(pose.in_camera.values())), camera),
            }
        )
    return objects


def camera_data(camera: Mapping[str, Any]) -> dict[str, Any]:
    """Return size and intrinsics [pixels from the corner of the image], under DOPE's names."""
    width, height = (int(size) for size in camera["renderProductResolution"])
    return {"width": width, "height": height, "intrinsics": intrinsics("DOPEWriter", camera)}
