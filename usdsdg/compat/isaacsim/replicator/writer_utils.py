"""`isaacsim.replicator.writers.scripts.utils`: what writers of scripts take from the module of the pose writers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.compat.isaacsim.core.utils.mesh import get_mesh_vertices_relative_to
from usdsdg.compat.isaacsim.core.utils.transformations import (
    get_transform_with_normalized_rotation,
    pose_from_tf_matrix,
    tf_matrix_from_pose,
)
from usdsdg.compat.isaacsim.replicator.randomization.utils import (
    NumpyEncoder,
    calculate_truncation_ratio_simple,
    get_image_space_points,
)
from usdsdg.errors import warn_once
from usdsdg.writers.formats.shapes.camera_projection import project

__all__ = [
    "NumpyEncoder", "calculate_truncation_ratio_simple", "get_image_space_points", "get_mesh_vertices_relative_to",
    "get_transform_with_normalized_rotation", "invert_fisheye_polynomial", "pose_from_tf_matrix",
    "project_fisheye_polynomial", "project_pinhole", "project_pinhole_opencv", "project_point_to_screen",
    "tf_matrix_from_pose",
]  # fmt: skip

# Divisors below this count as zero.
_ZERO = 1e-10


def project_point_to_screen(camera_point: Any, camera_params: Mapping[str, Any]) -> tuple[int, int]:
    """Return the pixel, column and row, of a point in the camera's frame, with the lens that `camera_params` describe.

    Lenses that Isaac Sim does not know here and takes for pinholes have their own pixels. Points behind a pinhole stay
    on their side of the image.

    Args:
        camera_point: (4,), homogeneous, or (3,).
        camera_params: payload of the annotator `camera_params`.
    """
    column, row = project(np.asarray(camera_point, np.float64)[None, :3], camera_params)[0]
    return round(float(column)), round(float(row))


project_pinhole_opencv = project_fisheye_polynomial = project_point_to_screen


def project_pinhole(camera_point: Any, camera_params: Mapping[str, Any]) -> tuple[int, int]:
    """Return the pixel, column and row, of a point (4,) by `cameraProjection` alone.

    A point in the plane of the camera, which has none, gets the middle of the image.
    """
    width, height = (float(size) for size in camera_params["renderProductResolution"])
    x, y, _, w = np.asarray(camera_point, np.float64) @ np.reshape(camera_params["cameraProjection"], (4, 4))
    if abs(w) < _ZERO:
        return round(width / 2), round(height / 2)
    return round(float((x / w + 1) * width / 2)), round(float((1 - y / w) * height / 2))


def invert_fisheye_polynomial(
    theta: float, poly_coeffs: Sequence[float], max_iterations: int = 10, tolerance: float = 1e-6
) -> float:
    """Return the radius r [pixels] with a + b r + c r^2 + ... = theta [rad], by Newton's method.

    Where it has not converged after `max_iterations`, the latest r is returned, with a warning.
    """
    polynomial = np.polynomial.Polynomial([float(each) for each in poly_coeffs])
    slope = polynomial.deriv()
    linear = slope(0.0)
    radius = float((theta - polynomial(0.0)) / linear) if abs(linear) > _ZERO else float(theta)
    for _ in range(max_iterations):
        rise = slope(radius)
        if abs(rise) < _ZERO:
            break
        step = float((polynomial(radius) - theta) / rise)
        radius -= step
        if abs(step) < tolerance:
            return radius
    warn_once(
        f"invert_fisheye_polynomial: no radius was found within {max_iterations} iterations; what is left of theta is "
        f"{abs(float(polynomial(radius) - theta)):.2e}"
    )
    return radius
