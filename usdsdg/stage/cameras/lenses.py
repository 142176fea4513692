"""Lens models of Replicator's projection types, made from the calibration of a camera.

The formulas are OpenCV's for `pinholeOpenCV` and `fisheyeOpenCV`, those of Isaac Sim's writers for
`fisheyePolynomial`, Project Aria's KannalaBrandtK3 and FisheyeRadTanThinPrism for the two projections of that name, and
the textbook formulas for the ideal fisheyes.
"""

from functools import lru_cache

import numpy as np

from usdsdg import errors
from usdsdg.stage.cameras import lens_curves
from usdsdg.stage.cameras.lens import Lens
from usdsdg.stage.cameras.lens_attributes import OLD_PROJECTIONS, PROJECTIONS, LensParameters
from usdsdg.stage.cameras.lens_curves import ODD, POWER, RATIONAL
from usdsdg.stage.cameras.lens_textures import read_table

# Projections without a lens model: a 4x4 matrix gives their pixels.
LINEAR_PROJECTIONS = ("pinhole", "orthographic")
# Projections with a lens model.
LENS_MODELS = tuple(each for each in (*PROJECTIONS, *OLD_PROJECTIONS) if each not in LINEAR_PROJECTIONS)

# Calibrations without a focal length of their own.
_WITHOUT_FOCAL = ("fisheyeKannalaBrandtK3", "fisheyeRadTanThinPrism")
_IDEAL_FISHEYES = {
    "fisheyeOrthographic": lens_curves.SINE,
    "fisheyeEquidistant": ODD,
    "fisheyeEquisolid": lens_curves.HALF_SINE,
}


def make_lens(
    model: str,
    parameters: LensParameters,
    size: tuple[int, int],
    *,
    focal_length: float,
    horizontal_aperture: float,
    center: tuple[float, float] | None = None,
    meters_per_unit: float = 1.0,
) -> Lens | None:
    """Make the lens of a projection type for images of `size` (width, height); None for linear projections.

    Args:
        focal_length: in the unit of `horizontal_aperture`; these two give the focal length of the models whose
            calibration has none.
        center: optical center of the ideal fisheyes [pixels]; None for the middle of the image.
        meters_per_unit: converts the distance between the eyes to stage units.

    Raises:
        Unsupported: the projection type is not known, or its calibration gives no image.
        AssetError: the texture of a generalized projection is missing or unreadable.
    """
    if model in LINEAR_PROJECTIONS:
        return None
    if model not in LENS_MODELS:
        known = ", ".join((*LINEAR_PROJECTIONS, *LENS_MODELS))
        raise errors.Unsupported(f"projection {model!r} is not available; there are {known}")
    if model == "generalizedProjection":
        return _table_lens(model, parameters, size)
    if model == "fisheyeSpherical":
        return Lens(model, *size)
    if model == "omniDirectionalStereo":
        if not np.isfinite(parameters.eye_distance):
            raise errors.Unsupported(f"the lens {model} cannot be drawn: interpupillaryDistance is not a number")
        offset = parameters.eye_distance / 2 / meters_per_unit
        return Lens(model, *size, eye_offset=-offset if parameters.left_eye else offset)
    return _curve_lens(model, parameters, size, focal_length, horizontal_aperture, center)


def _table_lens(model: str, parameters: LensParameters, size: tuple[int, int]) -> Lens:
    table = read_table(parameters.direction_texture, parameters.position_texture)
    scale = [own / texels for own, texels in zip(size, table.size, strict=True)]
    # The middle of the texture is at the optical center.
    middle = [
        _center_fraction(c, n) * own for c, n, own in zip(parameters.center, parameters.nominal_size, size, strict=True)
    ]
    center = [at - (texels - 1) / 2 * each for at, texels, each in zip(middle, table.size, scale, strict=True)]
    return Lens(model, *size, (scale[0], scale[1]), (center[0], center[1]), table=table)


def _center_fraction(center: float, nominal: float) -> float:
    return center / nominal if center != 0 and nominal > 0 else 0.5


@lru_cache(maxsize=64)
def _curve_lens(
    model: str,
    parameters: LensParameters,
    size: tuple[int, int],
    focal_length: float,
    horizontal_aperture: float,
    center: tuple[float, float] | None,
) -> Lens:
    width, height = size
    if model in (*_IDEAL_FISHEYES, *_WITHOUT_FOCAL) and not focal_length > 0:
        raise errors.Unsupported(f"the lens {model} cannot be drawn: its focalLength is {focal_length:g}")
    if model in _IDEAL_FISHEYES:
        # The edge of the image is at the same angle as that of a pinhole with this focal length and aperture.
        edge = np.arctan(horizontal_aperture / (2.0 * focal_length))
        curve = lens_curves.monotonic_curve(_IDEAL_FISHEYES[model], max_t=np.pi)
        focal = width / (2.0 * float(curve.evaluate(np.array(edge))[0]))
        return Lens(model, width, height, (focal, focal), center or (width / 2, height / 2), curve)
    lens = _calibrated_lens(model, parameters, size, focal_length / horizontal_aperture)
    assert lens.curve is not None
    if not lens.curve.limit > 0 or not min(lens.focal) > 0:
        polynomial = ", ".join(f"{each:g}" for each in parameters.polynomial)
        raise errors.Unsupported(
            f"the lens {model} cannot be drawn: its focal length or its field of view of {parameters.max_fov:g} "
            f"degrees is not positive, or the polynomial {polynomial} does not increase from the image's center"
        )
    return lens


def _calibrated_lens(model: str, parameters: LensParameters, size: tuple[int, int], focal_per_width: float) -> Lens:
    nominal = [given if given > 0 else own for given, own in zip(parameters.nominal_size, size, strict=True)]
    scale = [own / given for given, own in zip(nominal, size, strict=True)]
    center, k, half_fov = parameters.center, parameters.polynomial, np.radians(parameters.max_fov) / 2
    (p0, p1), prism = parameters.tangential, parameters.thin_prism
    focal, tangential, thin_prism = parameters.focal, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if model in ("pinholeOpenCV", "fisheyeOpenCV"):
        center = tuple(given if given != 0 else own / 2 for given, own in zip(center, nominal, strict=True))
    angle = dict(max_t=min(half_fov, np.pi))
    if model == "pinholeOpenCV":
        curve = lens_curves.monotonic_curve(RATIONAL, k)
        tangential, thin_prism = (p0, p1), prism
    elif model == "fisheyePolynomial":
        curve, focal = lens_curves.monotonic_curve(POWER, k, max_value=min(half_fov, np.pi)), (1.0, 1.0)
    elif model == "fisheyeOpenCV":
        curve = lens_curves.monotonic_curve(ODD, (*k[:4], 0.0, 0.0), **angle)
    else:
        focal = (nominal[0] * focal_per_width,) * 2
        curve = lens_curves.monotonic_curve(
            ODD, (*k[:4], 0.0, 0.0) if model == "fisheyeKannalaBrandtK3" else k, **angle
        )
        if model == "fisheyeRadTanThinPrism":
            # In this model the first coefficient is that of x.
            tangential, thin_prism = (p1, p0), prism
    return Lens(
        model,
        *size,
        (focal[0] * scale[0], focal[1] * scale[1]),
        (center[0] * scale[0], center[1] * scale[1]),
        curve,
        tangential,
        thin_prism,  # type: ignore[arg-type]
    )
