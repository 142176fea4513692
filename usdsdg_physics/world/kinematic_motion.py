"""Motion of kinematic bodies to the poses that users set."""

from collections.abc import Callable

import numpy as np


def constant_velocity_motion(
    start: np.ndarray, end: np.ndarray, center: np.ndarray, dt: float
) -> tuple[Callable[[float], np.ndarray], np.ndarray]:
    """Return the motion from one pose (7,) to another at constant linear and angular velocity.

    Args:
        center: center of mass in the body's frame [m]; it moves along a straight line.
        dt: duration [s].

    Returns:
        A function from a fraction of the duration to the pose then, and the velocity (6,) [m/s, rad/s].
    """
    from scipy.spatial.transform import Rotation

    first, last = Rotation.from_quat(start[3:]), Rotation.from_quat(end[3:])
    rotation_vector = (last * first.inv()).as_rotvec()
    from_center, to_center = start[:3] + first.apply(center), end[:3] + last.apply(center)

    def pose(fraction: float) -> np.ndarray:
        rotation = Rotation.from_rotvec(fraction * rotation_vector) * first
        at = from_center + fraction * (to_center - from_center) - rotation.apply(center)
        return np.concatenate([at, rotation.as_quat()])

    return pose, np.concatenate([(to_center - from_center) / dt, rotation_vector / dt])
