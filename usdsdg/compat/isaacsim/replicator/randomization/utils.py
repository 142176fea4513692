"""`domain_randomization.utils`: parameters of distributions, points of images, arrays in JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from usdsdg.distribution import Distribution


def set_distribution_params(distribution: Distribution, parameters: Mapping[str, Any]) -> None:
    """Change parameters of a distribution, such as lower and upper, from the next draw on.

    Raises:
        GraphError: (a ValueError) it has no such parameter.
    """
    for name, value in parameters.items():
        distribution.set_input(name, value)


def get_distribution_params(distribution: Distribution, parameters: Sequence[str]) -> list[Any]:
    """Return parameters of a distribution.

    Raises:
        ValueError: it has no such parameter.
    """
    if unknown := [name for name in parameters if name not in distribution.inputs]:
        raise ValueError(f"{distribution.node.describe()} has no parameter {unknown[0]!r}")
    return [distribution.get_input(name) for name in parameters]


def get_image_space_points(points: ArrayLike, view_proj_matrix: ArrayLike) -> np.ndarray:
    """Project points (N, 3) of the world by a row-vector 4x4; return x and y from 0 to 1 over the image, and depth."""
    homogeneous = np.insert(np.asarray(points, np.float64), 3, 1.0, axis=1)
    clip = homogeneous @ np.asarray(view_proj_matrix, np.float64)
    projected = clip[:, :3] / clip[:, 3:]
    projected[:, :2] = (projected[:, :2] + 1.0) / 2.0
    return projected


def calculate_truncation_ratio_simple(corners: ArrayLike, img_width: float, img_height: float) -> float:
    """Return the fraction of the box around image points (N, 2) that is outside of the image; 1 of an empty box."""
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    area = float(np.prod(high - low))
    size = np.array([img_width, img_height])
    inside = float(np.prod(np.clip(high, 0, size) - np.clip(low, 0, size)))
    return 1.0 - inside / area if area > 0.0 else 1.0


class NumpyEncoder(json.JSONEncoder):
    """Writes arrays as lists."""

    def default(self, o: Any) -> Any:
        return o.tolist() if isinstance(o, np.ndarray) else super().default(o)
