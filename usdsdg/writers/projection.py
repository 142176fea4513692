"""Points in the camera's frame to pixels, from a camera_params payload alone.

A point in or behind the plane of a lens with a straight image has no pixel. Where one is needed all the same it is
moved along the optical axis onto the near plane: it keeps its side of the picture, and is never mirrored through the
centre.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.errors import warn_once

Params = Mapping[str, Any]

# Newton steps for the fisheye polynomial; it is close to linear, and three are usual.
_STEPS = 20


def has_near_plane(params: Params) -> bool:
    """Whether points behind the camera have no pixel: true for lenses whose image divides by depth."""
    return params["cameraModel"] not in ("fisheyePolynomial", "orthographic")


def is_straight(params: Params) -> bool:
    """Whether a straight edge is straight in the picture."""
    return params["cameraModel"] != "fisheyePolynomial"


def project(points: np.ndarray, params: Params) -> np.ndarray:
    """Pixels (N, 2), as column and row from the top left corner, of points (N, 3) in the camera's frame.

    Models without a formula here are projected as pinholes, as in Replicator.
    """
    points = np.array(points, np.float64).reshape(-1, 3)
    if has_near_plane(params):
        points[:, 2] = np.minimum(points[:, 2], -_near(params))
    model = {"fisheyePolynomial": _fisheye, "pinholeOpenCV": _opencv}.get(str(params["cameraModel"]), _matrix)
    return model(points, params)


def clip_to_front(segments: np.ndarray, params: Params) -> np.ndarray:
    """The parts (M, 2, 3) of segments (N, 2, 3), in the camera's frame, that lie beyond the near plane."""
    if not has_near_plane(params):
        return segments
    depth = -segments[..., 2] - _near(params)
    segments, depth = segments[(depth > 0).any(axis=1)].copy(), depth[(depth > 0).any(axis=1)]
    for end, other in ((0, 1), (1, 0)):
        behind = depth[:, end] < 0
        share = depth[behind, end] / (depth[behind, end] - depth[behind, other])
        segments[behind, end] += share[:, None] * (segments[behind, other] - segments[behind, end])
        depth[behind, end] = 0.0
    return segments


def _near(params: Params) -> float:
    return max(float(params["cameraNearFar"][0]), 1e-6)


def _matrix(points: np.ndarray, params: Params) -> np.ndarray:
    """By the projection matrix: pinhole and orthographic."""
    width, height = params["renderProductResolution"]
    matrix = np.asarray(params["cameraProjection"], np.float64).reshape(4, 4)
    clip = points @ matrix[:3] + matrix[3]
    return np.stack([(clip[:, 0] / clip[:, 3] + 1) * width / 2, (1 - clip[:, 1] / clip[:, 3]) * height / 2], axis=1)


def _opencv(points: np.ndarray, params: Params) -> np.ndarray:
    """Pinhole with its own focal lengths and centre, in pixels of the nominal size; distortion is left out."""
    nominal, scale = _nominal(params)
    centre = np.asarray(params["cameraFisheyeOpticalCentre"], np.float64)
    centre = np.where(centre != 0, centre, nominal / 2)
    focal = np.array([params["cameraOpenCVFx"], -params["cameraOpenCVFy"]], np.float64)
    return (focal * points[:, :2] / -points[:, 2:] + centre) * scale


def _fisheye(points: np.ndarray, params: Params) -> np.ndarray:
    """The f-theta lens: the angle from the axis is a polynomial of the distance from the centre, in nominal pixels."""
    _, scale = _nominal(params)
    across = np.linalg.norm(points[:, :2], axis=1)
    radius = _radius_of_angle(np.arctan2(across, -points[:, 2]), params["cameraFisheyePolynomial"])
    direction = points[:, :2] * (1, -1) / np.where(across > 0, across, 1.0)[:, None]
    return (np.asarray(params["cameraFisheyeOpticalCentre"], np.float64) + radius[:, None] * direction) * scale


def _radius_of_angle(theta: np.ndarray, polynomial: np.ndarray) -> np.ndarray:
    """Solve theta = a + b r + c r^2 + ... for r."""
    curve = np.polynomial.Polynomial(np.asarray(polynomial, np.float64))
    slope, linear = curve.deriv(), curve.coef[1] if len(curve.coef) > 1 else 0.0
    radius = (theta - curve.coef[0]) / linear if abs(linear) > 1e-10 else theta.copy()
    for _ in range(_STEPS):
        gradient = slope(radius)
        radius = radius - (curve(radius) - theta) / np.where(np.abs(gradient) > 1e-10, gradient, 1.0)
    if np.abs(curve(radius) - theta).max(initial=0.0) > 1e-6:
        warn_once(
            "The fisheye polynomial does not reach some angles; keypoints there are approximate. See fthetaPolyA to F."
        )
    return radius


def _nominal(params: Params) -> tuple[np.ndarray, np.ndarray]:
    """The size that lens parameters are given for, and the factor from its pixels to those of the picture."""
    size = np.asarray(params["renderProductResolution"], np.float64)
    nominal = np.array([params["cameraFisheyeNominalWidth"], params["cameraFisheyeNominalHeight"]], np.float64)
    nominal = np.where(nominal > 0, nominal, size)
    return nominal, size / nominal
