"""The camera's frame of OpenCV, which most projects for poses use: x right, y down, z ahead."""

import numpy as np

# From the camera's axes in USD; the same the other way.
TO_OPENCV = np.diag((1.0, -1.0, -1.0))


def opencv_rotation(rotation: np.ndarray, world_to_camera: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3), for column vectors, from an object to the camera.

    rotation: (3, 3) for column vectors, object to world. world_to_camera: (4, 4) for row vectors, of USD.
    """
    return TO_OPENCV @ world_to_camera[:3, :3].T @ rotation


def opencv_position(position: np.ndarray, world_to_camera: np.ndarray) -> np.ndarray:
    """Return where a point (3,) of the world is in the camera, in the same units."""
    return TO_OPENCV @ (position @ world_to_camera[:3, :3] + world_to_camera[3, :3])
