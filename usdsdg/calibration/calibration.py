"""The record of a calibrated camera in OpenCV's terms, and what of it a camera prim gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pxr import Gf, Usd, UsdGeom

from usdsdg.errors import ConfigError

PINHOLE, FISHEYE = "pinhole", "fisheye"
# The order of OpenCV's vectors; those of the pinhole may end after 4, 5, 8 or 12 coefficients.
_NAMES = {
    PINHOLE: ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"),
    FISHEYE: ("k1", "k2", "k3", "k4"),
}
_SCHEMAS = {PINHOLE: "OpenCvPinhole", FISHEYE: "OpenCvFisheye"}
# Of cameras without distortion; the focal length follows from it. The value is that of USD's own cameras.
_APERTURE = 20.955
# Focal lengths that differ by less are those of square pixels: a hundredth of a pixel across 10,000.
_SQUARE = 1e-6


@dataclass(frozen=True)
class Calibration:
    """A calibrated camera. Lengths are in pixels of pictures of `size`; the center of the first pixel is (0, 0)."""

    size: tuple[int, int]  # width, height
    focal: tuple[float, float]  # fx, fy
    center: tuple[float, float]  # cx, cy
    model: str = PINHOLE  # or FISHEYE
    distortion: tuple[float, ...] = ()  # in OpenCV's order

    @property
    def is_straight(self) -> bool:
        """Whether the lens has no distortion: a pinhole, which formats such as BOP can express."""
        return self.model == PINHOLE and not any(self.distortion)

    def undistorted(self) -> Calibration:
        """Return the camera of pictures whose distortion has been removed: the same matrix without distortion."""
        return replace(self, model=PINHOLE, distortion=())


def checked(
    size: Sequence[float],
    focal: Sequence[float],
    center: Sequence[float],
    *,
    model: str,
    distortion: Sequence[float],
    name: str,
) -> Calibration:
    """Return a calibration of values from a file; `name` says which in errors.

    Raises:
        ConfigError: a focal length or a size is not positive, or there are too many coefficients for the model.
    """
    if min(size) < 1 or any(each != int(each) for each in size):
        raise ConfigError(f"{name}: the size of the pictures is {list(size)}; expected width and height in pixels")
    if not min(focal) > 0.0:
        raise ConfigError(f"{name}: the focal lengths are {list(focal)}; expected pixels above 0")
    names, given = _NAMES[model], [float(each) for each in distortion]
    if any(given[len(names) :]):
        kind = (
            "tilted sensors (tau_x, tau_y)" if model == PINHOLE and len(given) == 14 else f"{len(given)} coefficients"
        )
        raise ConfigError(f"{name}: no lens here has a {model} with {kind}; expected at most {', '.join(names)}")
    return Calibration(
        (int(size[0]), int(size[1])),
        (float(focal[0]), float(focal[1])),
        (float(center[0]), float(center[1])),
        model,
        tuple(given[: len(names)]),
    )


def author_calibration(prim: Usd.Prim, calibration: Calibration) -> None:
    """Write the lens of a camera prim: a plain pinhole where that says all, else one of the OpenCV schemas.

    Either way `focalLength` and the apertures are those of the pinhole, for viewers that know no distortion.
    """
    _author_pinhole(UsdGeom.Camera(prim), calibration)
    fx, fy = calibration.focal
    if calibration.is_straight and abs(fx - fy) <= _SQUARE * fx:
        return
    schema, (width, height) = _SCHEMAS[calibration.model], calibration.size
    prefix = f"omni:lensdistortion:{schema[0].lower()}{schema[1:]}:".replace("openCv", "opencv")
    prim.ApplyAPI(f"OmniLensDistortion{schema}API")
    prim.GetAttribute("omni:lensdistortion:model").Set(prefix.split(":")[-2])
    prim.GetAttribute(f"{prefix}imageSize").Set(Gf.Vec2i(width, height))
    # Ours are counted from the corner of the first pixel, OpenCV's from its center.
    values = {"fx": fx, "fy": fy, "cx": calibration.center[0] + 0.5, "cy": calibration.center[1] + 0.5}
    names = _NAMES[calibration.model]
    values |= dict(zip(names, (*calibration.distortion, *(0.0 for _ in names))))
    for name, value in values.items():
        prim.GetAttribute(f"{prefix}{name}").Set(value)


def _author_pinhole(camera: UsdGeom.Camera, calibration: Calibration) -> None:
    (width, height), (cx, cy) = calibration.size, calibration.center
    unit = _APERTURE / width  # of one pixel
    camera.CreateHorizontalApertureAttr(_APERTURE)
    camera.CreateVerticalApertureAttr(height * unit)
    camera.CreateFocalLengthAttr(calibration.focal[0] * unit)
    camera.CreateHorizontalApertureOffsetAttr((width / 2 - (cx + 0.5)) * unit)
    camera.CreateVerticalApertureOffsetAttr((cy + 0.5 - height / 2) * unit)
