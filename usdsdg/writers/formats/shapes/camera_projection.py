"""Projection of points in the camera's frame to pixels, from a camera_params payload alone.

Points behind the camera have no pixel for lenses that divide by depth. Where one is needed they are moved along the
optical axis onto the near plane, so that they stay on their side of the image and are not mirrored through its center.
Those between camera and near plane cannot be seen, but have their pixel: with it, poses can be solved for.
Points outside of a fisheye's field of view are projected outside of the image, on their own side.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.stage.cameras.lens import Lens
from usdsdg.stage.cameras.lens_attributes import EYE_DISTANCE, LEFT_EYE, TEXTURES, LensParameters
from usdsdg.stage.cameras.lenses import make_lens

Params = Mapping[str, Any]
# Line segments per edge for lenses with curved edges. One whose middle is drawn so far [pixels] beside it is halved, so
# many times at most: those of a panorama pass its poles within a few of 256.
_CURVE_SEGMENTS, _BESIDE, _HALVINGS = 32, 0.25, 3


def has_near_plane(params: Params) -> bool:
    """Return whether points behind the camera have no pixel: true for lenses that divide by depth."""
    lens = lens_of(params)
    return params["cameraModel"] != "orthographic" if lens is None else lens.is_flat


def is_straight(params: Params) -> bool:
    """Return whether straight edges are straight in the image."""
    return lens_of(params) is None


def project(points: np.ndarray, params: Params) -> np.ndarray:
    """Project points (N, 3) in the camera's frame to pixels (N, 2): column and row from the top left corner.

    A generalized projection without a texture, which cannot be rendered, is a pinhole here, as in Replicator.
    """
    points = np.array(points, np.float64).reshape(-1, 3)
    if has_near_plane(params):
        points[points[:, 2] >= 0.0, 2] = -_near(params)
    lens = lens_of(params)
    return _by_matrix(points, params) if lens is None else lens.to_pixels(points, extrapolate=True)


def lens_of(params: Params) -> Lens | None:
    """Return the lens that a payload describes; None for projections by a matrix."""
    model = str(params["cameraModel"])
    texture, positions = (str(params.get(name, "")) for name in TEXTURES)
    if model == "generalizedProjection" and not texture:
        return None
    width, height = (int(size) for size in params["renderProductResolution"])
    aperture, offset = float(params["cameraAperture"][0]), params["cameraApertureOffset"]
    x, y = params["cameraFisheyeOpticalCentre"]
    # Payloads of older versions have no cameraOpenCVFx, and five coefficients of the polynomial.
    unset = LensParameters()
    fx, fy = (float(params.get(f"cameraOpenCV{name}", own)) for name, own in zip(("Fx", "Fy"), unset.focal))
    calibration = LensParameters(
        nominal_size=(float(params["cameraFisheyeNominalWidth"]), float(params["cameraFisheyeNominalHeight"])),
        center=(float(x), float(y)),
        focal=(fx, fy),
        max_fov=float(params["cameraFisheyeMaxFOV"]),
        polynomial=_floats(params["cameraFisheyePolynomial"], 6),
        tangential=_floats(params["cameraFisheyeLensP"], 2),
        thin_prism=_floats(params["cameraFisheyeLensS"], 4),
        eye_distance=float(params.get(EYE_DISTANCE, unset.eye_distance * 100)) / 100,
        left_eye=bool(params.get(LEFT_EYE, False)),
        direction_texture=texture,
        position_texture=positions,
    )
    return make_lens(
        model,
        calibration,
        (width, height),
        focal_length=float(params["cameraFocalLength"]),
        horizontal_aperture=aperture,
        center=(width * (0.5 - float(offset[0]) / aperture), height * 0.5 + width * float(offset[1]) / aperture),
        meters_per_unit=float(params["metersPerSceneUnit"]),
    )


def is_pinhole(params: Params) -> bool:
    """Return whether a camera matrix says all of a lens; its pixels need not be square."""
    return params["cameraModel"] == "pinhole" or _straight_lens(params) is not None


def _straight_lens(params: Params) -> Lens | None:
    """Return the lens of an OpenCV pinhole without distortion; None for all others."""
    if params["cameraModel"] != "pinholeOpenCV":
        return None
    names = ("cameraFisheyePolynomial", "cameraFisheyeLensP", "cameraFisheyeLensS")
    return None if any(np.any(params[name]) for name in names) else lens_of(params)


def camera_matrix(params: Params) -> np.ndarray:
    """Return OpenCV's camera matrix (3, 3) of a pinhole; pixel coordinates are 0 at the center of the first pixel."""
    if (lens := _straight_lens(params)) is not None:
        (fx, fy), (cx, cy) = lens.focal, lens.center
        return np.array([[fx, 0.0, cx - 0.5], [0.0, fy, cy - 0.5], [0.0, 0.0, 1.0]])
    width, height = (float(size) for size in params["renderProductResolution"])
    projection = np.asarray(params["cameraProjection"], np.float64).reshape(4, 4)
    return np.array(
        [
            [projection[0, 0] * width / 2, 0.0, (1 - projection[2, 0]) * width / 2 - 0.5],
            [0.0, projection[1, 1] * height / 2, (1 + projection[2, 1]) * height / 2 - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )


def edge_pixels(edges: np.ndarray, params: Params) -> list[np.ndarray]:
    """Project the parts of edges in front of the camera: (M, 2, 2) line segments [pixels] of each edge.

    That is one segment or none, and more where the lens curves edges.

    edges: (N, 2, 3) in the camera's frame.
    """
    pieces = 1 if is_straight(params) else _CURVE_SEGMENTS
    start, along = edges[:, :1], edges[:, 1:] - edges[:, :1]
    points = start + np.linspace(0, 1, pieces + 1)[:, None] * along
    parts = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)
    seen = in_front(parts, params)
    owner = np.repeat(np.arange(len(edges)), pieces)[seen]
    parts = clip_to_front(parts, params)
    for _ in range(_HALVINGS if pieces > 1 else 0):
        parts, owner = _halved_where_bent(parts, owner, params)
    pixels = project(parts, params).reshape(-1, 2, 2)
    if pieces > 1:
        # A segment across the seam of a panorama would be drawn through the whole image.
        short = np.abs(pixels[:, 1] - pixels[:, 0]).max(axis=1) < int(params["renderProductResolution"][0]) / 2
        pixels, owner = pixels[short], owner[short]
    return np.split(pixels, np.searchsorted(owner, np.arange(1, len(edges)))) if len(edges) else []


def _halved_where_bent(segments: np.ndarray, owner: np.ndarray, params: Params) -> tuple[np.ndarray, np.ndarray]:
    """Return segments (N, 2, 3) and the edges that they are of, with those in halves whose middles are beside them."""
    points = np.stack([segments[:, 0], segments.mean(axis=1), segments[:, 1]], axis=1)
    pixels = project(points, params).reshape(-1, 3, 2)
    bent = np.abs(pixels[:, 1] - (pixels[:, 0] + pixels[:, 2]) / 2).max(axis=1) > _BESIDE
    count = 1 + bent
    halves = np.repeat(segments, count, axis=0)
    first = (np.cumsum(count) - count)[bent]
    halves[first, 1] = halves[first + 1, 0] = points[bent, 1]
    return halves, np.repeat(owner, count)


def in_front(segments: np.ndarray, params: Params) -> np.ndarray:
    """Return (N,) bool: of which segments (N, 2, 3) in the camera's frame a part is beyond the near plane."""
    if not has_near_plane(params):
        return np.ones(len(segments), bool)
    beyond = -segments[..., 2] - _near(params) > 0
    return beyond[:, 0] | beyond[:, 1]


def clip_to_front(segments: np.ndarray, params: Params) -> np.ndarray:
    """Clip segments (N, 2, 3) in the camera's frame to the parts (M, 2, 3) beyond the near plane."""
    if not has_near_plane(params):
        return segments
    segments = segments[in_front(segments, params)].copy()
    depth = -segments[..., 2] - _near(params)
    for end, other in ((0, 1), (1, 0)):
        behind = depth[:, end] < 0
        fraction = depth[behind, end] / (depth[behind, end] - depth[behind, other])
        segments[behind, end] += fraction[:, None] * (segments[behind, other] - segments[behind, end])
        depth[behind, end] = 0.0
    return segments


def _near(params: Params) -> float:
    return max(float(params["cameraNearFar"][0]), 1e-6)


def _floats(values: Any, count: int) -> tuple[float, ...]:
    found = [float(value) for value in np.ravel(values)]
    return tuple(found + [0.0] * (count - len(found)))


def _by_matrix(points: np.ndarray, params: Params) -> np.ndarray:
    """Project by the projection matrix: pinhole and orthographic."""
    width, height = params["renderProductResolution"]
    matrix = np.asarray(params["cameraProjection"], np.float64).reshape(4, 4)
    clip = points @ matrix[:3] + matrix[3]
    return np.stack([(clip[:, 0] / clip[:, 3] + 1) * width / 2, (1 - clip[:, 1] / clip[:, 3]) * height / 2], axis=1)
