"""The three written forms of a calibration: OpenCV's, ROS' and Kalibr's, told apart by their keys."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.calibration.calibration import FISHEYE, PINHOLE, Calibration, checked
from usdsdg.errors import ConfigError

POSE_KEYS = ("translation", "quaternion", "matrix")

_MATRIX = ("camera_matrix", "cameraMatrix", "camera_Matrix", "Camera_Matrix", "intrinsic_matrix", "K", "k")
_DISTORTION = (
    "distortion_coefficients", "Distortion_Coefficients", "dist_coeffs", "distCoeffs", "distortion", "D", "d",
)  # fmt: skip
_WIDTH, _HEIGHT = ("image_width", "image_Width", "width"), ("image_height", "image_Height", "height")
_SIZE = ("image_size", "imageSize", "resolution")
_FISHEYE_FLAGS = ("fisheye_model", "is_fisheye", "fisheye")

# Names of distortion models, as ROS, Kalibr and data sets write them.
_MODELS = {
    "plumb_bob": PINHOLE,
    "rational_polynomial": PINHOLE,
    "radtan": PINHOLE,
    "radial-tangential": PINHOLE,
    "none": PINHOLE,
    "": PINHOLE,
    "equidistant": FISHEYE,
    "equi": FISHEYE,
    "fisheye": FISHEYE,
    "kannala_brandt": FISHEYE,
}
# Camera models of Kalibr without a lens here.
_WITHOUT_LENS = {
    "omni": "the unified omnidirectional model", "ds": "the double sphere", "eucm": "the extended unified model",
}  # fmt: skip

Values = Mapping[str, Any]


def reader_of(values: Values) -> Callable[[Values, str], Calibration] | None:
    """Return the reader of one camera's mapping by its keys; None where they are those of no form."""
    if "intrinsics" in values and not any(key in values for key in _MATRIX):
        return kalibr
    return matrix_form if any(key in values for key in _MATRIX) else None


def cameras_of_chain(values: Values) -> dict[str, Values]:
    """Return the cameras cam0, cam1, … of Kalibr's camchain in their order; {} for other files."""
    found = {name: each for name, each in values.items() if re.fullmatch(r"cam\d+", name) and isinstance(each, Mapping)}
    return dict(sorted(found.items(), key=lambda item: int(item[0][3:])))


def matrix_form(values: Values, name: str) -> Calibration:
    """Return the camera of OpenCV's FileStorage or ROS' camera_info: a 3 x 3 matrix and a list of coefficients.

    Raises:
        ConfigError: keys are missing, or the model has no lens here.
    """
    matrix = _numbers(_first(values, _MATRIX, name), f"{name}: the camera matrix")
    if len(matrix) != 9:
        raise ConfigError(f"{name}: the camera matrix has {len(matrix)} numbers; expected 9")
    (fx, skew, cx), (_, fy, cy), last = np.reshape(matrix, (3, 3)).tolist()
    if skew or last != [0.0, 0.0, 1.0]:
        raise ConfigError(f"{name}: the camera matrix is {matrix}; expected [fx, 0, cx, 0, fy, cy, 0, 0, 1]")
    given = next((values[key] for key in _DISTORTION if key in values), ())
    distortion = _numbers(given, f"{name}: the distortion")
    return checked(
        _size(values, name), (fx, fy), (cx, cy), model=_model(values, name), distortion=distortion, name=name
    )


def kalibr(values: Values, name: str) -> Calibration:
    """Return the camera of Kalibr's form: intrinsics, distortion_coeffs, resolution.

    Raises:
        ConfigError: keys are missing, or the model has no lens here.
    """
    kind = str(values.get("camera_model", "pinhole"))
    if kind != "pinhole":
        what = _WITHOUT_LENS.get(kind, "a model that is not known")
        raise ConfigError(
            f"{name}: camera_model is {kind!r}, {what}, which no lens here has; calibrate with Kalibr's "
            "pinhole-radtan, or pinhole-equi for fisheyes."
        )
    intrinsics = _numbers(_first(values, ("intrinsics",), name), f"{name}: intrinsics")
    if len(intrinsics) != 4:
        raise ConfigError(f"{name}: intrinsics are {intrinsics}; expected [fu, fv, pu, pv]")
    distortion = _numbers(
        values.get("distortion_coeffs", values.get("distortion_coefficients", ())), f"{name}: distortion"
    )
    return checked(
        _size(values, name),
        intrinsics[:2],
        intrinsics[2:],
        model=_model(values, name),
        distortion=distortion,
        name=name,
    )


def _model(values: Values, name: str) -> str:
    if any(values.get(flag) in (1, True, "1", "true") for flag in _FISHEYE_FLAGS):
        return FISHEYE
    written = str(values.get("distortion_model") or "")
    if written.lower() not in _MODELS:
        known = ", ".join(each for each in _MODELS if each)
        raise ConfigError(f"{name}: distortion_model is {written!r}, which no lens here has; expected one of {known}")
    return _MODELS[written.lower()]


def _size(values: Values, name: str) -> Sequence[float]:
    pair = next((values[key] for key in _SIZE if key in values), None)
    if pair is None:
        pair = [_first(values, keys, name) for keys in (_WIDTH, _HEIGHT)]
    size = _numbers(pair, f"{name}: the size of the pictures")
    if len(size) != 2:
        raise ConfigError(f"{name}: the size of the pictures is {pair!r}; expected width and height")
    return size


def _first(values: Values, keys: Sequence[str], name: str) -> Any:
    found = next((values[key] for key in keys if key in values), None)
    if found is None:
        raise ConfigError(f"{name}: {keys[0]} is missing; it has {', '.join(map(str, list(values)[:12]))}")
    return found


def _numbers(given: Any, what: str) -> list[float]:
    """Return the numbers of a list, a list of lists, or a mapping with rows, cols and data."""
    data = given.get("data", ()) if isinstance(given, Mapping) else given
    try:
        numbers = np.asarray(data if data is not None else (), np.float64).ravel()
    except (TypeError, ValueError):
        numbers = np.array([np.nan])
    if not np.isfinite(numbers).all():
        raise ConfigError(f"{what}: {given!r} is not a list of numbers")
    return numbers.tolist()
