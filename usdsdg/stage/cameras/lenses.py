"""Lenses that are no pinholes: from directions to pixels of the picture and back, in NumPy.

The formulas are OpenCV's for `pinholeOpenCV` and `fisheyeOpenCV`, those of Isaac Sim's writers for
`fisheyePolynomial`, Project Aria's KannalaBrandtK3 and FisheyeRadTanThinPrism for the two of that name, and the ideal
fisheyes of textbooks; `lens_panoramas` and `lens_tables` have those without a formula of the angle.
`usdsdg_render/kernels/cameras/lens.py` has the same for kernels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from usdsdg import errors
from usdsdg.stage.cameras import lens_curves, lens_panoramas
from usdsdg.stage.cameras.lens_attributes import OLD_PROJECTIONS, PROJECTIONS, LensParameters
from usdsdg.stage.cameras.lens_curves import ODD, POWER, RATIONAL, Curve
from usdsdg.stage.cameras.lens_tables import LensTable
from usdsdg.stage.cameras.lens_textures import read_table

# Calibrations that tell no focal length.
_WITHOUT_FOCAL = ("fisheyeKannalaBrandtK3", "fisheyeRadTanThinPrism")
# Projections that need no lens model: a straight line for every pixel.
STRAIGHT = ("pinhole", "orthographic")
# Those that have one here.
CURVED = tuple(each for each in (*PROJECTIONS, *OLD_PROJECTIONS) if each not in STRAIGHT)

_STEPS = 50
_IDEAL = {
    "fisheyeOrthographic": lens_curves.SINE,
    "fisheyeEquidistant": ODD,
    "fisheyeEquisolid": lens_curves.HALF_SINE,
}


@dataclass(frozen=True)
class Lens:
    """A lens for pictures of (width, height). It looks along -Z with +Y up; pixels count from the top left corner.

    A direction becomes a point of a plane, at a distance from its center that `curve` tells: of the angle to the axis;
    for RATIONAL of the angle's tangent; POWER tells the angle of a distance. `tangential` and `thin_prism`, in OpenCV's
    order and form, shift that point, and `focal` [pixels] and `center` [pixels] place it in the picture. Instead of a
    curve there may be a `table`, whose places these two put into the picture. Without either, the picture is a
    panorama, longitude by latitude, all around; its columns are seen by an eye that goes round a circle, `eye` [stage
    units] right of the middle as it looks ahead.
    """

    model: str
    width: int
    height: int
    focal: tuple[float, float] = (1.0, 1.0)
    center: tuple[float, float] = (0.0, 0.0)
    curve: Curve | None = None
    tangential: tuple[float, float] = (0.0, 0.0)
    thin_prism: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    eye: float = 0.0
    table: LensTable | None = None

    @property
    def is_flat(self) -> bool:
        """Whether the lens sees only what lies in front of its plane, and clips at distances from that plane."""
        return self.curve is not None and self.curve.kind == RATIONAL

    @property
    def bends(self) -> bool:
        """Whether the picture is not symmetric about the center."""
        return any(self.tangential) or any(self.thin_prism)

    def to_pixels(self, points: np.ndarray, *, beyond: bool = False) -> np.ndarray:
        """Pixels (N, 2), as column and row, of points (N, 3) in the camera's frame.

        What the lens does not see has none: NaN. With `beyond` it gets a place outside of what it sees, on its side of
        the picture, except for points in or behind the plane of a flat lens.
        """
        points = np.asarray(points, np.float64).reshape(-1, 3)
        if self.table is not None:
            return self.table.to_places(points, beyond=beyond) * self.focal + self.center
        if self.curve is None:
            return lens_panoramas.places(points, self.eye, beyond=beyond) * (self.width, self.height)
        across, ahead = np.hypot(points[:, 0], points[:, 1]), -points[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            side = np.where(across[:, None] > 0, points[:, :2] * (1.0, -1.0) / across[:, None], 0.0)
            if self.is_flat:
                t = np.where(ahead > 0, across / ahead, np.nan)
            else:
                t = np.arctan2(across, ahead)
        radius, shifted, seen = self._radius(t)
        plane = radius[:, None] * side + self._shift(shifted[:, None] * side)
        pixels = plane * self.focal + self.center
        return pixels if beyond else np.where(seen[:, None], pixels, np.nan)

    def to_directions(self, pixels: np.ndarray) -> np.ndarray:
        """Unit directions (N, 3) in the camera's frame, of pixels (N, 2); NaN where no light comes through."""
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        plane = (pixels - self.center) / self.focal
        if self.table is not None:
            return self.table.to_directions(plane)
        if self.curve is None:
            return lens_panoramas.directions(pixels / (self.width, self.height))
        if self.bends:
            plane = self._straightened(plane)
        radius = np.hypot(plane[:, 0], plane[:, 1])
        t = radius
        if not self.is_flat or not self.bends:
            t = self.curve.at(radius)[0] if self.curve.kind == POWER else self.curve.solve(radius)
        t = np.where(self._is_seen(radius, t), t, np.nan)
        angle = np.arctan(t) if self.is_flat else t
        with np.errstate(divide="ignore", invalid="ignore"):
            side = np.where(radius[:, None] > 0, plane / radius[:, None], 0.0)
        sine = np.sin(angle)
        return np.stack([sine * side[:, 0], -sine * side[:, 1], -np.cos(angle)], axis=1)

    def to_origins(self, pixels: np.ndarray) -> np.ndarray:
        """Where (N, 3), in the camera's frame, the rays of pixels (N, 2) begin."""
        pixels = np.asarray(pixels, np.float64).reshape(-1, 2)
        return lens_panoramas.origins(pixels / (self.width, self.height), self.eye)

    def _is_seen(self, radius: np.ndarray, t: np.ndarray) -> np.ndarray:
        assert self.curve is not None
        if self.curve.kind == POWER:
            return radius <= self.curve.limit
        if self.is_flat and self.bends:
            return t <= self.curve.limit
        return radius <= self.curve.last

    def _radius(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distance in the plane of angles (or tangents) t, where its shift is taken, and whether it is seen.

        Beyond its end the curve goes on as a straight line.
        """
        assert self.curve is not None
        curve = self.curve
        most = curve.last if curve.kind == POWER else curve.limit
        far = (curve.limit if curve.kind == POWER else curve.last) * np.maximum(t / max(most, 1e-300), 1.0)
        within = np.fmin(t, most)
        radius = curve.solve(within) if curve.kind == POWER else curve.at(within)[0]
        radius, seen = np.where(t > most, far, radius), t <= most
        return radius, within if self.is_flat else np.where(seen, radius, curve.last), seen

    def _shift(self, plane: np.ndarray) -> np.ndarray:
        """What tangential and thin prism distortion add to points (N, 2)."""
        if not self.bends:
            return np.zeros_like(plane)
        (x, y), (p1, p2), (s1, s2, s3, s4) = plane.T, self.tangential, self.thin_prism
        r2 = x * x + y * y
        return np.stack(
            [
                2 * p1 * x * y + p2 * (r2 + 2 * x * x) + s1 * r2 + s2 * r2 * r2,
                p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + s3 * r2 + s4 * r2 * r2,
            ],
            axis=1,
        )

    def _straightened(self, plane: np.ndarray) -> np.ndarray:
        """The points whose shift ends at `plane`, NaN where there are none; of a flat lens, as tangents."""
        assert self.curve is not None
        point = plane.copy()
        if self.is_flat:
            radius = np.hypot(plane[:, 0], plane[:, 1])
            point *= (self.curve.solve(radius) / np.maximum(radius, 1e-300))[:, None]
        with np.errstate(all="ignore"):
            # Points that have none wander off, to where numbers end.
            for _ in range(_STEPS):
                error, ((a, b), (c, d)) = self._error(point, plane)
                step = np.stack([d * error[:, 0] - b * error[:, 1], a * error[:, 1] - c * error[:, 0]], axis=1)
                step /= (a * d - b * c)[:, None]
                point = point - step
                if np.nanmax(np.abs(step), initial=0.0) < 1e-14:
                    break
            error, _ = self._error(point, plane)
            return np.where(np.abs(error).max(axis=1, initial=0.0, keepdims=True) < 1e-9, point, np.nan)

    def _error(self, point: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Miss (N, 2) of points (N, 2), and its Jacobian (2, 2, N)."""
        assert self.curve is not None
        (x, y), (p1, p2), (s1, s2, s3, s4) = point.T, self.tangential, self.thin_prism
        r2 = x * x + y * y
        growth, steeper = np.ones_like(r2), np.zeros_like(r2)
        if self.is_flat:
            t = np.sqrt(r2)
            value, slope = self.curve.at(t)
            growth = np.where(t > 1e-12, value / np.maximum(t, 1e-12), slope)
            steeper = (slope - growth) / np.maximum(r2, 1e-24)
        mixed = 2 * (p1 * x + p2 * y) + steeper * x * y
        s, v = 2 * (s1 + 2 * s2 * r2), 2 * (s3 + 2 * s4 * r2)
        jacobian = np.array(
            [
                [growth + steeper * x * x + 2 * p1 * y + 6 * p2 * x + x * s, mixed + y * s],
                [mixed + x * v, growth + steeper * y * y + 6 * p1 * y + 2 * p2 * x + y * v],
            ]
        )
        return growth[:, None] * point + self._shift(point) - wanted, jacobian


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
    """The lens of a projection type for pictures of `size` (width, height); None for straight projections.

    Args:
        focal_length: as `horizontal_aperture`, in any unit: the models without a focal length of their own have it from
            these two.
        center: of the ideal fisheyes [pixels]; the middle unless the aperture is shifted.
        meters_per_unit: what brings the distance of two eyes to stage units.

    Raises:
        Unsupported: the projection type is not known, or its calibration gives no picture.
        AssetError: the texture of a generalized projection is missing or unreadable.
    """
    if model in STRAIGHT:
        return None
    if model not in CURVED:
        known = ", ".join((*STRAIGHT, *CURVED))
        raise errors.Unsupported(f"projection {model!r} is not available; there are {known}")
    if model == "generalizedProjection":
        return _by_table(model, parameters, size)
    if model == "fisheyeSpherical":
        return Lens(model, *size)
    if model == "omniDirectionalStereo":
        if not np.isfinite(parameters.eye_distance):
            raise errors.Unsupported(f"the lens {model} cannot be drawn: interpupillaryDistance is no number")
        aside = parameters.eye_distance / 2 / meters_per_unit
        return Lens(model, *size, eye=-aside if parameters.left_eye else aside)
    return _by_curve(model, parameters, size, focal_length, horizontal_aperture, center)


def _by_table(model: str, parameters: LensParameters, size: tuple[int, int]) -> Lens:
    table = read_table(parameters.direction_texture, parameters.position_texture)
    scale = [own / texels for own, texels in zip(size, table.size, strict=True)]
    # The texture's middle lies where the optical center is.
    middle = [_shared(c, n) * own for c, n, own in zip(parameters.center, parameters.nominal_size, size, strict=True)]
    center = [at - (texels - 1) / 2 * each for at, texels, each in zip(middle, table.size, scale, strict=True)]
    return Lens(model, *size, (scale[0], scale[1]), (center[0], center[1]), table=table)


def _shared(center: float, nominal: float) -> float:
    return center / nominal if center != 0 and nominal > 0 else 0.5


@lru_cache(maxsize=64)
def _by_curve(
    model: str,
    parameters: LensParameters,
    size: tuple[int, int],
    focal_length: float,
    horizontal_aperture: float,
    center: tuple[float, float] | None,
) -> Lens:
    width, height = size
    if model in (*_IDEAL, *_WITHOUT_FOCAL) and not focal_length > 0:
        raise errors.Unsupported(f"the lens {model} cannot be drawn: its focalLength is {focal_length:g}")
    if model in _IDEAL:
        # The edge of the picture is as far from the axis as a pinhole's of the same focal length and aperture.
        edge = np.arctan(horizontal_aperture / (2.0 * focal_length))
        curve = lens_curves.cut(_IDEAL[model], t_most=np.pi)
        focal = width / (2.0 * float(curve.at(np.array(edge))[0]))
        return Lens(model, width, height, (focal, focal), center or (width / 2, height / 2), curve)
    lens = _calibrated(model, parameters, size, focal_length / horizontal_aperture)
    assert lens.curve is not None
    if not lens.curve.limit > 0 or not min(lens.focal) > 0:
        polynomial = ", ".join(f"{each:g}" for each in parameters.polynomial)
        raise errors.Unsupported(
            f"the lens {model} cannot be drawn: its focal length or its field of view of {parameters.max_fov:g} "
            f"degrees is not positive, or the polynomial {polynomial} does not grow from the picture's center"
        )
    return lens


def _calibrated(model: str, parameters: LensParameters, size: tuple[int, int], focal_per_width: float) -> Lens:
    nominal = [given if given > 0 else own for given, own in zip(parameters.nominal_size, size, strict=True)]
    scale = [own / given for given, own in zip(nominal, size, strict=True)]
    center, k, half_fov = parameters.center, parameters.polynomial, np.radians(parameters.max_fov) / 2
    (p0, p1), prism = parameters.tangential, parameters.thin_prism
    focal, tangential, thin_prism = parameters.focal, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if model in ("pinholeOpenCV", "fisheyeOpenCV"):
        center = tuple(given if given != 0 else own / 2 for given, own in zip(center, nominal, strict=True))
    angle = dict(t_most=min(half_fov, np.pi))
    if model == "pinholeOpenCV":
        curve = lens_curves.cut(RATIONAL, k)
        tangential, thin_prism = (p0, p1), prism
    elif model == "fisheyePolynomial":
        curve, focal = lens_curves.cut(POWER, k, value_most=min(half_fov, np.pi)), (1.0, 1.0)
    elif model == "fisheyeOpenCV":
        curve = lens_curves.cut(ODD, (*k[:4], 0.0, 0.0), **angle)
    else:
        focal = (nominal[0] * focal_per_width,) * 2
        curve = lens_curves.cut(ODD, (*k[:4], 0.0, 0.0) if model == "fisheyeKannalaBrandtK3" else k, **angle)
        if model == "fisheyeRadTanThinPrism":
            # There, the first coefficient is that of x.
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
